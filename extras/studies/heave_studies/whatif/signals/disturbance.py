"""What moved the unit and no model explains: kept as a disturbance, out of the depth readings by Wiener's smoother."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array

from heave_studies.whatif.signals.smoother import smoothed

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
