"""The value, rate and acceleration of a quantity now, from its last samples: a parabola by least squares."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

WINDOW = 0.6
"""Samples of so long are used [s]: a twelfth of a short sea's period, so that a parabola fits it within 1 %."""
OLDEST = 1.0
"""A newest sample older than this says nothing of now [s]."""
_KEPT = 0.99
"""Weight of the scatter of all samples before, each time that the next is added to it."""


class RecentMotion:
    """The last samples of one quantity; `rate_sigma` is the standard deviation of the last rate, NaN: not known."""

    def __init__(self) -> None:
        self._samples: deque[tuple[float, float]] = deque(maxlen=400)
        self.rate_sigma = math.nan
        self._squares = self._freedom = 0.0

    def add(self, time: float, value: float) -> None:
        """Take a `value` at a `time` [s]; one that is not later than the one before is left out."""
        if self._samples and time <= self._samples[-1][0]:
            return
        if self._samples and time - self._samples[-1][0] > OLDEST:
            self._samples.clear()
        self._samples.append((time, value))
        while self._samples[-1][0] - self._samples[0][0] > WINDOW:
            self._samples.popleft()

    def at(self, time: float) -> tuple[float, float, float] | None:
        """Return value, rate and second derivative at a `time` [s] of now; None with fewer than three samples."""
        if len(self._samples) < 3 or time - self._samples[-1][0] > OLDEST:
            return None
        times, values = np.array(self._samples).T
        since = times - time
        columns = np.stack([np.ones_like(since), since, 0.5 * since**2], axis=1)
        value, rate, acceleration = found = np.linalg.lstsq(columns, values, rcond=None)[0]
        self._squares = _KEPT * self._squares + float(np.sum((values - columns @ found) ** 2))
        self._freedom = _KEPT * self._freedom + len(times) - len(found)
        if self._freedom > 0.0:
            self.rate_sigma = math.sqrt(self._squares / self._freedom * np.linalg.inv(columns.T @ columns)[1, 1])
        return float(value), float(rate), float(acceleration)
