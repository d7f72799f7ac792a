"""What a node has received of a tick, and what it still lacks: the receiving half of the tick protocol, without ROS.

DDS keeps the order within a topic but not across topics. So every publisher counts what it sends, the counts travel in
each part of a tick, and a node steps when it has received as many messages on each input as its publishers say they
have sent: with the parts themselves, or, of a node of another program, one by one.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Sequence
from typing import Any

from heave_node.interface.topics import is_part
from heave_node.tick.speakers import ANYONE, Speakers, Standing

_STAMP = slice(4, 12)
"""Bytes of the stamp in a message that begins with a Header (or is a Clock), after 4 bytes of encapsulation."""
_NO_STAMP = bytes(8)
_REMEMBERED = 16
_HELD = 1000
"""Messages that wait at most for the roster to say who may publish."""


def has_stamp(data: bytes) -> bool:
    """Return whether the stamp of a message (`data`) that begins with a Header, or is a Clock, is set."""
    return data[_STAMP] != _NO_STAMP


class Inbox:
    """Messages of one topic in order of arrival, each once.

    Of those that come by themselves, one that comes again byte for byte (its tick was sent again) is dropped. One with
    stamp 0 was sent before the run began and is not counted. One of a process that has no business here is not counted
    either.

    Parameters
    ----------
    topic : resolved name
    decode : makes of the bytes what `take` gives; called on arrival, while the node waits for the rest of its tick
    is_external : the topic comes from outside the protocol, see Speakers
    comes_alone : its messages are never taken from parts
    on_stranger : gets identity and bytes of a message of a process that may not speak here

    Attributes
    ----------
    is_carried : its messages come with the parts of their publishers: those that come by themselves are copies
    waiting : messages that wait to be taken, oldest first
    """

    def __init__(
        self,
        topic: str,
        decode: Callable[[bytes], Any] = bytes,
        *,
        is_external: bool = False,
        comes_alone: bool = False,
        on_stranger: Callable[[str, bytes], None] | None = None,
    ) -> None:
        self.topic = topic
        self.comes_alone = comes_alone
        self.speakers = Speakers(is_external=is_external)
        self.is_carried = False
        self._on_stranger = on_stranger
        self._held: deque[tuple[bytes, str]] = deque(maxlen=_HELD)
        self.received = 0
        self._decode = decode
        self.waiting: deque[Any] = deque()
        self._recent: deque[bytes] = deque(maxlen=_REMEMBERED)

    def appoint(self, identities: Collection[str]) -> None:
        """Let the processes of these identities speak; messages that came before this was known are judged now."""
        self.speakers.appoint(identities)
        held, self._held = self._held, deque(maxlen=_HELD)
        for data, identity in held:
            self.put(data, identity)

    def put(self, data: bytes, identity: str = ANYONE) -> bool:
        """Take the bytes of a message.

        Parameters
        ----------
        data : the bytes
        identity : of the process that sent them

        Returns
        -------
        False where the message was dropped, or waits for the roster to say whether its sender may publish.
        """
        if self.is_carried:
            return False
        is_external = self.speakers.is_external  # hardware need not stamp, and may well say the same thing twice
        if not has_stamp(data) and not is_external:
            return False
        standing = self.speakers.standing(identity)
        if standing is Standing.UNKNOWN:
            self._held.append((data, identity))
            return False
        if standing is Standing.STRANGER:
            if self._on_stranger is not None:
                self._on_stranger(identity, data)
            return False
        if data in self._recent and not is_external:
            return False
        self._recent.append(data)
        self.accept(data)
        return True

    def accept(self, data: bytes) -> None:
        """Take the bytes (`data`) of a message that is known to be new and lawful."""
        self.waiting.append(self._decode(data))
        self.received += 1

    def end_run(self) -> None:
        """Discard the bytes of past messages: the next run may begin with the same ones."""
        self._recent.clear()

    def take(self, expected: int) -> list[Any]:
        """Return the messages not yet taken, up to number `expected` since the start; later ones stay in the inbox."""
        if self.received > expected:
            return [self.waiting.popleft() for _ in range(len(self.waiting) - (self.received - expected))]
        waiting = list(self.waiting)
        self.waiting.clear()
        return waiting


class TickGate:
    """Decides whether a node has everything of the tick it is in.

    Parameters
    ----------
    inputs : resolved names of the topics the node needs
    after : names of the nodes whose part of a tick this node waits for
    lockstep : True: each tick sees exactly its own messages; False (real time): whatever has come
    """

    def __init__(self, inputs: Sequence[str], after: Sequence[str], *, lockstep: bool = True) -> None:
        self.lockstep = lockstep
        self.inboxes = {topic: Inbox(topic) for topic in inputs}
        self.after = tuple(after)
        self.tick = (0, 0)
        self._publishers: dict[str, list[tuple[str, int, int]]] = {}
        self._carried: dict[str, list[Inbox | None]] = {}
        self._parts: dict[str, int] = {}
        self._identities: dict[str, str] = {}
        self._started: Sequence[int] = ()
        self._done: dict[str, tuple[tuple[int, int], Sequence[int]]] = {}
        self._plain: list[tuple[Inbox, int]] = []
        self._others: list[Inbox] = []
        self._lacking: list[tuple[Inbox, int]] | None = None
        self._before: dict[str, int] = {}

    def add_inbox(self, inbox: Inbox) -> Inbox:
        """Wait for the messages of another `inbox` too; return the one of its topic."""
        return self.inboxes.setdefault(inbox.topic, inbox)

    def set_roster(self, nodes: Sequence[str], topics: Sequence[str], identities: Sequence[str] = ()) -> None:
        """Learn the order of the counters and who may publish.

        Parameters
        ----------
        nodes, topics : entry i counts what `nodes[i]` published on `topics[i]`
        identities : of the process of each entry; empty: anybody may publish
        """
        position_in_node: dict[str, int] = {}
        self._carried = {node: [] for node in nodes}
        identities_before, self._identities = self._identities, dict(zip(nodes, identities, strict=False))
        for node, identity in self._identities.items():
            if identities_before.get(node) != identity:  # a new process starts its counts at zero
                self._parts.pop(node, None)
        sends_parts = {node for node, topic in zip(nodes, topics, strict=True) if is_part(topic)}
        self._publishers = {topic: [] for topic in self.inboxes}
        for entry, (node, topic) in enumerate(zip(nodes, topics, strict=True)):
            position = position_in_node.get(node, 0)
            position_in_node[node] = position + 1
            inbox = self.inboxes.get(topic)
            self._carried[node].append(None if inbox is None or inbox.comes_alone else inbox)
            if topic in self._publishers:
                self._publishers[topic].append((node, entry, position))
        for topic, inbox in self.inboxes.items():
            names = {node for node, _, _ in self._publishers[topic]}
            inbox.is_carried = bool(names) and names <= sends_parts and not inbox.comes_alone
            entries = [entry for _, entry, _ in self._publishers[topic]]
            if entries or not inbox.speakers.is_external:
                inbox.appoint([identities[entry] for entry in entries] if identities else [ANYONE])
        # most topics are counted by the start of a tick alone, and are many
        rows = [(self.inboxes[topic], publishers) for topic, publishers in self._publishers.items()]
        is_plain = [len(row) == 1 and row[0][0] not in self.after for _, row in rows]
        self._plain = [(box, row[0][1]) for (box, row), plain in zip(rows, is_plain, strict=True) if plain]
        self._others = [box for (box, _), plain in zip(rows, is_plain, strict=True) if not plain]
        self._lacking = None

    def begin(self, epoch: int, tick: int, published: Sequence[int]) -> None:
        """Enter tick `tick` of run `epoch`, before which `published` messages were sent (per entry of the roster)."""
        is_late = self.tick == (0, 0) and tick > 1
        self.tick = (epoch, tick)
        self._started = published
        self._lacking = None
        if is_late:  # in the place of a process that has left: what that one got is not lost
            self._before = {topic: max(0, self.expected(topic) - box.received) for topic, box in self.inboxes.items()}

    def take_part(self, node: str, number: int, messages: Sequence[tuple[int, bytes]]) -> bool:
        """Take the messages that a part of a tick carries; return False where it had come before.

        Parameters
        ----------
        node : that sent it
        number : of the part, counted by the node
        messages : number of the output and bytes of each
        """
        if number <= self._parts.get(node, 0):
            return False
        self._parts[node] = number
        inboxes = self._carried[node]
        for output, data in messages:
            inbox = inboxes[output]
            if inbox is not None:
                inbox.accept(data)
        return True

    def peer_done(self, node: str, epoch: int, tick: int, published: Sequence[int]) -> None:
        """Note that `node` has done its part of tick `tick` of run `epoch`.

        Parameters
        ----------
        node : name
        epoch, tick : numbers of run and tick
        published : messages that the node has sent so far on each of its outputs
        """
        if node in self.after:
            self._done[node] = ((epoch, tick), published)
            self._lacking = None

    def expected(self, topic: str) -> int:
        """Return how many messages on `topic` since the start this node must have in this tick."""
        total, started, done = 0, self._started, self._done
        for node, entry, position in self._publishers.get(topic, ()):
            count = started[entry] if started else 0
            if node in done:
                count = max(count, done[node][1][position])
            total += count
        return total

    def is_complete(self) -> bool:
        """Return whether everything of this tick has come."""
        for node in self.after:
            if self._tick_of(node) < self.tick:
                return False
        if self._lacking is None:
            started = self._started
            plain = self._plain if started else ()
            self._lacking = [(box, started[entry]) for box, entry in plain if box.received < started[entry]]
            counted = [(box, self.expected(box.topic)) for box in self._others]
            self._lacking += [(box, count) for box, count in counted if box.received < count]
        lacking = self._lacking  # called after each message, so complete inputs are not checked again
        while lacking and lacking[-1][0].received >= lacking[-1][1]:
            lacking.pop()
        return not lacking

    def missing(self) -> str:
        """Describe what is missing; "" where nothing is."""
        waiting = [f"{node} to end tick {self.tick[1]}" for node in self.after if self._tick_of(node) < self.tick]
        for topic, inbox in self.inboxes.items():
            expected = self.expected(topic)
            if inbox.received < expected:
                names = " and ".join(sorted({node for node, _, _ in self._publishers[topic]}))
                waiting.append(f"{topic} from {names} ({inbox.received} of {expected} messages)")
        return ", ".join(waiting)

    def lost(self) -> int:
        """Return how many messages of the run have not come, since this node takes part."""
        lacking = (
            self.expected(topic) - box.received - self._before.get(topic, 0) for topic, box in self.inboxes.items()
        )
        return sum(max(0, count) for count in lacking)

    def ticks_behind(self, node: str) -> int:
        """Return for how many ticks before this one a `node` has not answered; 0 where none waits for it."""
        if node not in self.after:
            return 0
        epoch, done = self._tick_of(node)
        return max(0, self.tick[1] - 1 - (done if epoch == self.tick[0] else 0))

    def take(self, topic: str) -> list[Any]:
        """Return the new messages on `topic`; in lockstep those of the next tick stay in the inbox."""
        inbox = self.inboxes[topic]
        return inbox.take(self._due(topic)) if inbox.waiting else []

    def clear(self) -> None:
        """Drop the messages of this tick."""
        for topic, inbox in self.inboxes.items():
            inbox.take(self._due(topic))

    def end_run(self) -> None:
        """Note that the run is over and all its messages have come: those that nobody took are dropped.

        Others may be in the next run already. In lockstep the counts of the last start say what is of this one.
        """
        for topic, inbox in self.inboxes.items():
            publishers = self._publishers.get(topic)
            counts = self._started if self.lockstep else ()
            inbox.take(sum(counts[entry] for _, entry, _ in publishers) if counts and publishers else inbox.received)
            inbox.end_run()

    def _due(self, topic: str) -> int:
        if self.lockstep and self._publishers.get(topic):
            return self.expected(topic)
        return self.inboxes[topic].received

    def _tick_of(self, node: str) -> tuple[int, int]:
        return self._done[node][0] if node in self._done else (0, -1)
