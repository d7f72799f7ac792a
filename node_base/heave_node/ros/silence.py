"""How long another node has been silent, as far as this process could have heard it."""

from __future__ import annotations

import time
from collections.abc import Callable

STANDSTILL = 1.0
"""Time between two looks from which on this process itself stood still [s]: looks come several times a second."""


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
