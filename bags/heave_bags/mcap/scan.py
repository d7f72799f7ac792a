"""Reads one MCAP file from front to back, whatever state it is in, and reports what could not be read.

No index is needed: a file whose writer was killed reads to its end, and damage costs the records it hit. Every loss
is named by its place, its span of time and, where it can be known, the number of its messages.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator, MutableMapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import zstandard
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Metadata, Schema

from heave_bags.errors import BagError
from heave_bags.mcap.bounds import LARGEST_RECORD, LATEST_TIME, unpack, unpack_part
from heave_bags.mcap.files import count_in_record
from heave_bags.mcap.loss import NO_FOOTER, Loss, LossAccount
from heave_bags.mcap.records import CHUNK_HEAD, HEAD, MESSAGE_HEAD, UNPARSEABLE, Record, RecordFile, parse, split_chunk
from heave_bags.mcap.storage import read_journal
from heave_bags.mcap.summary import MAGIC, Summary, ends_properly, has_interim_ending, read_summary
from heave_bags.mcap.writer import LIBRARY

DAMAGED_CHUNK = (struct.error, zstandard.ZstdError, RuntimeError, ValueError, MemoryError)
"""What unpacking a chunk raises where it is damaged; lz4 raises RuntimeError."""

_CHECKED_AT_ONCE = 1 << 20


class Message(NamedTuple):
    """One serialised message.

    Attributes
    ----------
    channel : id
    log_time, publish_time : [ns]
    sequence : number that its publisher gave it
    data : serialised
    """

    channel: int
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
    """

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    metadata: list[Metadata] = field(default_factory=list)
    attachments: list[Attachment] = field(default_factory=list)
    losses: list[Loss] = field(default_factory=list)
    complete: bool = False
    """The end of the data section was reached."""


def _no_progress(_position: int) -> None:
    """Ignore progress."""


class McapScan:
    """One pass over an MCAP file. `contents` and `counts` fill while `messages` is iterated, and are whole at its end.

    Parameters
    ----------
    path : of the file
    start, end : log times [ns]; chunks that lie outside are skipped without being unpacked
    wanted : whether the messages of a channel are wanted
    expected : how many messages the file has, as is written beside it; None where nothing is
    numbering : the next number of each topic's messages, carried from one file of a bag to the next; a topic that is
        not in it begins with 1. None where the files before this one are not known.
    progress : called with the position in the file [bytes]
    """

    def __init__(
        self,
        path: Path,
        *,
        start: int = 0,
        end: int = LATEST_TIME,
        wanted: Callable[[Channel], bool] | None = None,
        expected: int | None = None,
        numbering: MutableMapping[str, int] | None = None,
        progress: Callable[[int], None] = _no_progress,
    ) -> None:
        self.path = path
        self.contents = FileContents()
        self.counts: dict[int, int] = {}
        """Messages read, by channel, wanted or not."""
        self._start = start
        self._end = end
        self._is_whole = start <= 0 and end >= LATEST_TIME
        self._wanted = wanted
        self._unwanted: set[int] = set()
        self._expected = expected
        self._numbering = numbering
        self._next_number: dict[int, int] = {}
        self._is_numbered = False
        self._progress = progress
        self._account = LossAccount(path)
        self._last_time: int | None = None
        self._lost_in_chunk: int | None = None
        self._has_lost_chunk = False
        self._summary: Summary | None = None

    def messages(self) -> Iterator[Message]:
        """Yield the messages in the order of the file. Raises BagError if the file is not MCAP or cannot be opened."""
        with RecordFile(self.path) as file:
            begins = file.read(0, len(MAGIC))
            if not _is_like_magic(begins):
                raise BagError(f"{self.path}: not an MCAP file")
            if begins != MAGIC:
                self._lose(0, "the bytes that every MCAP file begins with are damaged", 0)
            self._take_summary(read_summary(file))
            yield from self._records(file)
        self._settle()

    def _take_summary(self, summary: Summary | None) -> None:
        """Take channels and schemas from the summary, if there is one: they outlive damage to their own chunk."""
        self._summary = summary
        if summary is None:
            return
        if summary.message_count is not None:
            self._expected = summary.message_count
        self.contents.schemas |= summary.schemas
        for channel in summary.channels.values():
            self._take_channel(channel)

    def _take_channel(self, channel: Channel) -> None:
        self.contents.channels[channel.id] = channel
        if self._wanted and not self._wanted(channel):
            self._unwanted.add(channel.id)
        else:
            self._unwanted.discard(channel.id)

    # Records -------------------------------------------------------------------------------------------------------

    def _records(self, file: RecordFile) -> Iterator[Message]:
        position = len(MAGIC)
        while position < file.size:
            self._progress(position)
            record = file.record_at(position)
            if record is None:
                following = self._skip_damage(file, position)
                if following is None:
                    yield from self._journalled(file, position)
                    return
                position = following
            elif record.end > file.size:
                yield from self._cut_off(file, record)
                return
            elif record.opcode == Opcode.DATA_END:
                yield from self._data_end(file, record)
                return
            else:
                yield from self._record(file, record)
                position = record.end
        yield from self._journalled(file, position)

    def _skip_damage(self, file: RecordFile, position: int) -> int | None:
        """Note damage, and return where reading goes on; None where it does not."""
        self._settle_lost_chunk()
        record = file.record_of_stated_length(position)
        following = file.next_chunk(position + 1) if record is None else record.end
        self._lose(position, "corrupt records", None)
        return following

    def _record(self, file: RecordFile, record: Record) -> Iterator[Message]:
        if record.opcode == Opcode.MESSAGE_INDEX:
            self._count_lost(record)
            return
        self._settle_lost_chunk()
        if record.length > 2 * LARGEST_RECORD:
            self._lose(record.position, f"a record of {record.length} bytes, which exceeds the limit,", None)
        elif record.opcode == Opcode.CHUNK:
            yield from self._chunk(file.body(record), record.position)
        elif record.opcode == Opcode.HEADER:
            self._take_header(file.body(record))
        elif record.opcode == Opcode.MESSAGE:
            yield from self._walk(file.read(record.position, record.end - record.position), record.position)
        else:
            self._take(record.opcode, file.body(record), record.position)

    def _take_header(self, body: bytes) -> None:
        """Note whose file it is: this project's recorders number the messages of each topic without gaps."""
        self._is_numbered = self._is_whole and body.endswith(struct.pack("<I", len(LIBRARY)) + LIBRARY.encode())

    def _data_end(self, file: RecordFile, record: Record) -> Iterator[Message]:
        """Read the journal of a file whose writer was stopped: it ends properly, but has no summary yet."""
        self.contents.complete = True
        (checksum,) = struct.unpack("<I", file.body(record))
        if self._is_numbered and has_interim_ending(file, record.end):
            yield from self._journalled(file, record.position)
            return
        self._settle_lost_chunk()
        if not ends_properly(file):
            self._lose(record.position, "the file ends within its summary", 0)
        elif self._summary is None and not has_interim_ending(file, record.end):
            self._lose(record.position, "a damaged summary", 0)
        elif self._is_whole and self._account.is_empty and checksum not in (0, _checksum(file, record.position)):
            self._lose(0, "data other than messages has changed (the file's checksum does not match)", 0)

    def _journalled(self, file: RecordFile, position: int) -> Iterator[Message]:
        """Read the journal of what was to follow at `position`, or at the end of a damaged file."""
        self._settle_lost_chunk()
        journal = read_journal(self.path)
        if journal is not None and journal.position in (position, file.size):
            yield from self._walk(journal.records, position, may_be_cut=True)
        elif journal is not None and journal.position > file.size:
            self._lose(position, "the file ends before its journal begins", None)
        if not self._account.is_open:
            self._lose(position, NO_FOOTER, 0)

    def _cut_off(self, file: RecordFile, record: Record) -> Iterator[Message]:
        """Read what exists of the last record; a compressed chunk gives the blocks that are whole."""
        self._settle_lost_chunk()
        journal = read_journal(self.path)
        if journal is not None and journal.position == record.position:
            yield from self._journalled(file, record.position)
            return
        reason = "the file ends within a record"
        if record.opcode != Opcode.CHUNK:
            self._lose(record.position, reason, None)
            return
        try:
            start, end, _, _, compression, packed = split_chunk(file.read(record.body, LARGEST_RECORD))
            records = unpack_part(compression, packed)
        except DAMAGED_CHUNK:
            self._lose(record.position, reason, None)
            return
        yield from self._walk(records, record.position, may_be_cut=True)
        first = start if self._last_time is None else self._last_time
        self._lose(record.position, reason, None, first, max(end, first))

    # Chunks --------------------------------------------------------------------------------------------------------

    def _chunk(self, body: bytes, position: int) -> Iterator[Message]:
        if self._lies_outside(body, position):
            return
        try:
            _, _, size, checksum, compression, packed = split_chunk(body)
            records = unpack(compression, packed, size)
            if checksum and zlib.crc32(records) != checksum:
                raise ValueError("its checksum does not match")
        except DAMAGED_CHUNK as error:
            self._lose_chunk(body, position, " ".join(str(error).split()) or "unreadable")
            return
        yield from self._walk(records, position)

    def _lies_outside(self, body: bytes, position: int) -> bool:
        """Return whether a chunk lies outside of the wanted times, by its own head and by the summary."""
        if self._is_whole or self._summary is None:
            return False
        first, last = struct.unpack_from("<QQ", body)
        outside = (last < self._start or first > self._end) and first <= last
        return outside and self._summary.chunk_spans.get(position) == (first, last)

    def _walk(self, records: bytes, position: int, *, may_be_cut: bool = False) -> Iterator[Message]:
        """Yield the messages of plain records, which may be cut off in the midst of one if they are a journal's."""
        offset, size = 0, len(records)
        unwanted, known, counts = self._unwanted, self.contents.channels, self.counts
        unpack_head, unpack_message = HEAD.unpack_from, MESSAGE_HEAD.unpack_from
        undefined = repeated = 0
        while offset + HEAD.size <= size:
            opcode, length = unpack_head(records, offset)
            body = offset + HEAD.size
            offset = body + length
            if offset > size or not opcode:
                break
            if opcode != Opcode.MESSAGE:
                self._take(opcode, records[body:offset], position)
                continue
            if length < MESSAGE_HEAD.size:
                undefined += 1
                continue
            channel, sequence, log_time, publish_time = unpack_message(records, body)
            if channel not in known or log_time > LATEST_TIME:
                undefined += 1
                continue
            if self._is_numbered and self._is_repeated(channel, sequence):
                repeated += 1
                continue
            counts[channel] = counts.get(channel, 0) + 1
            if self._account.is_open:
                self._account.end_at(log_time)
            self._last_time = log_time
            if channel not in unwanted and self._start <= log_time <= self._end:
                yield Message(channel, log_time, publish_time, sequence, records[body + MESSAGE_HEAD.size : offset])
        if offset != size and not may_be_cut:
            self._lose(position, "corrupt records in a chunk", None)
        if repeated:
            self._lose(position, f"{repeated} duplicate messages", 0)
        if undefined:
            self._lose(position, "messages with an undefined channel or an impossible time", undefined)

    def _is_repeated(self, channel: int, sequence: int) -> bool:
        """Return whether a message was read before, and count those that are missing before it."""
        if not sequence:  # numbers begin with 1: these messages have none
            self._is_numbered = False
            return False
        expected = self._next_number.get(channel)
        if expected is None:
            topic = self.contents.channels[channel].topic
            expected = sequence if self._numbering is None else self._numbering.get(topic, 1)
        if sequence < expected:
            return True
        self._account.in_gaps += sequence - expected
        self._next_number[channel] = sequence + 1
        return False

    def _take(self, opcode: int, body: bytes, position: int) -> None:
        """Take a record that is not a message."""
        try:
            record = parse(opcode, body)
        except UNPARSEABLE as error:
            self._lose(position, f"a record of kind {opcode} is corrupt ({' '.join(str(error).split())})", 0)
            return
        if isinstance(record, Schema):
            self.contents.schemas[record.id] = record
        elif isinstance(record, Channel):
            self._take_channel(record)
        elif isinstance(record, Metadata):
            self.contents.metadata.append(record)
        elif isinstance(record, Attachment):
            self._take_attachment(record, body, position)

    def _take_attachment(self, attachment: Attachment, body: bytes, position: int) -> None:
        problem = attachment_problem(attachment, body, self.contents.attachments)
        if problem:
            self._lose(position, problem, 0)
        else:
            self.contents.attachments.append(attachment)

    # Losses --------------------------------------------------------------------------------------------------------

    def _lose(
        self, position: int, reason: str, messages: int | None, start: int | None = None, end: int | None = None
    ) -> None:
        if start is None:
            start = self._last_time
            end = start if messages == 0 else None
        self._account.add(position, reason, messages, start, end)

    def _lose_chunk(self, body: bytes, position: int, error: str) -> None:
        """Note a chunk that cannot be unpacked; the message indexes after it say how many messages it had."""
        start, end = struct.unpack_from("<QQ", body) if len(body) >= CHUNK_HEAD.size else (1, 0)
        is_possible = max(self._last_time or 0, 0) <= start <= end <= LATEST_TIME
        span = (start, end) if is_possible else (None, None)
        self._lose(position, f"a damaged chunk ({error})", None, *span)
        self._has_lost_chunk, self._lost_in_chunk = True, None

    def _count_lost(self, index: Record) -> None:
        if self._has_lost_chunk:
            self._lost_in_chunk = (self._lost_in_chunk or 0) + (index.length - 6) // 16

    def _settle_lost_chunk(self) -> None:
        if self._has_lost_chunk and self._lost_in_chunk is not None:
            self._account.set_count(self._lost_in_chunk)
        self._has_lost_chunk = False

    def _settle(self) -> None:
        """Report what the pass has lost, once it has reached the end."""
        self._settle_lost_chunk()
        read = sum(self.counts.values())
        expected = self._expected if self._expected is not None else count_in_record(self.contents.metadata)
        is_told = self._is_whole and expected is not None and expected >= read
        lacking = expected - read if is_told and expected is not None else None
        self.contents.losses = self._account.settle(lacking, is_cut=not self.contents.complete)
        if self._numbering is not None:
            channels = self.contents.channels
            self._numbering.update({channels[key].topic: number for key, number in self._next_number.items()})


def _is_like_magic(begins: bytes) -> bool:
    """Return whether the first bytes of a file are those of MCAP, one of them damaged at most."""
    return len(begins) == len(MAGIC) and sum(a != b for a, b in zip(begins, MAGIC, strict=True)) <= 1


def attachment_problem(attachment: Attachment, body: bytes, before: Sequence[Attachment]) -> str:
    """Return why an `attachment` with a `body` is not taken after those `before`; "" if it is."""
    (checksum,) = struct.unpack_from("<I", body, len(body) - 4)
    if checksum and zlib.crc32(memoryview(body)[:-4]) != checksum:
        return f"the attachment {attachment.name} is damaged"
    if sum(len(other.data) for other in before) + len(attachment.data) > LARGEST_RECORD:
        return f"the attachment {attachment.name} is skipped: at most {LARGEST_RECORD} bytes of attachments are read"
    return ""


def _checksum(file: RecordFile, end: int) -> int:
    """Return the checksum of a file up to byte `end`."""
    checksum = 0
    for position in range(0, end, _CHECKED_AT_ONCE):
        checksum = zlib.crc32(file.read(position, min(_CHECKED_AT_ONCE, end - position)), checksum)
    return checksum
