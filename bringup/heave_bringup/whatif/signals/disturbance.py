"""What moved the unit and no model explains: kept as a disturbance, out of the depth readings by Wiener's smoother."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array

from heave_bringup.whatif.signals.spectra import QUIET, noise_level
from heave_bringup.whatif.signals.tip import smooth_spectrum, smoothed_count

WAVES = (0.2, 4.0)
"""Angular frequencies of the motion that waves, and the unit on its cable, bring about [rad/s]."""

CHANCE = 1.6
"""Standard deviations of a smoothed spectrum of noise up to which it is noise."""

LEAST_QUIET = 20
"""Fewer quiet frequencies than this do not tell the noise; it is then taken from the parameters."""


class Disturbance(NamedTuple):
    """Motion of the unit that its twin does not explain.

    Attributes
    ----------
    heave : at each tick, about its mean, positive up (n,) [m]
    waves : standard deviation of it where waves are [m]
    left : standard deviation of the sensor's noise that is in it [m]
    noise : standard deviation of a depth reading [m]
    chi2 : mean square of the twin's error over that of the noise, where waves are [-]
    """

    heave: Array
    waves: float
    left: float
    noise: float
    chi2: float


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
    gap = gap - gap.mean()
    omega = np.asarray(2.0 * math.pi * np.fft.rfftfreq(count, period), dtype=np.float64)
    transform = np.fft.rfft(gap)
    power = np.abs(transform) ** 2
    quiet = power[omega > QUIET]
    reported = noise_level(quiet) if quiet.size >= LEAST_QUIET else count * stated_noise**2
    smooth = smooth_spectrum(power, omega)
    # what chance alone may raise over the noise is none
    chance = reported * (1.0 + CHANCE / math.sqrt(smoothed_count(omega)))
    kept = np.where(omega <= WAVES[1], np.clip(1.0 - chance / np.maximum(smooth, 1e-300), 0.0, 1.0), 0.0)
    kept[0] = 0.0
    inside = (omega >= WAVES[0]) & (omega <= WAVES[1])
    motion = np.fft.irfft(kept * transform, count)
    waves = (kept * smooth)[inside]
    return Disturbance(
        heave=np.interp(time, grid, motion),
        waves=math.sqrt(2.0 * float(np.sum(waves)) / count**2),
        left=math.sqrt(2.0 * float(kept @ kept) * reported / count**2),
        noise=math.sqrt(reported / count),
        chi2=float(np.mean(power[inside]) / reported),
    )
