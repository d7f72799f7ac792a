"""What lies over any source of motion: the course, slow drift, the smooth start."""

from __future__ import annotations

import math

import numpy as np
from heave_node.numerics.randomness import random_stream

from wave_vessel_node.parameters import DriftParameters
from wave_vessel_node.ramp import apply_ramp
from wave_vessel_node.sea.realisation import HarmonicSum, draw_components
from wave_vessel_node.sea.spectra import TabulatedSpectrum
from wave_vessel_node.sources.motion_source import MotionSource
from wave_vessel_node.vessel.course import Course
from wave_vessel_node.vessel.motion import VesselMotion

_DRIFT_COMPONENTS = 120


class RampedSource(MotionSource):
    """Another source, growing from rest over a ramp; at the first tick (number 1) everything is still.

    Parameters
    ----------
    source : what the vessel does without the ramp
    ramp : length of the ramp [s]
    tick_period : [s]
    """

    def __init__(self, source: MotionSource, ramp: float, tick_period: float) -> None:
        self._source = source
        self._ramp = ramp
        self._tick_period = tick_period

    def motion(self, tick: int) -> VesselMotion:
        """See MotionSource."""
        motion = self._source.motion(tick)
        since_start = (tick - 1) * self._tick_period
        if since_start < self._ramp:
            six = np.stack((motion.displacement, motion.velocity, motion.acceleration))
            motion.displacement, motion.velocity, motion.acceleration = apply_ramp(six, since_start, self._ramp)
            motion.elevation *= float(apply_ramp(np.array([1.0, 0.0, 0.0]), since_start, self._ramp)[0])
        return motion


class CourseSource(MotionSource):
    """Another source on a course, whose heading, rate of turn and speed turn the axes and disturb the MRU.

    Parameters
    ----------
    source : motion about the mean course
    course : of the vessel
    """

    def __init__(self, source: MotionSource, course: Course) -> None:
        self._source = source
        self._course = course

    def motion(self, tick: int) -> VesselMotion:
        """See MotionSource."""
        motion = self._source.motion(tick)
        motion.heading = self._course.heading(motion.time)
        motion.turn_rate = self._course.turn_rate(motion.time)
        motion.turn_acceleration = self._course.turn_acceleration(motion.time)
        motion.speed = self._course.speed(motion.time)
        return motion


class DriftingSource(MotionSource):
    """Another source with slow drift in surge and sway: narrow-band noise about the natural period of position keeping.

    Parameters
    ----------
    source : motion without drift
    drift : its size, period and damping
    seed : of the drift
    tick_period : [s]
    """

    def __init__(self, source: MotionSource, drift: DriftParameters, seed: int, tick_period: float) -> None:
        self._source = source
        natural = 2.0 * math.pi / drift.period
        omega = np.linspace(0.05, 3.0, 300) * natural
        resonance = (natural**2 - omega**2) ** 2 + (2.0 * drift.damping_ratio * natural * omega) ** 2
        spectrum = TabulatedSpectrum(omega, 1.0 / resonance, name="slow drift")
        self._sums = []
        for axis, deviation in zip(("surge", "sway"), drift.standard_deviation, strict=True):
            generator = random_stream(seed, f"wave_vessel/drift/{axis}")
            sea = draw_components(spectrum, _DRIFT_COMPONENTS, generator)
            amplitude = sea.amplitude * deviation / math.sqrt(spectrum.moment(0))
            self._sums.append(HarmonicSum(sea.frequency, amplitude * np.exp(1j * sea.phase), tick_period))

    def motion(self, tick: int) -> VesselMotion:
        """See MotionSource."""
        motion = self._source.motion(tick)
        for axis, harmonics in enumerate(self._sums):
            value, rate, acceleration = harmonics.at(tick)[:, 0]
            motion.displacement[axis] += value
            motion.velocity[axis] += rate
            motion.acceleration[axis] += acceleration
        return motion
