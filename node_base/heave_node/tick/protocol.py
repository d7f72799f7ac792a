"""What every node sends or reads in every tick, as plain data and as bytes: its part of the tick in one message.

A node of another program may follow the protocol without parts: it publishes each topic by itself and answers by
TickDone, and whoever hears TickStart, TickDone or a topic gets those too.
"""

from __future__ import annotations

import struct
from collections.abc import Collection, Iterator, Sequence
from functools import lru_cache
from struct import Struct
from typing import NamedTuple

from heave_node.cdr.layout import LITTLE_ENDIAN, LayoutError
from heave_node.cdr.packer import Packer
from heave_node.cdr.unpacker import Unpacker

_SECOND = 1_000_000_000
_ALIGNMENT = 4
"""What the middleware fills the length of a message up to: DDSI-RTPS 2.5, section 10.2.1.2."""
_HEAD = Struct("<4sQIIiIB3xI")
_START, _START_FIELDS = "heave_msgs/msg/TickStart", ("epoch", "tick", "flush", "stamp", "published")
_DONE, _DONE_FIELDS = "heave_msgs/msg/TickDone", ("epoch", "tick", "lost", "published")
_start_packer = Packer(_START, _START_FIELDS)
_done_packer, _done_unpacker = Packer(_DONE, _DONE_FIELDS), Unpacker(_DONE, _DONE_FIELDS)


@lru_cache(maxsize=1000)
def _tail(counts: int, messages: int) -> Struct:
    """Return the form of the sequences behind the head but for the data: `counts` numbers and two of `messages`."""
    return Struct(f"<{counts}II{messages}II{messages}II")


class Part(NamedTuple):
    """A node's part of a tick; see heave_msgs/TickPart, whose names these are."""

    tick: int = 0  # number of the tick
    epoch: int = 0  # number of the run
    published: Sequence[int] = ()  # messages sent so far, per output of the node; by the master per entry of the roster
    messages: Sequence[tuple[int, bytes]] = ()  # of the tick: number of the output, and bytes
    lost: int = 0  # messages of the run that never came to the node, at the end of one in real time
    stamp: int = 0  # start of the tick [ns], of the master's part
    flush: bool = False  # the run is over: answer when every message of it is here

    def to_bytes(self) -> bytes:
        """Return the message TickPart."""
        counts, number = len(self.published), len(self.messages)
        seconds, nanoseconds = divmod(self.stamp, _SECOND)
        outputs = [output for output, _ in self.messages]
        data = [data for _, data in self.messages]
        sizes = [len(one) for one in data]
        head = _HEAD.pack(LITTLE_ENDIAN, self.tick, self.epoch, self.lost, seconds, nanoseconds, self.flush, counts)
        tail = _tail(counts, number).pack(*self.published, number, *outputs, number, *sizes, sum(sizes))
        return b"".join((head, tail, *data))

    @classmethod
    def of(cls, data: bytes) -> Part:
        """Return what the message TickPart `data` says. Raises LayoutError where it is no such message."""
        try:
            kind, tick, epoch, lost, seconds, nanoseconds, flush, counts = _HEAD.unpack_from(data)
            (number,) = _LENGTH.unpack_from(data, _HEAD.size + 4 * counts)
            form = _tail(counts, number)
            numbers = form.unpack_from(data, _HEAD.size)
        except (struct.error, MemoryError) as error:
            raise LayoutError(f"it is no TickPart: {error}") from None
        outputs, sizes = numbers[counts + 1 : counts + 1 + number], numbers[counts + 2 + number : -1]
        place = _HEAD.size + form.size
        is_padded = 0 <= len(data) - place - sum(sizes) < _ALIGNMENT
        if kind[:2] != LITTLE_ENDIAN[:2] or numbers[counts + 1 + number] != number or not is_padded:
            raise LayoutError("it is no TickPart: its lengths do not fit")
        messages = []
        for output, size in zip(outputs, sizes, strict=True):
            messages.append((output, data[place : place + size]))
            place += size
        stamp = seconds * _SECOND + nanoseconds
        return cls(tick, epoch, numbers[:counts], messages, lost, stamp, bool(flush))

    def to_start(self) -> bytes:
        """Return the message TickStart of the master's part."""
        return _start_packer.pack(self.epoch, self.tick, self.flush, self.stamp, self.published)

    def to_done(self) -> bytes:
        """Return the message TickDone of a participant's part."""
        return _done_packer.pack(self.epoch, self.tick, self.lost, self.published)

    @classmethod
    def of_done(cls, data: bytes) -> Part:
        """Return what the message TickDone `data` says. Raises LayoutError where it is no such message."""
        epoch, tick, lost, *published = _done_unpacker.unpack(data)
        return cls(tick, epoch, published, (), lost)


class Past(NamedTuple):
    """What the nodes sent in a few ticks, for those that may be behind: a TickPart that holds parts."""

    tick: int  # number of the newest tick in it
    epoch: int  # number of the run
    # first entry of the sender in the roster, and its part, in the order of arrival; from elsewhere as it came
    parts: Sequence[tuple[int, Part | bytes]]

    def to_bytes(self) -> bytes:
        """Return the message TickPart: each of its messages is a part, its output the entry."""
        parts = [(entry, part.to_bytes() if isinstance(part, Part) else part) for entry, part in self.parts]
        return Part(self.tick, self.epoch, (), parts).to_bytes()

    @classmethod
    def of(cls, data: bytes) -> Past:
        """Return what the message TickPart `data` holds. Raises LayoutError where it is no such message."""
        whole = Part.of(data)
        return cls(whole.tick, whole.epoch, whole.messages)

    def parts_of(self, entries: Collection[int]) -> Iterator[tuple[int, Part]]:
        """Yield the parts of these `entries`. Raises LayoutError for one that is none."""
        for entry, part in self.parts:
            if entry in entries:
                yield entry, part if isinstance(part, Part) else Part.of(part)


_LENGTH = Struct("<I")
