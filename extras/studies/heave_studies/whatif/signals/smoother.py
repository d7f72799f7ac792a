"""Wiener's smoother: of readings of a whole record, what stands above their noise.

Wiener, Extrapolation, Interpolation and Smoothing of Stationary Time Series (1949), in the frequency domain: each
frequency is weighed by the share of its power that is no noise. One rule for boom tip, unit and drum.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array
from scipy.fft import dct, idct

from heave_studies.whatif.signals.spectra import QUIET

SMOOTHED = 0.01
"""Half the width over which a spectrum is smoothed [Hz]."""

CHANCE = 1.6
"""Standard deviations of a smoothed spectrum of noise up to which it is noise."""

LEAST_QUIET = 20
"""Fewer quiet frequencies than this do not tell the noise; it is then taken as stated."""


class Smoothed(NamedTuple):
    """What stands above the noise in a series of n values."""

    values: Array  # of the series without its noise (n,)
    omega: Array  # angular frequencies (n,) [rad/s]
    power: Array  # of the series at each, of which the sum is that of the squares of its values (n,)
    smooth: Array  # the same, smoothed (n,)
    kept: Array  # share of each frequency that was kept (n,) [-]
    noise: float  # variance of a value by white noise [m^2]


def smoothed(values: Array, period: float, stated: float = 0.0, highest: float = math.inf) -> Smoothed:
    """Return what stands above the noise in a series, mirrored at both ends: it need not begin as it ends.

    Parameters
    ----------
    values : of the series (n,)
    period : from one to the next [s]
    stated : standard deviation of their noise, where they are too seldom to show it
    highest : angular frequency above which nothing is kept [rad/s]
    """
    omega = np.asarray(math.pi / (len(values) * period) * np.arange(len(values)), dtype=np.float64)
    series = np.asarray(dct(values, norm="ortho"))
    smooth, count = smooth_spectrum(series**2, omega), smoothed_count(omega)
    quiet = smooth[omega > QUIET]
    # the median of a mean of so many squares is below their mean (Wilson and Hilferty, 1931)
    noise = float(np.median(quiet)) / (1.0 - 2.0 / (9.0 * count)) ** 3 if quiet.size >= LEAST_QUIET else stated**2
    kept = np.where(omega <= highest, wiener_gain(smooth, noise, math.sqrt(2.0 / count)), 0.0)
    return Smoothed(np.asarray(idct(kept * series, norm="ortho")), omega, series**2, smooth, kept, noise)


def wiener_gain(smooth: Array, noise: Array | float, spread: float) -> Array:
    """Return the share of each frequency that is no noise [-].

    Parameters
    ----------
    smooth : smoothed power of the readings (k,)
    noise : of it, by noise alone (k,)
    spread : standard deviation of a smoothed spectrum of noise, over its mean [-]: what it may raise by chance is none
    """
    return np.clip(1.0 - (1.0 + CHANCE * spread) * noise / np.maximum(smooth, 1e-300), 0.0, 1.0)


def smooth_spectrum(power: Array, omega: Array) -> Array:
    """Return a spectrum, `power` at evenly spaced angular frequencies `omega` [rad/s], as its moving mean."""
    about = np.ones(smoothed_count(omega))
    return np.asarray(np.convolve(power, about, "same") / np.convolve(np.ones_like(power), about, "same"))


def smoothed_count(omega: Array) -> int:
    """Return how many of the angular frequencies `omega` [rad/s] are averaged in a smoothed spectrum."""
    return 2 * max(1, round(2.0 * math.pi * SMOOTHED / float(omega[1] - omega[0]))) + 1


WAVES = (0.2, 4.0)
"""Angular frequencies of the motion that waves, and the unit on its cable, bring about [rad/s]."""


class Disturbance(NamedTuple):
    """Motion of the unit that its twin does not explain."""

    heave: Array  # at each tick, about its mean, positive up (n,) [m]
    waves: float  # standard deviation of it where waves are [m]
    left: float  # standard deviation of the sensor's noise that is in it [m]
    noise: float  # standard deviation of a depth reading [m]
    chi2: float  # mean square of the twin's error over that of the noise, where waves are [-]


def disturbance(readings: Array, time: Array, twin: Array, stated_noise: float) -> Disturbance:
    """Return what of the readings of a sensor its twin does not explain.

    Parameters
    ----------
    readings : times and values, of the unit's heave for example, shape (m, 2)
    time : of each tick (n,) [s]
    twin : what the twin has at each tick (n,)
    stated_noise : of a reading, where the readings do not tell it
    """
    times, values = readings.T
    order = np.argsort(times, kind="stable")
    times, values = times[order], values[order]
    period = float(np.median(np.diff(times)))
    count = round((times[-1] - times[0]) / period) + 1
    grid = times[0] + period * np.arange(count)
    gap = np.interp(grid, times, values) - np.interp(grid, time, twin)
    found = smoothed(gap - gap.mean(), period, stated_noise, WAVES[1])
    inside = (found.omega >= WAVES[0]) & (found.omega <= WAVES[1])
    return Disturbance(
        heave=np.interp(time, grid, found.values),
        waves=math.sqrt(float(np.sum((found.kept * found.smooth)[inside])) / count),
        left=math.sqrt(float(found.kept @ found.kept) * found.noise / count),
        noise=math.sqrt(found.noise),
        chi2=float(np.mean(found.power[inside]) / found.noise),
    )
