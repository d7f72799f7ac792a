"""How long another node has been silent, as far as this process could have heard it, and how long to wait for what may
never come.
"""

from __future__ import annotations

import time
from collections.abc import Callable

STANDSTILL = 1.0
"""Time between two looks from which on this process itself stood still [s]: looks come several times a second."""

FLUSH_PATIENCE = 1.0
"""Wall time without another message after which those that are missing at the end of a run are lost [s]."""


class Silence:
    """The silence of another node; who looks after it calls `look` several times a second.

    A process that computes for long, or has many nodes, hears nobody meanwhile: that is not the silence of the other.

    Parameters
    ----------
    clock : returns the wall time [s]
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._heard_at = self._looked_at = clock()

    def end(self) -> None:
        """Take note that the other has been heard."""
        self._heard_at = self._clock()

    def look(self) -> float:
        """Return how long the other has been silent [s]."""
        now = self._clock()
        stood = now - self._looked_at
        if stood > STANDSTILL:
            self._heard_at = min(self._heard_at + stood, now)
        self._looked_at = now
        return now - self._heard_at


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
