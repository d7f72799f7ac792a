"""Whether the adviser's answers are used: not for a time where they cannot be, or the readings contradict them.

Each time is longer than the one before, and a count ends it.
"""

from __future__ import annotations

import math

from heave_node.interface.alarm import Alarm

from winch_controller_node.interface.alarms import ALARMS

FIRST_TIME, GROWTH, MOST = 60.0, 4.0, 3
"""Time for which no answer is used the first time [s], the factor by which it grows, and the count after which none is
used any more."""


class AdviserTrust:
    """Counts how often the adviser was wrong.

    `tick_period` : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._until = 0.0
        self.count = 0  # times that it was wrong
        self._news: list[Alarm] = []

    def accepts(self, tick: int) -> bool:
        """Tell whether answers are used at a `tick`."""
        return tick * self._dt >= self._until

    def contradict(self, fault: str, tick: int) -> None:
        """Use no answer for a time from a `tick` on, for a `fault` in words."""
        time = FIRST_TIME * GROWTH**self.count
        self.count += 1
        if self.count < MOST:
            self._until = tick * self._dt + time
            self._news.append(ALARMS.alarm("ADVISER_WRONG: set aside", fault=fault, time=time))
        else:
            self._until = math.inf
            self._news.append(ALARMS.alarm("ADVISER_WRONG: excluded", fault=fault, count=self.count))

    def restart(self) -> None:
        """Use answers again: an operator has restated what is nominal."""
        self._until, self.count = 0.0, 0

    def news(self) -> list[Alarm]:
        """Return, once, what is new."""
        found, self._news = self._news, []
        return found
