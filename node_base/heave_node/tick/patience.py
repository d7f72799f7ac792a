"""How long to wait for messages that may never come: while fewer and fewer are missing. Wall time, no ROS."""

from __future__ import annotations

import time
from collections.abc import Callable

FLUSH_PATIENCE = 1.0
"""Wall time without another message after which those that are missing at the end of a run are lost [s]."""


class Patience:
    """Waits while what is missing becomes less.

    Parameters
    ----------
    seconds : for which the number may stand still [s]
    clock : returns the wall time [s]
    """

    def __init__(self, seconds: float = FLUSH_PATIENCE, clock: Callable[[], float] = time.monotonic) -> None:
        self._seconds = seconds
        self._clock = clock
        self._missing = -1
        self._since = clock()

    def is_over(self, missing: int) -> bool:
        """Return whether as many messages as now, `missing`, have been missing for too long; ask again and again."""
        now = self._clock()
        if missing != self._missing:
            self._missing, self._since = missing, now
        return now - self._since >= self._seconds
