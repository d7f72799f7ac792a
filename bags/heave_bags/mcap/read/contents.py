"""What a scan finds in an MCAP file: messages in blocks, each with its place, and all else that a file holds."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from mcap.records import Attachment, Channel, Metadata, Schema

from heave_bags.mcap.loss import Loss

IN_JOURNAL = -1
"""Position of messages that lie in the journal beside a file."""


class RawMessage(NamedTuple):
    """One message of `topic` as recorded: `data`, serialised, with `log_time` and `publish_time` [ns]."""

    topic: str
    log_time: int
    publish_time: int
    data: bytes


class Place(NamedTuple):
    """Where messages lie in a file, to be read again.

    Attributes
    ----------
    position : of the chunk, or of the first of messages outside of chunks [bytes]; IN_JOURNAL
    first, until : of the records there [bytes]
    """

    position: int
    first: int
    until: int


class Block(NamedTuple):
    """Messages that lie together in a file, in its order.

    Attributes
    ----------
    place : in the file
    messages : at least one
    sequences : the number that its publisher gave each; 0 where there is none
    is_ascending : no log time is before the one of its predecessor
    """

    place: Place
    messages: list[RawMessage]
    sequences: list[int]
    is_ascending: bool

    @property
    def span(self) -> tuple[int, int]:
        """The first and the last log time [ns]."""
        if self.is_ascending:
            return self.messages[0].log_time, self.messages[-1].log_time
        times = [message.log_time for message in self.messages]
        return min(times), max(times)


@dataclass
class FileContents:
    """What a scan has found in a file beside its messages.

    Attributes
    ----------
    schemas, channels : by id
    metadata, attachments : in the order of the file
    losses : what could not be read
    is_own : this project has written the file
    is_packed : its messages are compressed one by one
    """

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    metadata: list[Metadata] = field(default_factory=list)
    attachments: list[Attachment] = field(default_factory=list)
    losses: list[Loss] = field(default_factory=list)
    is_own: bool = False
    is_packed: bool = False
    complete: bool = False
    """The end of the data section was reached."""
