"""Answers of the adviser that wait for their tick: a late one is refused, and counted."""

from __future__ import annotations

from winch_controller_node.beliefs.beliefs import Beliefs, latency_ticks


class Answers:
    """The answers that wait, and how they came.

    Parameters
    ----------
    tick_period : [s]

    Attributes
    ----------
    in_force : the newest that came into force; None: the nominal holds
    on_time, late : how many came in time, and how many were refused
    """

    def __init__(self, tick_period: float) -> None:
        self._latency = latency_ticks(tick_period)
        self._waiting: dict[int, Beliefs] = {}
        self.in_force: Beliefs | None = None
        self.on_time = self.late = 0

    def put(self, beliefs: Beliefs, tick: int) -> bool:
        """Take an answer, `beliefs`, that came before the step of a `tick`; tell whether it was in time."""
        due = beliefs.asked + self._latency
        if due < tick:
            self.late += 1
            return False
        self.on_time += 1
        self._waiting[due] = beliefs
        return True

    def due(self, tick: int) -> Beliefs | None:
        """Return what comes into force at a `tick`; None: nothing does."""
        beliefs = self._waiting.pop(tick, None)
        if beliefs is not None:
            self.in_force = beliefs
        return beliefs
