"""Commands that the winch takes later than modelled."""

from __future__ import annotations

import math
from collections import deque

LATE_TICKS = 2
"""Ticks in a row with a command overdue that raise the alarm."""

LATE_WINDOW = 2.0
"""Commands of so many seconds are judged together: one hiccup of a machine is no slow transport."""


class LateCommands:
    """Notices that the winch takes commands later than modelled, by the sequence numbers that it acknowledges.

    A transport that becomes slower is seen so within three ticks, long before the record of the drum tells; that it
    stays so is judged by the median over some seconds.

    Parameters
    ----------
    tick_period : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._late = 0
        self._overdue: deque[float] = deque(maxlen=max(1, round(LATE_WINDOW / tick_period)))

    @property
    def overdue(self) -> float:
        """Time by which more than half of the commands of the last seconds were later than modelled, at least [s]."""
        window = self._overdue.maxlen or 1
        later = sorted(self._overdue, reverse=True)
        return later[window // 2] if len(later) > window // 2 else 0.0

    def update(self, given: int, taken: int, delay: float) -> str:
        """Return what is wrong in words, once each time; empty when nothing is.

        Parameters
        ----------
        given, taken : number of the last command, and of the newest one in effect at the end of its tick
        delay : of the model [s]
        """
        due = math.ceil(delay / self._dt - 1e-6) - 1
        late_ticks = given - taken - due - 1
        is_late = taken > 0 and late_ticks > 0
        self._late = self._late + 1 if is_late else 0
        self._overdue.append(late_ticks * self._dt if is_late else 0.0)
        if self._late != LATE_TICKS:
            return ""
        return f"winch commands take effect at least {late_ticks * self._dt:.2f} s later than modelled"
