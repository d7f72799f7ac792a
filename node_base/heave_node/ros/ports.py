"""Outputs and inputs of a node within ticks: counted publishers, and typed access to what the gate holds."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.serialization import deserialize_message, serialize_message
from rclpy.subscription import Subscription

from heave_node.cdr.layout import LayoutError
from heave_node.interface.messages import MessageReader, message_type
from heave_node.interface.sensors import WireReading
from heave_node.interface.topic import Topic
from heave_node.ros.input_timing import InputTiming
from heave_node.ros.transport.exchange import LocalPublisher, LocalSubscription
from heave_node.ros.transport.qos import STREAM_DEPTH
from heave_node.tick.gate import TickGate
from heave_node.tick.protocol import Part, Past
from heave_node.tick.tick import Tick, nanoseconds_of, stamp_of

PAST_TICKS, PAST_PERIOD = 5, 0.05
"""Ticks, or wall time [s], after which what was sent meanwhile is passed on."""


class Output:
    """A topic that a node publishes within ticks: with its part of the tick, and by itself for whoever hears the topic.

    Parameters
    ----------
    topic : resolved name
    publisher : of rclpy, or in memory; None on a topic that comes from outside: what this node would say there is
        neither counted nor sent
    is_lasting : it is published by itself also where nobody hears it yet
    carry : takes each message of this tick for the part

    Attributes
    ----------
    published : messages since the start
    is_heard : somebody heard the topic by itself at the last look
    """

    def __init__(
        self,
        topic: str,
        publisher: Publisher[Any] | LocalPublisher | None,
        *,
        is_lasting: bool = False,
        carry: Callable[[bytes], None] = lambda _: None,
    ) -> None:
        self.topic = topic
        self._publisher = publisher
        self._is_lasting = self.is_heard = is_lasting
        self._carry = carry
        self.published = 0

    @property
    def hearers(self) -> int:
        """Number of subscriptions that the middleware has matched."""
        return 0 if self._publisher is None else self._publisher.get_subscription_count()

    def look(self) -> None:
        """Look whether anybody hears the topic."""
        self.is_heard = self._is_lasting or self.hearers > 0

    def publish(self, message: object) -> None:
        """Send a `message`, or the bytes of a serialised one, as part of this tick."""
        if self._publisher is not None:
            self.published += 1
            # Serialised once: padding bytes are not defined, and receivers know a repeated message by its bytes.
            data = message if isinstance(message, bytes) else serialize_message(message)
            self._carry(data)
            if self.is_heard:
                self._publisher.publish(data)

    def publish_uncounted(self, message: object) -> None:
        """Send a `message` that is part of no tick."""
        if self._publisher is not None:
            self._publisher.publish(message)


class PassedOn:
    """Passes on to nodes that may be behind what was sent in a few ticks, in one message.

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


Decoder = Callable[[bytes], tuple[int | None, Any]]
"""Makes of the bytes of a message its stamp [ns], None without a header, and what an input gives."""


def decoder_of(topic: Topic, fields: Sequence[str] | None) -> Decoder:
    """Return what decodes messages of a `topic`: to readings of the numbers in `fields`, or with None as a whole."""
    kind = message_type(topic.type)

    def decode_whole(data: bytes) -> tuple[int | None, Any]:
        message = deserialize_message(data, kind)
        return nanoseconds_of(message.header.stamp) if hasattr(message, "header") else None, message

    if fields is None:
        return decode_whole
    reader = MessageReader(topic.type, fields)

    def decode_fields(data: bytes) -> tuple[int | None, Any]:
        reading = reader.reading(data)
        return reading.stamp, reading

    return of_any_machine(decode_fields, kind)


def of_any_machine(decode: Callable[[bytes], Any], kind: type[Any]) -> Callable[[bytes], Any]:
    """Return `decode`, which knows little-endian messages of the class `kind`, for those of every byte order."""

    def decode_any(data: bytes) -> Any:
        try:
            return decode(data)
        except LayoutError:  # or no such message: the middleware will say so
            return decode(serialize_message(deserialize_message(data, kind)))

    return decode_any


def stamped(content: Any, stamp: int) -> Any:
    """Return the `content` of a message, as a decoder gives it, with another `stamp` [ns]."""
    if isinstance(content, WireReading):
        return content._replace(stamp=stamp)
    content.header.stamp = stamp_of(stamp)
    return content


class Input:
    """A topic that a node reads within ticks.

    Parameters
    ----------
    node : that reads
    topic : its name and type; the attribute of this name is the resolved name
    gate : holds the messages until their tick, each as its `Decoder` gives it
    check_stamps : refuse messages that are stamped in the future or out of order
    lifespan : messages older than this at the start of the tick are not used [s]
    holds_ahead : messages that are stamped after the start of a tick wait for the next one
    settles : messages wait until the tick that they are stamped with is over

    Attributes
    ----------
    name : of the topic, relative
    early, late : messages refused so far: stamped in the future; older than one before them or than the lifespan
    latest : last reading or message taken, None before the first
    """

    def __init__(
        self,
        node: Node,
        topic: Topic,
        gate: TickGate,
        *,
        check_stamps: bool = True,
        lifespan: float = math.inf,
        holds_ahead: bool = False,
        settles: bool = False,
    ) -> None:
        self.name = topic.name
        self.topic = node.resolve_topic_name(topic.name)
        self.check_stamps = check_stamps
        self.lifespan = lifespan
        self.holds_ahead = holds_ahead
        self.settles = settles
        self.early = self.late = 0
        self.latest: Any = None
        self._gate = gate
        self._ahead: deque[tuple[int | None, Any]] = deque(maxlen=STREAM_DEPTH)
        self._last_stamp = 0

    def take(self, tick: Tick) -> list[Any]:
        """Return what came for this `tick`, oldest first; `latest` holds the last one afterwards.

        Where `check_stamps` is on, a message that is stamped after the end of the tick, or not after the one before it,
        is refused and counted; so is one that is older than the lifespan.
        """
        messages: list[tuple[int | None, Any]] = self._gate.take(self.topic)
        if not (messages or self._ahead):
            return messages
        if self.holds_ahead or self.settles:
            self._ahead.extend(messages)
            messages = self._due(tick.start_nanoseconds - self.settles)
        if self.check_stamps:
            messages = [entry for entry in messages if self._is_stamp_legal(entry[0], tick.end_nanoseconds)]
        if self.lifespan != math.inf:
            messages = [entry for entry in messages if self._is_young(entry[0], tick.start_nanoseconds)]
        contents = [content for _, content in messages]
        if contents:
            self.latest = contents[-1]
        return contents

    def reset(self) -> None:
        """Discard the previous run."""
        self.latest = None
        self._ahead.clear()
        self._last_stamp = 0

    def _due(self, now: int) -> list[tuple[int | None, Any]]:
        """Return what waits and is stamped by `now` [ns], in the order of arrival."""
        due = []
        while self._ahead and (self._ahead[0][0] or 0) <= now:
            due.append(self._ahead.popleft())
        return due

    def _is_stamp_legal(self, stamp: int | None, latest_legal_stamp: int) -> bool:
        if stamp is None:
            return True
        self.early += stamp > latest_legal_stamp
        self.late += stamp <= self._last_stamp
        if not self._last_stamp < stamp <= latest_legal_stamp:
            return False
        self._last_stamp = stamp
        return True

    def _is_young(self, stamp: int | None, now: int) -> bool:
        is_old = stamp is not None and stamp < now - round(self.lifespan * 1e9)
        self.late += is_old
        return not is_old


@dataclass
class Ports:
    """All that a node publishes and reads within ticks."""

    part: Output = field(init=False)  # its parts of ticks
    join: Publisher[Any] | LocalPublisher = field(init=False)  # on which it reports itself to the clock master
    outputs: list[Output] = field(default_factory=list)  # in the order of their making; first that of the parts
    before: set[Any] = field(default_factory=set)  # what the node had of the middleware before it was configured
    apart: list[Output] = field(default_factory=list)  # outputs that are no part of ticks
    of_past: set[str] = field(default_factory=set)  # nodes whose parts are taken from what the clock master passes on
    carried: list[tuple[int, bytes]] = field(default_factory=list)  # messages of this tick that wait for the part
    inputs: list[Input] = field(default_factory=list)  # in the order in which they were added
    timings: dict[str, InputTiming] = field(default_factory=dict)  # of inputs of external nodes, by topic
    subscriptions: dict[str, Subscription[Any] | LocalSubscription] = field(default_factory=dict)  # by resolved topic
    local: list[LocalPublisher | LocalSubscription] = field(default_factory=list)  # what it has of the exchange
