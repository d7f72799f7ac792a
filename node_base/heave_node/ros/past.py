"""What the clock master passes on to nodes that may be behind: what was sent in a few ticks, in one message."""

from __future__ import annotations

import time

from heave_node.ros.ports import Output
from heave_node.tick.protocol import Part, Past

PAST_TICKS, PAST_PERIOD = 5, 0.05
"""Ticks, or wall time [s], after which what was sent meanwhile is passed on."""


class PassedOn:
    """Collects parts of ticks.

    Parameters
    ----------
    output : takes them
    is_in_memory : the nodes that hear it are in this process, and get them as they are
    """

    def __init__(self, output: Output, *, is_in_memory: bool) -> None:
        self._output, self._is_in_memory = output, is_in_memory
        self._waiting: list[tuple[int, Part]] = []
        self._sent_at = 0.0
        self._last = Past(0, 0, ())

    def add(self, entry: int, part: Part) -> None:
        """Keep a `part`, of the node whose first entry in the roster is `entry`, for those that hear."""
        if self._output.is_heard:
            self._waiting.append((entry, part))

    def is_due(self, tick: int) -> bool:
        """Return whether what waits is to be sent now, in the `tick` of this number."""
        return tick % PAST_TICKS == 0 or time.monotonic() - self._sent_at > PAST_PERIOD

    def send(self, tick: int, epoch: int, *, again: bool = False) -> None:
        """Send what waits, in a `tick` of an `epoch`; `again`: where nothing does, what was sent last."""
        self._sent_at = time.monotonic()
        if self._waiting:
            self._last, self._waiting, again = Past(tick, epoch, self._waiting), [], True
        if again and self._last.parts:
            self._output.publish_uncounted(self._last if self._is_in_memory else self._last.to_bytes())
