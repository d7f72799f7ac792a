"""Transforms of readings at their own times, and the transfer function of the cable, exact in space."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from cable_sim_node.vertical.axial_line import AxialLine
from heave_node.numerics.arrays import Array, ComplexArray

BAND = (0.25, 4.0)
"""Angular frequencies of waves, which are judged [rad/s]."""

QUIET, HIGHEST = 5.0, 0.9
"""Angular frequency above which what is read is noise, but for narrow resonances [rad/s]; and share of the highest that
the readings can show, up to which it is looked at."""

QUIET_COUNT, LEAST_BAND = 400, 1.2
"""Number of quiet frequencies that are looked at; and least ratio of the highest to the lowest of them."""

RANDOM_DRAG = math.sqrt(8.0 / math.pi)
"""Linear damping over quadratic drag and the standard deviation of a Gaussian speed (Borgman, The spectral density for
ocean wave forces, 1965)."""


class Transform:
    """Fourier transform of readings at their own times under a Hann taper.

    Parameters
    ----------
    times : of the readings (n,) [s]
    omegas : angular frequencies (k,), evenly spaced [rad/s]
    start, end : of the taper [s]

    The readings' own spacing is their weight, so that no interpolation bends what is fast. Each frequency is one of
    sqrt(k) coarse ones and one of sqrt(k) fine steps, so that exponentials are of these alone.
    """

    def __init__(self, times: Array, omegas: Array, start: float, end: float) -> None:
        self._inside = (times >= start) & (times <= end)
        t = times[self._inside]
        self._weight = np.sin(math.pi * (t - start) / (end - start)) ** 2
        spacing = float(np.median(np.diff(t)))
        # the taper's own power is one, whatever the length of the record
        scale = spacing / math.sqrt(spacing * float(self._weight @ self._weight))
        self._count, fine = len(omegas), math.ceil(math.sqrt(len(omegas)))
        self._coarse = scale * np.exp(-1j * np.outer(omegas[::fine], t))
        self._fine = np.exp(-1j * np.outer(t, omegas[:fine] - omegas[0]))

    def __call__(self, values: Array) -> ComplexArray:
        """Return the transform (k,) of `values` read at the times (n,), about their mean."""
        v, weight = values[self._inside], self._weight
        v = v - float(weight @ v) / float(np.sum(weight))
        return np.asarray(((self._coarse * (weight * v)) @ self._fine).ravel()[: self._count])


def tapered_transform(times: Array, values: Array, omegas: Array, start: float, end: float) -> ComplexArray:
    """Return the Fourier transform (k,) of readings under a Hann taper.

    Parameters
    ----------
    times, values : of the readings (n,) [s], any unit
    omegas, start, end : as for `Transform`
    """
    return Transform(times, omegas, start, end)(values)


def noise_power(times: Array, values: Array, start: float, end: float, stated: float) -> float:
    """Return the power of the white noise in readings in the units of `tapered_transform`.

    Parameters
    ----------
    times, values : of the readings (n,) [s], any unit
    start, end : of the taper [s]
    stated : standard deviation of the noise, taken where the readings are too seldom to show it
    """
    spacing = float(np.median(np.diff(times)))
    highest = HIGHEST * math.pi / spacing
    if highest < LEAST_BAND * QUIET:
        return stated**2 * spacing
    omegas = np.linspace(QUIET, highest, QUIET_COUNT)
    return noise_level(np.abs(tapered_transform(times, values, omegas, start, end)) ** 2)


def noise_level(power: Array) -> float:
    """Return the power of white noise in a periodogram, `power` at quiet frequencies: no narrow resonance moves it.

    The median of an exponential distribution is log 2 of its mean.
    """
    return float(np.median(power)) / math.log(2.0)


class Speeds(NamedTuple):
    """Standard deviation of the vertical speed of the cable's ends, by which drag is linearised."""

    unit: float  # of the lower end [m/s]
    top: float  # of the end at the outlet [m/s]


def gains_over_top(line: AxialLine, length: float, omegas: Array, speeds: Speeds) -> ComplexArray:
    """Return heave of the unit, and the top tension [N/m], over the heave of the cable's top end, (2, k).

    Parameters
    ----------
    line : cable and unit
    length : unstretched cable [m]
    omegas : angular frequencies (k,) [rad/s]
    speeds : by which the drag of unit and cable is linearised

    Each piece is a bar: its state (elevation u, tension T) goes up by the matrix [[cos ks, sin ks / (EA k)],
    [-EA k sin ks, cos ks]], k^2 = (m w^2 - i c w)/EA (Clough and Penzien, Dynamics of Structures, section 17-5).
    """
    damping = RANDOM_DRAG * line.unit.drag * speeds.unit
    u = np.ones(len(omegas), dtype=complex)
    T = -(omegas**2) * line.unit.inertia + 1j * omegas * damping
    height = 0.0
    for piece in line.pieces(length):
        for body in piece.clumps:
            T = T + (-(omegas**2) * body.inertia + 1j * omegas * RANDOM_DRAG * body.drag * speeds.unit) * u
        share = (height + 0.5 * piece.length) / length
        speed = math.hypot((1.0 - share) * speeds.unit, share * speeds.top)
        stiffness = piece.axial_stiffness * (1.0 + 1j * omegas * piece.damping_time)
        k = np.sqrt((piece.mass * omegas**2 - 1j * omegas * RANDOM_DRAG * piece.drag * speed) / stiffness)
        c, s = np.cos(k * piece.length), np.sin(k * piece.length)
        u, T = c * u + s / (stiffness * k) * T, -stiffness * k * s * u + c * T
        height += piece.length
    return np.array([1.0 / u, T / u])
