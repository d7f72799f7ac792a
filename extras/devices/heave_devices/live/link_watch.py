"""The timing of one device: rate, gaps, bursts, silence."""

from __future__ import annotations

import math
import statistics
from collections import deque

_USUAL_FROM = 10
"""Intervals from which the usual one is estimated."""
_GAP, _BURST = 2.5, 0.2
"""An interval above, or below, so many usual ones is a gap, or part of a burst."""


class LinkWatch:
    """Watches when samples come; after a silence of a `timeout` [s] the device is stale.

    Attributes
    ----------
    samples, gaps, bursts, timeouts : counted so far
    longest_gap : [s]
    """

    def __init__(self, timeout: float) -> None:
        self._timeout = timeout
        self._newest = math.nan
        self._intervals: deque[float] = deque(maxlen=50)
        self._is_stale = False
        self.samples = self.gaps = self.bursts = self.timeouts = 0
        self.longest_gap = 0.0

    def arrived(self, now: float) -> None:
        """Note a sample at the monotonic time `now` [s]."""
        self.samples += 1
        if not math.isnan(self._newest):
            interval = now - self._newest
            usual = self.usual_interval
            if not math.isnan(usual):
                self.gaps += interval > _GAP * usual
                self.bursts += interval < _BURST * usual
            self.longest_gap = max(self.longest_gap, interval)
            self._intervals.append(interval)
        self._newest = now
        self._is_stale = False

    @property
    def usual_interval(self) -> float:
        """Mean interval of the last samples, gaps left out [s]; NaN with too few."""
        if len(self._intervals) < _USUAL_FROM:
            return math.nan
        middle = statistics.median(self._intervals)
        mean = statistics.fmean(self._intervals)
        return mean if middle < _BURST * mean else middle

    def age(self, now: float) -> float:
        """Return how old the newest sample is at `now` [s]; NaN: none has come."""
        return now - self._newest

    def is_stale(self, now: float) -> bool:
        """Return whether nothing has come for the timeout before `now` [s]; each such time is counted once."""
        if math.isnan(self._newest) or now - self._newest <= self._timeout:
            return math.isnan(self._newest)
        self.timeouts += not self._is_stale
        self._is_stale = True
        return True
