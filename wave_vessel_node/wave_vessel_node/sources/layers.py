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
from wave_vessel_node.vessel.motion import VesselMotions

_DRIFT_COMPONENTS = 120


def weighted(six: Array, weights: Array) -> Array:
    """Return w q, (w q)', (w q)'', shape (n, 3, 6).

    Parameters
    ----------
    six : q, q', q'', shape (n, 3, 6)
    weights : w, w', w'', shape (n, 3)
    """
    (w, w1, w2), (q, q1, q2) = weights.T[:, :, None], six.swapaxes(0, 1)
    return np.stack((w * q, w * q1 + w1 * q, w * q2 + 2.0 * w1 * q1 + w2 * q), axis=1)


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

    def motions(self, ticks: range) -> VesselMotions:
        """See MotionSource."""
        motions = self._source.motions(ticks)
        since_start = [(tick - 1) * self._tick_period for tick in ticks[: len(motions.time)]]
        if since_start[0] < self._ramp:
            ramp = np.array([smooth_ramp(time, self._ramp) for time in since_start])
            motions.six = weighted(motions.six, ramp)
            motions.elevation = motions.elevation * ramp[:, 0]
        return motions

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

    def motions(self, ticks: range) -> VesselMotions:
        """See MotionSource."""
        motions, later = self._first.motions(ticks), self._then.motions(ticks)
        of_first, of_then = np.array([self._weights(time) for time in motions.time.tolist()]).swapaxes(0, 1)
        motions.six = weighted(motions.six, of_first) + weighted(later.six, of_then)
        motions.elevation = of_first[:, 0] * motions.elevation + of_then[:, 0] * later.elevation
        return motions

    def _weights(self, time: float) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """Return the weights of both sources at a `time` [s], each with its first two derivatives."""
        ramp = smooth_ramp(time - self._start, self._duration)
        angle, rate, acceleration = (0.5 * math.pi * value for value in ramp)
        cosine, sine = math.cos(angle), math.sin(angle)
        return (
            (cosine, -sine * rate, -cosine * rate**2 - sine * acceleration),
            (sine, cosine * rate, -sine * rate**2 + cosine * acceleration),
        )


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

    def motions(self, ticks: range) -> VesselMotions:
        """See MotionSource."""
        motions, course = self._source.motions(ticks), self._course
        times = motions.time[:1] if len(course.legs) == 1 else motions.time  # on one leg nothing changes
        found = [(course.heading(t), course.turn_rate(t), course.turn_acceleration(t), course.speed(t)) for t in times]
        columns = np.broadcast_to(np.transpose(found), (4, len(motions.time)))
        motions.heading, motions.turn_rate, motions.turn_acceleration, motions.speed = columns
        return motions

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

    def motions(self, ticks: range) -> VesselMotions:
        """See MotionSource."""
        motions = self._source.motions(ticks)
        for axis, harmonics in enumerate(self._sums):
            motions.six[:, :, axis] += harmonics.at(ticks[: len(motions.time)])[:, :, 0]
        return motions

    def waves(self) -> Waves:
        """See MotionSource."""
        return self._source.waves()
