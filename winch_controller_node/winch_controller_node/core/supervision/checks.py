"""Trends of readings."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array

REMEMBERED, LEAST_READINGS = 4096, 4
"""Readings of a trend that are kept, at least, and that a slope needs."""


@dataclass(frozen=True, slots=True)
class Slope:
    """Slope of a straight line through readings.

    Attributes
    ----------
    value, error : slope and its standard error, in units of the readings per second
    """

    value: float
    error: float


class Trend:
    """The newest readings, in the order of their times."""

    def __init__(self) -> None:
        self._times: Array = np.empty(2 * REMEMBERED)
        self._values: Array = np.empty(2 * REMEMBERED)
        self._count = 0
        self._changed = -math.inf

    def add(self, time: float, value: float) -> None:
        """Take in a reading `value` of a `time` [s]; one that is no later than the last one is left out."""
        if self._count and time <= self._times[self._count - 1]:
            return
        if not self._count or value != self._values[self._count - 1]:
            self._changed = time
        if self._count == self._times.size:
            for array in (self._times, self._values):
                array[:REMEMBERED] = array[REMEMBERED:]
            self._count = REMEMBERED
        self._times[self._count], self._values[self._count] = time, value
        self._count += 1

    def has_stood(self, window: float) -> bool:
        """Return whether all readings of the last `window` seconds are equal; True without readings."""
        return self._count == 0 or self._changed <= float(self._times[self._count - 1]) - window

    def mean(self, window: float) -> float:
        """Return the mean over the last `window` seconds; 0 without readings."""
        if not self._count:
            return 0.0
        times = self._times[: self._count]
        return float(np.mean(self._values[np.searchsorted(times, times[-1] - window) : self._count]))

    def slope(self, window: float) -> Slope | None:
        """Return the slope over the last `window` seconds; None: they hold too few readings."""
        times, values = self._times[: self._count], self._values[: self._count]
        if times.size < LEAST_READINGS or times[-1] - times[0] < 0.9 * window:
            return None
        first = np.searchsorted(times, times[-1] - window)
        times, values = times[first:], values[first:]
        if times.size < LEAST_READINGS:
            return None
        about = times - times.mean()
        spread = float(about @ about)
        slope = float(about @ values) / spread
        rest = values - values.mean() - slope * about
        return Slope(slope, math.sqrt(float(rest @ rest) / (times.size - 2) / spread))
