"""Topics in the memory of one process: what nodes that share it hand each other, without the middleware.

Messages wait in one queue in the order in which they were published, and each is given to all readers before the next:
an order that depends on the run alone. The publishers of the middleware stay, so that other processes see in the graph
what there is; they are given what is meant to be seen outside.
"""

from __future__ import annotations

import time
from collections import defaultdict, deque
from collections.abc import Callable, Iterable
from typing import Any

from rclpy.duration import Duration
from rclpy.publisher import Publisher
from rclpy.serialization import serialize_message
from rclpy.task import Future

from heave_node.interface import topics
from heave_node.interface.topic import LASTING, Topic
from heave_node.tick.protocol import Part, Past

Carried = bytes | Part | Past
"""What travels: the bytes of a message, a part of a tick, or parts of a few."""
Reader = Callable[[Any, str, int], None]
"""Takes what travels, the identity of the process that sent it, and when [ns]."""

GLANCE = 0.1
"""Wall time between two messages of a topic that others get of it where not every one is published [s]."""
_ALWAYS = {topics.DIAGNOSTICS.name, topics.CONTROLLER_KPI.name, topics.TICK_STATUS.name}
"""Topics of which others always get every message: few, and none may be missed."""


class LocalPublisher:
    """Publishes a topic in memory.

    Parameters
    ----------
    readers : of the topic
    enqueue : queues a message for its readers
    outside : publisher of the middleware
    period : wall time between two messages for others [s]; 0 gives them every one
    """

    def __init__(
        self,
        readers: list[Reader],
        enqueue: Callable[[list[Reader], Carried], None],
        outside: Publisher[Any],
        period: float,
    ) -> None:
        self._readers = readers
        self._enqueue = enqueue
        self._outside = outside
        self._period = period
        self._shown_at = -period
        self.topic_name = outside.topic_name

    def publish(self, message: object) -> None:
        """Publish a `message`, or what travels: its readers get it as it is."""
        data = message if isinstance(message, Carried) else bytes(serialize_message(message))
        if self._readers:
            self._enqueue(self._readers, data)
        if self._period:
            now = time.monotonic()
            if now - self._shown_at < self._period:
                return
            self._shown_at = now
            if not self._outside.get_subscription_count():
                return
        self._outside.publish(data if isinstance(data, bytes) else data.to_bytes())

    def get_subscription_count(self) -> int:
        """Return the number of readers, in this process and in others."""
        return len(self._readers) + self._outside.get_subscription_count()

    def wait_for_all_acked(self, timeout: Duration) -> bool:
        """Wait, at most for `timeout`, until other processes have what they were sent."""
        return bool(self._outside.wait_for_all_acked(timeout))


class LocalSubscription:
    """A `reader`'s place on a topic of this `name` in memory; `publishers` are those of the topic."""

    def __init__(self, name: str, reader: Reader, publishers: list[LocalPublisher]) -> None:
        self.topic_name, self.reader = name, reader
        self._publishers = publishers

    def get_publisher_count(self) -> int:
        """Return the number of publishers in this process."""
        return len(self._publishers)


class Exchange:
    """All topics of one process.

    Parameters
    ----------
    is_public : other processes get every message, not only a glance of each topic

    Attributes
    ----------
    wake : completes when a message waits
    """

    def __init__(self, *, is_public: bool) -> None:
        self._is_public = is_public
        self._identity = ""
        self._readers: defaultdict[str, list[Reader]] = defaultdict(list)
        self._publishers: defaultdict[str, list[LocalPublisher]] = defaultdict(list)
        self._queue: deque[tuple[list[Reader], Carried, int]] = deque()
        self.wake: Future[None] = Future()

    def add_publisher(self, topic: Topic, outside: Publisher[Any], identity: str) -> LocalPublisher:
        """Publish a `topic` in memory beside its publisher `outside`, as the process of an `identity`."""
        self._identity = identity
        name = outside.topic_name
        is_whole = self._is_public or topic.role in LASTING or topic.name in _ALWAYS
        publisher = LocalPublisher(self._readers[name], self._enqueue, outside, 0.0 if is_whole else GLANCE)
        self._publishers[name].append(publisher)
        return publisher

    def subscribe(self, name: str, reader: Reader) -> LocalSubscription:
        """Give every message of the topic with the resolved `name` to a `reader`."""
        self._readers[name].append(reader)
        return LocalSubscription(name, reader, self._publishers[name])

    def leave(self, members: Iterable[LocalPublisher | LocalSubscription]) -> None:
        """Let go of `members`, publishers and subscriptions of a node that leaves."""
        for member in members:
            if isinstance(member, LocalPublisher):
                self._publishers[member.topic_name].remove(member)
            else:
                self._readers[member.topic_name].remove(member.reader)

    def _enqueue(self, readers: list[Reader], data: Carried) -> None:
        self._queue.append((readers, data, time.time_ns()))
        if not self.wake.done():
            self.wake.set_result(None)

    def deliver(self, seconds: float) -> None:
        """Give messages to their readers, until none waits or `seconds` of wall time have passed."""
        queue, identity = self._queue, self._identity
        until = time.monotonic() + seconds
        while queue and time.monotonic() < until:
            readers, data, sent = queue.popleft()
            for reader in readers:
                reader(data, identity, sent)
        if not queue:
            self.wake = Future()
