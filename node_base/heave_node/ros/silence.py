"""Waits in wall time: how long another node has been silent, as far as this process could have heard it, how long to
wait for what may never come, and when to send or say it again.
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
    `clock` returns the wall time [s].
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
    """Waits while something changes: messages that are missing become fewer, or what is found may not be all yet.

    Parameters
    ----------
    seconds : for which it may stay the same [s]
    clock : returns the wall time [s]
    """

    def __init__(self, seconds: float = FLUSH_PATIENCE, clock: Callable[[], float] = time.monotonic) -> None:
        self._seconds, self._clock = seconds, clock
        self._seen: object = None
        self._since = clock()

    def is_over(self, seen: object) -> bool:
        """Return whether what is `seen` now, a number or words, has been the same for too long; ask again and again."""
        now = self._clock()
        if seen != self._seen:
            self._seen, self._since = seen, now
        return now - self._since >= self._seconds


class MasterWaits:
    """What the clock master waits for: answers to what it has sent, its next status, its next warning.

    `clock` returns the wall time [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._made_at = clock()
        self._since = dict.fromkeys(("sent", "warning", "status"), self._made_at)
        self._resend_wait = 0.0
        self._is_late = False

    @property
    def age(self) -> float:
        """Time since this was made [s]."""
        return self._clock() - self._made_at

    def sent(self, resend_wait: float) -> None:
        """Note that a tick was sent; it is due to be sent again after `resend_wait` [s]."""
        self._since["sent"] = self._since["warning"] = self._clock()
        self._resend_wait = resend_wait

    def is_resend_due(self) -> bool:
        """Tell whether the tick is due to be sent again; then it is twice as long before that is so again."""
        is_due = self._is_due("sent", self._resend_wait)
        self._resend_wait *= 2.0 if is_due else 1.0  # a slow machine must not get more to do each time
        return is_due

    def is_status_due(self, period: float) -> bool:
        """Tell whether more than a `period` [s] has passed since the last status was due."""
        return self._is_due("status", period)

    def is_warning_due(self, period: float) -> bool:
        """Tell whether more than a `period` [s] has passed since the last warning was due, or the tick was sent."""
        return self._is_due("warning", period)

    def _is_due(self, what: str, period: float) -> bool:
        now = self._clock()
        is_due = now - self._since[what] > period
        if is_due:
            self._since[what] = now
        return is_due

    def note_late(self) -> None:
        """Note that a node was reported late."""
        self._is_late = True

    def has_recovered(self) -> bool:
        """Tell once, when the next tick begins, that a node which was reported late has answered."""
        was_late, self._is_late = self._is_late, False
        return was_late
