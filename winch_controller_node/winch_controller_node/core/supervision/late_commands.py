"""Commands that the winch takes later than modelled: counted one by one, judged by their statistics."""

from __future__ import annotations

import math
from collections import deque
from itertools import islice

from heave_node.interface.alarm import Alarm

from winch_controller_node.interface.alarms import ALARMS

LATE_TICKS = 2
"""Ticks in a row with a command overdue after which the delay of the winch is not what it was."""

LATE_WINDOW = 2.0
"""Commands of so many seconds are judged together: one hiccup of a machine is no slow transport."""

SHARE_WINDOW, LARGEST_SHARE = 60.0, 0.1
"""Share of the commands of so many seconds that may be late; half of it ends the alarm."""

CUT_TIME = 0.5
"""Time without a new command taken after which the link counts as cut [s]: how late any command is, is then unknown."""


class LateCommands:
    """Notices that the winch takes commands later than modelled, by the sequence numbers that it acknowledges.

    That they have just become late is seen within three ticks, long before the record of the drum shows it. An alarm is
    given where it is more than a hiccup: by the median over some seconds, and by the share of a minute.

    Parameters
    ----------
    tick_period : [s]

    Attributes
    ----------
    known, late : commands of which it is known how late they were, and those that were late, since the start
    largest : time by which one was later than modelled [s]
    has_begun : with the last one they have just become late
    is_cut : no new command has been taken for CUT_TIME
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._in_a_row = 0
        self._overdue: deque[float] = deque(maxlen=max(1, round(SHARE_WINDOW / tick_period)))
        self._window = max(1, round(LATE_WINDOW / tick_period))
        self._late_in_minute = 0
        self._is_slow = self._is_ragged = False
        self._newest, self._ticks_without_new = 0, 0
        self.known = self.late = 0
        self.largest = 0.0
        self.has_begun = self.is_cut = False

    @property
    def overdue(self) -> float:
        """Time by which more than half of the commands of the last seconds were later than modelled, at least [s]."""
        if self._late_in_minute == 0:
            return 0.0
        later = sorted(islice(reversed(self._overdue), self._window), reverse=True)
        return later[self._window // 2] if len(later) > self._window // 2 else 0.0

    @property
    def is_reported(self) -> bool:
        """Tell whether an alarm holds."""
        return self._is_slow or self._is_ragged

    def update(self, given: int, taken: int, delay: float) -> Alarm | None:
        """Return what is wrong, once each time; None when nothing is.

        Parameters
        ----------
        given, taken : number of the last command, and of the newest one in effect at the end of its tick
        delay : of the model [s]
        """
        due = math.ceil(delay / self._dt - 1e-6) - 1
        late_ticks = given - taken - due - 1
        is_late = taken > 0 and late_ticks > 0
        self._in_a_row = self._in_a_row + 1 if is_late else 0
        self.has_begun = self._in_a_row == LATE_TICKS
        self._ticks_without_new = self._ticks_without_new + 1 if is_late and taken == self._newest else 0
        self._newest = taken
        self.is_cut = self._ticks_without_new * self._dt > CUT_TIME - 0.5 * self._dt
        if not self.is_cut:
            self._note(late_ticks * self._dt if is_late else 0.0)
        return self._judge()

    def _note(self, overdue: float) -> None:
        """Put a command on record that was `overdue` for so long [s]."""
        if len(self._overdue) == self._overdue.maxlen:
            self._late_in_minute -= self._overdue[0] > 0.0
        self._overdue.append(overdue)
        self._late_in_minute += overdue > 0.0
        self.known += 1
        self.late += overdue > 0.0
        self.largest = max(self.largest, overdue)

    def _judge(self) -> Alarm | None:
        """Return what the statistics say that they did not say before."""
        was_slow, was_ragged = self._is_slow, self._is_ragged
        share = self._late_in_minute / (self._overdue.maxlen or 1)
        self._is_ragged = share > (0.5 * LARGEST_SHARE if was_ragged else LARGEST_SHARE)
        overdue = self.overdue if self._in_a_row or was_slow else 0.0
        self._is_slow = overdue > 0.0
        if self._is_slow and not was_slow:
            return ALARMS.alarm("COMMANDS_LATE", delay=overdue)
        if self._is_ragged and not (was_ragged or was_slow):
            largest = max(self._overdue)
            return ALARMS.alarm("COMMANDS_OFTEN_LATE", percent=100.0 * share, window=SHARE_WINDOW, largest=largest)
        return None
