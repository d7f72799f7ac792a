"""What lies over any source of motion: a later sea, the heading, the smooth start."""

from __future__ import annotations

import math

import numpy as np
from heave_node.interface.waves import Waves, from_start
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import smooth_ramp

from wave_vessel_node.sources.motion_source import MotionSource
from wave_vessel_node.vessel.motion import VesselMotions


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
    """Another source on its heading, growing from rest over a ramp; at the first tick (number 1) everything is still.

    Parameters
    ----------
    source : what the vessel does without the ramp
    heading : of the vessel from world x [rad]
    ramp : length of the ramp [s]
    tick_period : [s]
    """

    def __init__(self, source: MotionSource, heading: float, ramp: float, tick_period: float) -> None:
        self._source = source
        self._heading, self._ramp = heading, ramp
        self._tick_period = tick_period

    def motions(self, ticks: range) -> VesselMotions:
        """See MotionSource."""
        motions = self._source.motions(ticks)
        motions.heading = self._heading
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
