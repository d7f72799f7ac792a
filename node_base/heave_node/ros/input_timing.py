"""How messages from outside arrive: the time from one to the next, and how old the newest is when it is used."""

from __future__ import annotations

import time

from heave_node.ros.diagnostics import Health, Level
from heave_node.tick.durations import Durations

TIMING = "timing"
"""Begins the name of a diagnostic status that holds a histogram of durations."""


class InputTiming:
    """Wall times of the messages of one external publisher, on the `topic` of this name."""

    def __init__(self, topic: str) -> None:
        self.topic = topic
        self.intervals = Durations()
        self.ages = Durations()
        self._arrived_at: float | None = None

    def arrived(self) -> None:
        """Note the arrival of a message."""
        now = time.monotonic()
        if self._arrived_at is not None:
            self.intervals.add(now - self._arrived_at)
        self._arrived_at = now

    def used(self) -> None:
        """Note that the newest message is used, whether it is new or was used before."""
        if self._arrived_at is not None:
            self.ages.add(time.monotonic() - self._arrived_at)

    def diagnose(self) -> list[Health]:
        """Return both as diagnostic statuses."""
        return [timing_health(f"interval {self.topic}", self.intervals), timing_health(f"age {self.topic}", self.ages)]


def timing_health(name: str, durations: Durations, **more: str) -> Health:
    """Return `durations` as a diagnostic status: `name` says which, `more` are further values."""
    return Health(f"{TIMING} {name}", Level.OK, durations.words(), {**durations.to_values(), **more})
