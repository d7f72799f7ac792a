"""Boom-tip motions of the published problems: a record, a sine, a sum of components. Heave and four derivatives."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.randomness import random_stream
from scipy.interpolate import CubicSpline, make_interp_spline

from heave_bringup.benchmark.records import HeaveRecord

HIGHEST = 4
"""Highest derivative that a motion knows."""


class Motion(Protocol):
    """The boom tip."""

    def at(self, time: Array, order: int) -> Array:
        """Return heave [m] and its derivatives up to `order`, shape (order + 1, n), at each `time` [s], shape (n,)."""
        ...


class RecordedMotion:
    """A record, as a cubic spline through its samples; the derivatives above the second are those of a quintic one.

    A cubic spline is smooth in speed and acceleration, which a motion reference unit gives; the fourth derivative,
    which only an inversion with perfect preview demands, needs a smoother one.
    """

    def __init__(self, record: HeaveRecord) -> None:
        self._end = float(record.time[-1])
        cubic = CubicSpline(record.time, record.heave)
        smooth = make_interp_spline(record.time, record.heave, k=5)
        self._parts = [cubic, cubic.derivative(1), cubic.derivative(2), smooth.derivative(3), smooth.derivative(4)]

    def at(self, time: Array, order: int) -> Array:
        """See `Motion.at`. Beyond the record's end the values are those of its end."""
        t = np.minimum(time, self._end)
        return np.array([part(t) for part in self._parts[: order + 1]])


class HarmonicMotion:
    """A sum of a sin(w t + p), growing from rest over a ramp.

    Parameters
    ----------
    frequency, amplitude, phase : w [rad/s], a [m], p [rad], shape (n,)
    ramp : time over which it grows, as s^3 (10 - 15 s + 6 s^2), s = t/ramp, twice differentiable [s]; 0 is none
    """

    def __init__(self, frequency: Array, amplitude: Array, phase: Array, *, ramp: float = 0.0) -> None:
        self._w, self._a, self._p = frequency, amplitude, phase
        self._ramp = ramp

    def at(self, time: Array, order: int) -> Array:
        """See `Motion.at`."""
        turned = self._a * np.exp(1j * (np.outer(time, self._w) + self._p))
        waves = np.array([np.sum(turned * (1j * self._w) ** k, axis=1).imag for k in range(order + 1)])
        if self._ramp == 0.0:
            return waves
        grown = _ramp(time / self._ramp, self._ramp, order)
        products = [sum(math.comb(n, k) * grown[k] * waves[n - k] for k in range(n + 1)) for n in range(order + 1)]
        return np.array(products)


def _ramp(share: Array, length: float, order: int) -> Array:
    """Return the ramp and its derivatives at shares of its length [s], shape (order + 1, n)."""
    polynomial = np.polynomial.Polynomial([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])
    over = np.minimum(share, 1.0)
    rows = [polynomial(over)]
    rows += [np.where(share < 1.0, polynomial.deriv(k)(over) / length**k, 0.0) for k in range(1, order + 1)]
    return np.array(rows)


def sine(amplitude: float, period: float, *, ramp: float) -> HarmonicMotion:
    """Return amplitude sin(2 pi t/period), grown over a ramp [s]."""
    return HarmonicMotion(np.array([2.0 * math.pi / period]), np.array([amplitude]), np.zeros(1), ramp=ramp)


def mas409_sea(seed: int, *, ramp: float) -> HarmonicMotion:
    """Return the sea of course MAS409 (University of Agder): Hs 1.7 m, T1 10 s, 20 components from 0.1 to 2 rad/s.

    S = A/w^5 exp(-B/w^4), A = 0.11 Hs^2 w1^4, B = 0.44 w1^4, w1 = 2 pi/T1; amplitudes sqrt(2 S dw), random phases
    that `seed` fixes. It grows from rest over `ramp` [s].
    """
    frequency = np.linspace(0.1, 2.0, 20)
    mean = 2.0 * math.pi / 10.0
    spectrum = 0.11 * 1.7**2 * mean**4 / frequency**5 * np.exp(-0.44 * mean**4 / frequency**4)
    amplitude = np.sqrt(2.0 * spectrum * (frequency[1] - frequency[0]))
    phase = random_stream(seed, "benchmark/mas409_sea").uniform(-math.pi, math.pi, frequency.size)
    return HarmonicMotion(frequency, amplitude, phase, ramp=ramp)
