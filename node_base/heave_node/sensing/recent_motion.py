"""The value, rate and acceleration of a quantity now, from its last samples: a parabola by least squares."""

from __future__ import annotations

from collections import deque

import numpy as np

WINDOW = 0.6
"""Samples of so long are used [s]: a twelfth of a short sea's period, so that a parabola fits it within 1 %."""
OLDEST = 1.0
"""A newest sample older than this says nothing of now [s]."""


class RecentMotion:
    """The last samples of one quantity."""

    def __init__(self) -> None:
        self._samples: deque[tuple[float, float]] = deque(maxlen=400)

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
        value, rate, acceleration = np.linalg.lstsq(columns, values, rcond=None)[0]
        return float(value), float(rate), float(acceleration)
