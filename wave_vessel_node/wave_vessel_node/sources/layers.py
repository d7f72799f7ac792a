"""What lies over any source of motion: a later sea, the course, slow drift, the smooth start."""

from __future__ import annotations

import math

import numpy as np
from heave_node.interface.waves import Waves, from_start
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import smooth_ramp
from heave_node.numerics.randomness import random_stream

from wave_vessel_node.parameters import DriftParameters
from wave_vessel_node.sea.realisation import HarmonicSum, draw_components
from wave_vessel_node.sea.spectra import TabulatedSpectrum
from wave_vessel_node.sources.motion_source import MotionSource
from wave_vessel_node.vessel.course import Course
from wave_vessel_node.vessel.motion import VesselMotion

_DRIFT_COMPONENTS = 120


def apply_ramp(motion: Array, time: float, duration: float) -> Array:
    """Return r q, (r q)', (r q)'', where r is the ramp.

    Parameters
    ----------
    motion : q, q', q'', shape (3, ...)
    time : since the start of the ramp [s]
    duration : of the ramp [s]
    """
    r, r1, r2 = smooth_ramp(time, duration)
    return np.stack(
        (r * motion[0], r * motion[1] + r1 * motion[0], r * motion[2] + 2.0 * r1 * motion[1] + r2 * motion[0])
    )


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

    def waves(self) -> Waves:
        """See MotionSource: with the ramp."""
        return from_start(self._source.waves(), self._tick_period, self._ramp)


class ChangingSource(MotionSource):
    """One source that goes over into another: cos(p) times the one and sin(p) times the other, p from 0 to pi/2.

    The squares of both factors add to 1: the variance goes from that of the one to that of the other.

    Parameters
    ----------
    first, then : the sources
    start, duration : of the change [s]
    tick_period : [s]
    """

    def __init__(
        self, first: MotionSource, then: MotionSource, start: float, duration: float, tick_period: float
    ) -> None:
        self._first, self._then = first, then
        self._start, self._duration = start, duration
        self._tick_period = tick_period

    def motion(self, tick: int) -> VesselMotion:
        """See MotionSource."""
        motion, later = self._first.motion(tick), self._then.motion(tick)
        ramp = smooth_ramp(tick * self._tick_period - self._start, self._duration)
        angle, rate, acceleration = (0.5 * math.pi * value for value in ramp)
        cosine, sine = math.cos(angle), math.sin(angle)
        of_first = (cosine, -sine * rate, -cosine * rate**2 - sine * acceleration)
        of_then = (sine, cosine * rate, -sine * rate**2 + cosine * acceleration)
        parts = [_weighted(one, weights) for one, weights in ((motion, of_first), (later, of_then))]
        motion.displacement, motion.velocity, motion.acceleration = parts[0] + parts[1]
        motion.elevation = cosine * motion.elevation + sine * later.elevation
        return motion


def _weighted(motion: VesselMotion, weight: tuple[float, float, float]) -> Array:
    """Return w q, (w q)', (w q)'', shape (3, 6), of a motion q and a `weight` w with its first two derivatives."""
    w, w1, w2 = weight
    q, q1, q2 = motion.displacement, motion.velocity, motion.acceleration
    return np.stack((w * q, w * q1 + w1 * q, w * q2 + 2.0 * w1 * q1 + w2 * q))


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

    def waves(self) -> Waves:
        """See MotionSource."""
        return self._source.waves()


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

    def waves(self) -> Waves:
        """See MotionSource."""
        return self._source.waves()
