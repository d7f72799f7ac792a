"""The order in which the messages of a bag are read: that of their log times, whatever the order of the files.

A file in order is read as it comes. One that is not, or files that overlap, are merged by blocks of messages: memory is
bounded by dropping the latest messages held, whose blocks are read again when their time has come.

Log times also go back where the clock of a simulation was reset: then the order of the files is the order.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from heapq import heapify, heappop, heappush
from typing import NamedTuple

from heave_bags.mcap.read.contents import Block, Place, RawMessage

MOST_HELD = 64 << 20
"""Bytes of messages that a merge keeps when it holds twice as many."""
MESSAGE_OVERHEAD = 512
"""Bytes that a message takes in memory beside its data."""
CLOCK_STEP = 1_000_000_000
"""A log time that is earlier than the one before by more than this may be due to a reset [ns]."""
_FIRST_TIMES = 500
"""Times of a topic that are remembered, by which a run that begins again is known."""
_RAREST_STEPS = 20
"""A clock is reset less often than once in so many messages."""

NOT_IN_ORDER = "its messages are not in the order of their log times: they are read in that order"
RESET = "its clock was reset: its messages are read in the order of its files, in which log times go back"
WRONG_INDEX = "its index states wrong times: some messages are not in the order of their log times"

Times = tuple[int, int]
_NOTHING = -1
"""A number below every sequence number."""


class Span(NamedTuple):
    """A block of messages that is to be read: number of its file in the bag, place, first and last log time [ns]."""

    file: int
    place: Place
    first: int
    last: int


def are_ascending(spans: Iterable[Times]) -> bool:
    """Return whether blocks with these `spans`, first and last log time of each, follow each other without overlap."""
    latest = -1
    for first, last in spans:
        if first < latest:
            return False
        latest = last
    return True


@dataclass
class _FirstTimes:
    """Some of the times at which a topic first had messages [ns]."""

    times: set[int]
    earliest: int
    latest: int

    def add(self, time: int) -> None:
        self.times.add(time)
        self.earliest, self.latest = min(self.earliest, time), max(self.latest, time)


class ClockWatch:
    """Distinguishes a simulation's clock that was reset from messages that were written late, in bounded memory.

    After a reset, topics have messages at the very times of the earlier run, which are ticks. Late messages have their
    own times; and where messages come in no order at all, time goes back more often than any clock is reset.
    """

    def __init__(self) -> None:
        self._first: dict[str, _FirstTimes] = {}
        self._previous = 0
        self._messages = self._steps = self._again = self._other = 0

    def observe(self, messages: Sequence[RawMessage]) -> None:
        """Take the next messages in the order of the files."""
        self._messages += len(messages)
        for topic, log_time, _, _ in messages:
            self._steps += log_time < self._previous - CLOCK_STEP
            self._previous = log_time
            first = self._first.setdefault(topic, _FirstTimes(set(), log_time, log_time))
            if self._steps and log_time in first.times:
                self._again += 1
            elif self._steps and first.earliest < log_time < first.latest:
                self._other += 1
            elif len(first.times) < _FIRST_TIMES:
                first.add(log_time)

    @property
    def was_reset(self) -> bool:
        """Whether the clock was reset."""
        return self._steps * _RAREST_STEPS <= self._messages and self._again > self._other


class FileOrder:
    """Puts the messages of blocks in order, block by block as they come, and notes what is not in order.

    Parameters
    ----------
    note : what a reader must know of the order, at first what is known before; "" for files in order
    """

    def __init__(self, *, note: str = "") -> None:
        self.note = note
        self._latest = 0

    def messages(self, block: Block) -> list[RawMessage]:
        """Return the messages of the next block by log time; in its own order where the clock was reset."""
        if self.note == RESET:
            return block.messages
        if block.is_ascending:
            self._follow(block.span)
            return block.messages
        self._follow(block.span)
        watch = ClockWatch()
        watch.observe(block.messages)
        if watch.was_reset:
            self.note = RESET
            return block.messages
        self.note = self.note or NOT_IN_ORDER
        keys = [(message.log_time, number) for message, number in zip(block.messages, block.sequences, strict=True)]
        return [block.messages[index] for index in sorted(range(len(keys)), key=keys.__getitem__)]

    def _follow(self, span: Times) -> None:
        if span[0] < self._latest:
            self.note = WRONG_INDEX
        self._latest = max(self._latest, span[1])


class _Key(NamedTuple):
    """Where a message stands: by its time, its publisher's number, then where it was found."""

    log_time: int
    sequence: int
    span: int
    place: int


class Merge:
    """Reads blocks of messages as one sequence in the order of log times.

    Parameters
    ----------
    spans : of the blocks, in the order of the bag, which decides between equal times
    read : reads the messages of a block
    most_held : bytes of messages that are kept in memory when twice as many are held
    """

    def __init__(self, spans: Sequence[Span], read: Callable[[Span], Iterator[Block]], most_held: int = MOST_HELD):
        self._spans = spans
        self._read = read
        self._most_held = most_held
        self._waiting = [_Key(span.first, _NOTHING, number, 0) for number, span in enumerate(spans)]
        """From which key on each block is to be read; entries of a block that are not its earliest are void."""
        self._earliest = {key.span: key for key in self._waiting}
        heapify(self._waiting)
        self._held: list[tuple[_Key, RawMessage]] = []
        self._size = 0

    def messages(self) -> Iterator[RawMessage]:
        """Yield the messages."""
        while self._waiting or self._held:
            earliest = self._held[0][0] if self._held else None
            while self._waiting and (earliest is None or self._waiting[0] <= earliest):
                key = heappop(self._waiting)
                if self._earliest.get(key.span) == key:
                    del self._earliest[key.span]
                    earliest = self._take(key, earliest)
            self._held.sort()
            count = bisect_left(self._held, (self._waiting[0],)) if self._waiting else len(self._held)
            for _, message in self._held[:count]:
                yield message
            self._size -= sum(_size(message) for _, message in self._held[:count])
            del self._held[:count]

    def _take(self, after: _Key, earliest: _Key | None) -> _Key | None:
        """Hold the messages of a block from the key on; return the key of the earliest message held."""
        index = 0
        for block in self._read(self._spans[after.span]):
            for message, sequence in zip(block.messages, block.sequences, strict=True):
                key = _Key(message.log_time, sequence, after.span, index)
                index += 1
                if key < after:
                    continue
                self._held.append((key, message))
                self._size += _size(message)
                if earliest is None or key < earliest:
                    earliest = key
        if self._size > 2 * self._most_held:
            self._drop_latest()
        return earliest

    def _drop_latest(self) -> None:
        """Keep as many of the earliest messages as are allowed; the blocks of the others wait again."""
        self._held.sort()
        kept = size = 0
        while kept < len(self._held) and (size < self._most_held or not kept):
            size += _size(self._held[kept][1])
            kept += 1
        again: dict[int, _Key] = {}
        for key, _ in self._held[kept:]:
            again.setdefault(key.span, key)
        for span, key in again.items():
            self._earliest[span] = min(key, self._earliest.get(span, key))
            heappush(self._waiting, key)
        del self._held[kept:]
        self._size = size


def _size(message: RawMessage) -> int:
    return len(message.data) + MESSAGE_OVERHEAD
