"""What a scan finds in an MCAP file: messages, and all else that a file holds."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from mcap.records import Attachment, Channel, Metadata, Schema

from heave_bags.mcap.loss import Loss


class RawMessage(NamedTuple):
    """One message of `topic` as recorded: `data`, serialised, with `log_time` [ns]."""

    topic: str
    log_time: int
    data: bytes


class FoundMessage(NamedTuple):
    """One message of `topic` as it lies in a file: `data`, with `log_time` and `publish_time` [ns], and the `sequence`
    number that its publisher gave it; 0 for none.
    """

    topic: str
    log_time: int
    publish_time: int
    sequence: int
    data: bytes


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
    complete : the end of the data section was reached
    """

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    metadata: list[Metadata] = field(default_factory=list)
    attachments: list[Attachment] = field(default_factory=list)
    losses: list[Loss] = field(default_factory=list)
    is_own: bool = False
    is_packed: bool = False
    complete: bool = False
