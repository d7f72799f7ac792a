"""The two messages of the protocol that every node sends or reads in every tick, as plain data and as bytes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from heave_node.cdr.packer import Packer
from heave_node.cdr.unpacker import Unpacker

_START, _START_FIELDS = "heave_msgs/msg/TickStart", ("epoch", "tick", "flush", "stamp", "published")
_DONE, _DONE_FIELDS = "heave_msgs/msg/TickDone", ("epoch", "tick", "lost", "published")
_start_packer, _start_unpacker = Packer(_START, _START_FIELDS), Unpacker(_START, _START_FIELDS)
_done_packer, _done_unpacker = Packer(_DONE, _DONE_FIELDS), Unpacker(_DONE, _DONE_FIELDS)


class TickStart(NamedTuple):
    """A tick begins; see heave_msgs/TickStart, whose names these are."""

    epoch: int = 0  # number of the run
    tick: int = 0  # number of the tick
    flush: bool = False  # the run is over: answer when every message of it is here
    stamp: int = 0  # start of the tick [ns]
    published: Sequence[int] = ()  # messages sent so far, per entry of the roster

    def to_bytes(self) -> bytes:
        """Return the message."""
        return _start_packer.pack(*self)

    @classmethod
    def of(cls, data: bytes) -> TickStart:
        """Return what the message `data` says. Raises LayoutError where it is no such message."""
        epoch, tick, flush, seconds, nanoseconds, *published = _start_unpacker.unpack(data)
        return cls(epoch, tick, flush, seconds * 1_000_000_000 + nanoseconds, published)


class TickDone(NamedTuple):
    """A node has done its part of a tick; see heave_msgs/TickDone, whose names these are."""

    epoch: int = 0  # number of the run
    tick: int = 0  # number of the tick
    lost: int = 0  # messages of the run that never came to the node, at the end of one in real time
    published: Sequence[int] = ()  # messages sent so far, per output of the node

    def to_bytes(self) -> bytes:
        """Return the message."""
        return _done_packer.pack(*self)

    @classmethod
    def of(cls, data: bytes) -> TickDone:
        """Return what the message `data` says. Raises LayoutError where it is no such message."""
        epoch, tick, lost, *published = _done_unpacker.unpack(data)
        return cls(epoch, tick, lost, published)
