"""Outputs and inputs of a node within ticks: counted publishers, and typed access to what the gate holds."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.serialization import serialize_message

from heave_node.messages import message_type
from heave_node.ros.qos import qos_of
from heave_node.tick.gate import TickGate
from heave_node.topic import Topic


class Output:
    """A topic that a node publishes within ticks. Counts its messages and keeps those of this tick, to send them
    again.

    What the next node waits for is sent at once by `publish`. The rest is promised by `publish_deferred`: it counts at
    once, but is made and sent when this node has told the others that its part of the tick is done, so that they work
    meanwhile.
    """

    def __init__(self, node: Node, topic: Topic) -> None:
        self.publisher: Publisher[Any] = node.create_publisher(message_type(topic.type), topic.name, qos_of(topic.role))
        self.topic = self.publisher.topic_name
        self.published = 0
        self._sent_this_tick: list[bytes] = []
        self._deferred: list[Callable[[], object]] = []

    def publish(self, message: object) -> None:
        """Send a message, or one that is serialised already, as part of this tick."""
        self.published += 1
        self._send(message)

    def publish_deferred(self, make: Callable[[], object]) -> None:
        """Promise a message of this tick; `make` is called before anything else happens in this node."""
        self.published += 1
        self._deferred.append(make)

    def flush_deferred(self) -> None:
        """Make and send what was promised."""
        deferred, self._deferred = self._deferred, []
        for make in deferred:
            self._send(make())

    def _send(self, message: object) -> None:
        # Serialised once: padding is whatever the memory held, and a repeated message is known by its bytes.
        data = message if isinstance(message, bytes) else serialize_message(message)
        self._sent_this_tick.append(data)
        self.publisher.publish(data)

    def begin_tick(self) -> None:
        """Forget the messages of the tick before."""
        self._sent_this_tick.clear()

    def resend(self) -> None:
        """Repeat the messages of this tick, uncounted: receivers know them by their bytes."""
        for data in self._sent_this_tick:
            self.publisher.publish(data)


class Input:
    """A topic that a node reads within ticks."""

    def __init__(self, node: Node, topic: Topic, gate: TickGate, *, check_stamps: bool = True) -> None:
        self.name = topic.name
        self.check_stamps = check_stamps
        self.wrong_stamps = 0
        self.latest: Any = None
        self._gate = gate
        self._last_stamp = 0
        self.topic = node.resolve_topic_name(topic.name)

    def take(self, latest_legal_stamp: int) -> list[Any]:
        """Return the new messages of this tick, oldest first; `latest` holds the last one afterwards.

        A message whose stamp lies after `latest_legal_stamp` [ns], or not after the stamp before it, is refused and
        counted in `wrong_stamps`
        (where `check_stamps` is on and the message has a header).
        """
        messages = self._gate.take(self.topic)
        if self.check_stamps:
            messages = [message for message in messages if self._is_stamp_legal(message, latest_legal_stamp)]
        if messages:
            self.latest = messages[-1]
        return messages

    def reset(self) -> None:
        """Forget the run before."""
        self.latest = None
        self._last_stamp = 0

    def _is_stamp_legal(self, message: Any, latest_legal_stamp: int) -> bool:
        if not hasattr(message, "header"):
            return True
        stamp = message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec
        if not self._last_stamp < stamp <= latest_legal_stamp:
            self.wrong_stamps += 1
            return False
        self._last_stamp = stamp
        return True
