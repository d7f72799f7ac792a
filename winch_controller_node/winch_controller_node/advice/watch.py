"""Whether the adviser answers, and in time: its alarms, without ROS."""

from __future__ import annotations

from collections import deque

from heave_node.interface.alarm import Alarm

from winch_controller_node.beliefs.beliefs import latency_ticks
from winch_controller_node.interface.alarms import ALARMS

SILENT = 3.0
"""Time after which an answer that has not come is missed [s]: three latencies."""
QUESTIONS_KEPT = 60
"""Questions whose answers are waited for; an answer to an older one is stale."""
STEADY = 10
"""Answers in time, one after another, with which a late adviser counts as in time again."""


class AdviserWatch:
    """Questions that were put, and what came of them.

    `tick_period` : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._latency = latency_ticks(tick_period)
        # answers that were taken, that came too late, and that made no sense
        self.answered = self.late = self.malformed = 0
        self._questions: deque[int] = deque(maxlen=QUESTIONS_KEPT)
        self._unanswered: int | None = None
        self._in_a_row = STEADY
        self._number = 0
        self._is_silent = False
        self._silence = 0.0
        self._alarms: list[Alarm] = []

    def asked(self, tick: int) -> None:
        """Note that observations up to a `tick` went out."""
        self._questions.append(tick)
        if self._unanswered is None:
            self._unanswered = tick

    def is_question(self, tick: int) -> bool:
        """Return whether an answer to the observations up to a `tick` is waited for, once: it has one answer."""
        if tick not in self._questions:
            return False
        self._questions.remove(tick)
        return True

    def took(self, number: int) -> None:
        """Note an answer in time, the beliefs of a `number`."""
        self.answered += 1
        self._in_a_row += 1
        self._number = number
        self._heard()

    def refused_stale(self) -> None:
        """Note an answer to no question: to that of a controller before this one, or a second one."""
        self.late += 1

    def is_due(self, asked: int, tick: int) -> bool:
        """Return whether the answer to what was `asked` in a tick is active in this `tick`."""
        return asked + self._latency <= tick

    def refused_late(self) -> None:
        """Note an answer that came too late."""
        self.late += 1
        if self._in_a_row >= STEADY:
            late = ALARMS.alarm("ADVISER_LOST: late", latency=self._latency * self._dt, which=self._which)
            self._alarms.append(late)
        self._in_a_row = 0
        self._heard()

    def refused(self, fault: str) -> None:
        """Note an answer that made no sense, and why (`fault`)."""
        if not self.malformed:
            self._alarms.append(ALARMS.alarm("ADVISER_LOST: rejected", fault=fault, which=self._which))
        self.malformed += 1
        self._heard()

    def step(self, tick: int) -> list[Alarm]:
        """Return the alarms of a `tick`."""
        waited = 0 if self._unanswered is None else tick - self._unanswered
        self._silence = waited * self._dt
        if not self._is_silent and waited > round(SILENT / self._dt):
            self._is_silent = True
            self._alarms.append(ALARMS.alarm("ADVISER_LOST: silent", time=self._silence, which=self._which))
        alarms, self._alarms = self._alarms, []
        return alarms

    @property
    def is_well(self) -> bool:
        """Return whether answers come, in time, and make sense."""
        return not self._is_silent and self._in_a_row >= STEADY and not self.malformed

    @property
    def words(self) -> str:
        """Say how it is."""
        if self._is_silent:
            return f"silent: no answer for {self._silence:.1f} s; values active: {self._which}"
        if self._in_a_row < STEADY:
            return f"late: {self.late} answers rejected; values active: {self._which}"
        return f"{self.malformed} answers rejected" if self.malformed else f"in time; values active: {self._which}"

    @property
    def values(self) -> dict[str, str]:
        """Return the counts, for diagnostics."""
        return {"answered": str(self.answered), "late": str(self.late), "malformed": str(self.malformed)}

    @property
    def _which(self) -> str:
        return f"identified, set {self._number}" if self._number else "nominal"

    def _heard(self) -> None:
        self._unanswered = None
        if self._is_silent:
            self._is_silent = False
            self._alarms.append(ALARMS.alarm("ADVISER_RESTORED"))
