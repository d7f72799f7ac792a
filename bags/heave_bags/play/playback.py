"""When to play which message of a bag: rate, start, duration, loop, pause, step and selection. No ROS, no clock
of its own.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatch

from heave_node.interface.topics import TOPIC_BY_NAME

from heave_bags.errors import BagError
from heave_bags.mcap.loss import remarks
from heave_bags.mcap.reader import Bag, RawMessage

_SORTED_AHEAD = 512
_SORTED_BYTES = 32 << 20
AT_ONCE = 2000
"""Largest number of messages returned at once; the rest follows with the next call."""
_AT_ONCE_BYTES = 8 << 20
LAST_TIME = ((1 << 31) - 1) * 1_000_000_000
"""The last time that ROS messages can hold [ns]: in the year 2038."""
_SECOND = 1_000_000_000


@dataclass(frozen=True)
class PlaybackOptions:
    """What is played, and how fast."""

    rate: float = 1.0  # bag time per wall time [-]
    start: float = 0.0  # of the part that is played, from the bag's beginning [s]
    duration: float = math.inf  # of that part [s]; infinity plays to the end
    loop: bool = False  # start again at the end
    paused: bool = False  # wait for `resume` or `step` before the first message
    topics: Sequence[str] = ()  # patterns of topics to play; none means all
    exclude: Sequence[str] = ()  # patterns of topics to leave out
    nodes: Sequence[str] = ()  # only topics that these nodes published; none means all
    remap: Mapping[str, str] = field(default_factory=dict)  # new names of topics

    def __post_init__(self) -> None:
        if not (math.isfinite(self.rate) and self.rate > 0.0):
            raise BagError(f"rate {self.rate:g} is not allowed: it must be a number above 0")
        if not (self.start >= 0.0 and self.duration > 0.0):
            raise BagError(f"start {self.start:g} s and duration {self.duration:g} s must not be negative")


def publisher_of(bag: Bag, topic: str) -> tuple[str, ...]:
    """Return the nodes that published a topic: as the bag says, or as the suite's table of topics does; empty if
    nobody knows.
    """
    said = bag.outcome.get(f"publishers.{topic}")
    if said is not None:
        return tuple(said.split())
    for name, known in TOPIC_BY_NAME.items():
        if topic.endswith("/" + name) and known.publisher:
            return (known.publisher,)
    return ()


def selected_topics(bag: Bag, options: PlaybackOptions) -> list[str]:
    """Return the topics of `bag` that are to be played by `options`.

    Raises BagError if none is left, or a pattern or node fits nothing.
    """
    for pattern in options.topics:
        if not any(_fits(topic, pattern) for topic in bag.topics):
            raise BagError(f"{bag.path}: no topic matches {pattern}; it has {', '.join(bag.topics)}")
    for node in options.nodes:
        if not any(node in publisher_of(bag, topic) for topic in bag.topics):
            raise BagError(f"{bag.path}: no message in it was published by {node}")
    chosen = [
        topic
        for topic in bag.topics
        if (not options.topics or any(_fits(topic, pattern) for pattern in options.topics))
        and not any(_fits(topic, pattern) for pattern in options.exclude)
        and (not options.nodes or set(options.nodes) & set(publisher_of(bag, topic)))
    ]
    if not chosen:
        raise BagError(f"{bag.path}: no topic is left to play")
    return chosen


def _fits(topic: str, pattern: str) -> bool:
    return fnmatch(topic, pattern) or topic.lstrip("/") == pattern.lstrip("/")


def in_order_of(keyed: Iterable[tuple[int, RawMessage]]) -> Iterator[tuple[int, RawMessage]]:
    """Yield messages with their keys, `keyed`, by key, where they are out of order by no more than a little.

    That is a few hundred messages or some megabytes. Equal keys keep their order.
    """
    heap: list[tuple[int, int, RawMessage]] = []
    size = 0
    for number, (key, message) in enumerate(keyed):
        heapq.heappush(heap, (key, number, message))
        size += len(message.data)
        while len(heap) > _SORTED_AHEAD or (size > _SORTED_BYTES and len(heap) > 1):
            first, _, earliest = heapq.heappop(heap)
            size -= len(earliest.data)
            yield first, earliest
    while heap:
        first, _, earliest = heapq.heappop(heap)
        yield first, earliest


class Playback:
    """Hands out the messages of `bag` that `options` select when they are due.

    Wall times come in as arguments [s], from any steady clock.
    """

    def __init__(self, bag: Bag, options: PlaybackOptions) -> None:
        self._bag = bag
        self._options = options
        self.topics = selected_topics(bag, options)
        self._surveyed = list(bag.notes), list(bag.losses)  # a pass that was broken off has none of its own
        if bag.end_time > LAST_TIME:
            raise BagError(f"{bag.path}: its times are after 2038, which ROS messages cannot represent")
        self._first = bag.start_time + round(options.start * _SECOND)
        if self._first > bag.end_time:
            raise BagError(f"{bag.path}: start {options.start:g} s is after its end,  {bag.duration:.3f} s")
        whole = bag.end_time - self._first
        part = round(options.duration * _SECOND) if math.isfinite(options.duration) else whole
        self._last = self._first + min(part, whole)
        self.rate = options.rate
        self.paused = options.paused
        self.finished = False
        self.rounds = 0
        self._bag_time = self._first
        self._wall: float | None = None
        self._begin()

    @property
    def time(self) -> int:
        """Bag time that has been reached [ns]."""
        return self._bag_time

    @property
    def remarks(self) -> list[str]:
        """What of the bag could not be read in the last pass, and what else a reader must know; one line each."""
        return remarks(self._bag.notes or self._surveyed[0], self._bag.losses or self._surveyed[1])

    def latched(self) -> list[RawMessage]:
        """Return the last message of each latched topic before the start: what a late subscriber would have got."""
        names = [
            name
            for name in self.topics
            if self._bag.topics[name].qos
            and all(offer.durability == "transient_local" for offer in self._bag.topics[name].qos)
        ]
        if not names or self._first <= self._bag.start_time:
            return []
        last = {message.topic: message for message in self._bag.messages(names, end=self._first - 1)}
        return [last[name] for name in sorted(last)]

    def _begin(self) -> None:
        self._messages = self._bag.messages(self.topics, start=self._first, end=self._last)
        self._next = next(self._messages, None)
        self._bag_time = self._first
        if self._next is None:
            self.finished = True

    def due(self, wall: float) -> list[RawMessage]:
        """Return the messages that have become due by wall time `wall` [s]; time stands still while paused."""
        elapsed = 0.0 if self._wall is None else wall - self._wall
        self._wall = wall
        if self.paused or self.finished:
            return []
        self._bag_time += round(elapsed * self.rate * _SECOND)
        found = self._take_until(self._bag_time)
        if self._next is None:
            self._end()
        return found

    def _take_until(self, time: int) -> list[RawMessage]:
        found: list[RawMessage] = []
        left = _AT_ONCE_BYTES
        while self._next is not None and self._next.log_time <= time and len(found) < AT_ONCE and left > 0:
            found.append(self._next)
            left -= len(self._next.data)
            self._next = next(self._messages, None)
        return found

    def _end(self) -> None:
        self.rounds += 1
        if self._options.loop:
            self._begin()
        else:
            self.finished = True

    def step(self, count: int = 1) -> list[RawMessage]:
        """Return the next `count` messages, whenever they would be due; time goes to the last of them."""
        found: list[RawMessage] = []
        while len(found) < count and self._next is not None:
            found.append(self._next)
            self._bag_time = max(self._bag_time, self._next.log_time)
            self._next = next(self._messages, None)
        if self._next is None and not self.finished:
            self._end()
        return found
