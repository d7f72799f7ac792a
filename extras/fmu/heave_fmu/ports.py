"""Messages of a topic as values of an FMU's variables, both ways.

What travels over ROS as messages travels between FMUs as held values. A counter says how many messages were sent so
far, so that what was sent is taken once; where several may come in a tick, each has a slot of its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from heave_node.errors import NodeError
from heave_node.interface.sensors import WireReading
from heave_node.interface.topic import Topic

from heave_fmu.variables import BOOLEAN, INTEGER, REAL, Variable, base_name, count_variable, message_variables

EACH_TICK = -1
"""Counter of an input whose messages nobody counts: one comes with each tick."""
NO_STAMP = -1.0
"""Stamp of a message that has none [s]: it is that of the step."""

_EMPTY: dict[str, Any] = {REAL: 0.0, INTEGER: 0, BOOLEAN: False}


class Port:
    """The messages of one topic.

    Parameters
    ----------
    topic : of the messages
    fields : of the messages, dotted
    slots : most messages that come in one tick

    Attributes
    ----------
    variables, values : of the FMU, in the same order: the counter, then stamp and fields of each slot
    """

    def __init__(self, topic: Topic, fields: Sequence[str], slots: int = 1) -> None:
        self.topic = topic
        self._slots, self._width = slots, 1 + len(fields)
        base = base_name(topic.name)
        prefixes = [base] if slots == 1 else [f"{base}[{slot}]" for slot in range(1, slots + 1)]
        self.variables: list[Variable] = [count_variable(topic)]
        for prefix in prefixes:
            self.variables += message_variables(topic, tuple(fields), prefix)
        self.values: list[Any] = [_EMPTY.get(variable.kind, "") for variable in self.variables]
        self._seen = 0

    @property
    def sizes(self) -> tuple[int, int]:
        """Slots, and numbers of each after its stamp."""
        return self._slots, self._width - 1

    def restart(self) -> None:
        """Count from the first message again."""
        self.values[0] = min(self.values[0], 0)
        self._seen = 0

    # an output

    def publish(self, readings: Iterable[WireReading]) -> None:
        """Put the messages of a tick out, `readings`, oldest first. Raises NodeError for more than there are slots."""
        for slot, reading in enumerate(readings):
            if slot >= self._slots:
                raise NodeError(f"{self.topic.name}: more than {self._slots} messages in one tick have no variables")
            self.hold(reading, slot)
            self.values[0] += 1

    def hold(self, reading: WireReading, slot: int = 0) -> None:
        """Show the values of a `reading` in a `slot`, from 0, without sending a message."""
        first = 1 + slot * self._width
        self.values[first : first + self._width] = (reading.stamp * 1e-9, *reading.numbers)

    # an input

    def await_messages(self) -> None:
        """Be an input: until somebody counts one comes with each tick, and those without a stamp are of the step."""
        self.values[0] = EACH_TICK
        self.values[1 :: self._width] = [NO_STAMP] * self._slots

    def take(self, now: int) -> list[WireReading]:
        """Return the messages that came since the last call, oldest first.

        Parameters
        ----------
        now : time of the step [ns], the stamp of messages without one

        Raises NodeError where more came than there are slots.
        """
        new = self._news()
        if new > self._slots:
            raise NodeError(f"{self.topic.name}: {new} messages came in one tick, {self._slots} have variables")
        return [self._reading(slot, now) for slot in range(new)]

    def newest(self, now: int) -> WireReading | None:
        """Return the newest message since the last call, `now` the time of the step [ns]; None: none came."""
        return self._reading(0, now) if self._news() > 0 else None

    def _news(self) -> int:
        count = self.values[0]
        if count == EACH_TICK:
            return 1
        new, self._seen = count - self._seen, count
        return int(new)

    def _reading(self, slot: int, now: int) -> WireReading:
        first = 1 + slot * self._width
        stamp, *numbers = self.values[first : first + self._width]
        return WireReading(now if stamp < 0.0 else round(stamp * 1e9), tuple(numbers))
