"""Reads one MCAP file from front to back, whatever state it is in, and reports what could not be read.

No index is needed: a file whose writer was killed reads to its end, and damage costs the records it hit. Every loss
is named by its place, its span of time and, where it can be known, the number of its messages.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Collection, Iterator, Mapping, MutableMapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import zstandard
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Metadata, Schema
from mcap.summary import Summary

from heave_bags.errors import BagError, NoBagError
from heave_bags.mcap.bounds import LARGEST_RECORD, LATEST_TIME, ZSTD_MAGIC, unpack, unpack_part
from heave_bags.mcap.files import count_in_record
from heave_bags.mcap.loss import NO_FOOTER, Loss, LossAccount
from heave_bags.mcap.records import CHUNK_HEAD, HEAD, MESSAGE_HEAD, UNPARSEABLE, Record, RecordFile, parse, split_chunk
from heave_bags.mcap.storage import read_journal
from heave_bags.mcap.summary import MAGIC, ends_properly, has_interim_ending, read_summary
from heave_bags.mcap.writer import LIBRARY

DAMAGED_CHUNK = (struct.error, zstandard.ZstdError, RuntimeError, ValueError, MemoryError)
"""Errors that unpacking a damaged chunk raises; lz4 raises RuntimeError."""

MOST_IN_BLOCK = 1 << 17
"""Messages of a block: more of a chunk are several blocks."""
_IN_JOURNAL = -1
"""Position of messages that lie in the journal beside a file."""


class RawMessage(NamedTuple):
    """One message of `topic` as recorded: `data`, serialised, with `log_time` and `publish_time` [ns], and the
    `sequence` number that its publisher gave it; 0 for none.
    """

    topic: str
    log_time: int
    data: bytes
    publish_time: int = 0
    sequence: int = 0


@dataclass
class FileContents:
    """What a scan has found in a file beside its messages."""

    schemas: dict[int, Schema] = field(default_factory=dict)  # by id
    channels: dict[int, Channel] = field(default_factory=dict)  # by id
    metadata: list[Metadata] = field(default_factory=list)  # in the order of the file
    attachments: list[Attachment] = field(default_factory=list)  # in the order of the file
    losses: list[Loss] = field(default_factory=list)  # what could not be read
    is_own: bool = False  # this project has written the file
    complete: bool = False  # the end of the data section was reached


class Numbering:
    """Follows the numbers of the messages of one file.

    Parameters
    ----------
    channels : of the file, by id
    carried : the next number of each topic's messages, carried from one file of a bag to the next; a topic that is not
        in it begins with 1. None where the files before this one are not known.

    Attributes
    ----------
    is_on : the messages are numbered, as far as they were read
    missing : messages that gaps in the numbers say are not there
    """

    def __init__(self, channels: Mapping[int, Channel], carried: MutableMapping[str, int] | None) -> None:
        self.is_on = False
        self.missing = 0
        self._channels = channels
        self._carried = carried
        self._next: dict[int, int] = {}

    def is_repeated(self, channel: int, sequence: int) -> bool:
        """Return whether message number `sequence` of a `channel` was read before; count those missing before it."""
        if not sequence:  # numbers begin with 1: these messages have none
            self.is_on = False
            return False
        expected = self._next.get(channel)
        if expected is None:
            topic = self._channels[channel].topic
            expected = sequence if self._carried is None else self._carried.get(topic, 1)
        if sequence < expected:
            return True
        self.missing += sequence - expected
        self._next[channel] = sequence + 1
        return False

    def carry_on(self) -> None:
        """Hand the next numbers on to the file that follows."""
        if self._carried is not None:
            self._carried.update({self._channels[key].topic: number for key, number in self._next.items()})


class McapScan:
    """One pass over an MCAP file. `contents` and `counts` fill while `blocks` is iterated, and are whole at its end.

    Parameters
    ----------
    path : of the file
    expected : how many messages the file has, as is written beside it; None where nothing is
    numbering : the next number of each topic's messages, carried from one file of a bag to the next; a topic that is
        not in it begins with 1. None where the files before this one are not known.
    passed_over : positions of chunks that are not read [bytes]
    """

    def __init__(
        self,
        path: Path,
        *,
        expected: int | None = None,
        numbering: MutableMapping[str, int] | None = None,
        passed_over: Collection[int] = (),
    ) -> None:
        self.path = path
        self.contents = FileContents()
        self.counts: dict[int, int] = {}
        """Messages read, by channel."""
        self.spans: dict[int, tuple[int, int]] = {}
        """First and last log time [ns] of the messages of each chunk, by its position."""
        self._passed_over = passed_over
        self._expected = expected
        self._numbering = Numbering(self.contents.channels, numbering)
        self.position = 0
        """Where reading is in the file [bytes]."""
        self._account = LossAccount(path)
        self._last_time: int | None = None
        self._lost_in_chunk: int | None = None
        self._has_lost_chunk = False
        self._summary: Summary | None = None

    def blocks(self) -> Iterator[list[RawMessage]]:
        """Yield the messages in the order of the file, some at a time.

        Raises BagError if the file is not MCAP or cannot be opened.
        """
        with RecordFile(self.path) as file:
            begins = file.read(0, len(MAGIC))
            if not is_like_magic(begins):
                raise NoBagError(f"{self.path}: {why_not_read(begins)}; {WANTED}")
            if begins != MAGIC:
                self._lose(0, "the bytes that every MCAP file begins with are damaged", 0)
            self._summary = read_summary(file)
            if self._summary is not None:  # channels and schemas there outlive damage to their own chunk
                if self._summary.statistics is not None:
                    self._expected = self._summary.statistics.message_count
                self.contents.schemas |= self._summary.schemas
                self.contents.channels |= self._summary.channels
            yield from self._records(file)
        self._settle()

    # Records -------------------------------------------------------------------------------------------------------

    def _records(self, file: RecordFile) -> Iterator[list[RawMessage]]:
        position = len(MAGIC)
        while position < file.size:
            self.position = position
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
            elif record.opcode == Opcode.MESSAGE and not self._numbering.is_on:
                self._settle_lost_chunk()
                run = file.messages_from(record)
                yield from self._walk(run, position)
                position += len(run)
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

    def _record(self, file: RecordFile, record: Record) -> Iterator[list[RawMessage]]:
        if record.opcode == Opcode.MESSAGE_INDEX:
            self._count_lost(record)
            return
        self._settle_lost_chunk()
        if record.opcode == Opcode.MESSAGE:
            # this project's recorders write messages into chunks alone, where a checksum guards them
            self._lose(record.position, "a record that has become a message by damage", 0)
        elif record.length > 2 * LARGEST_RECORD:
            self._lose(record.position, f"a record of {record.length} bytes, which exceeds the limit,", None)
        elif record.position in self._passed_over:
            return
        elif record.opcode == Opcode.CHUNK:
            yield from self._chunk(file.body(record), record.position)
        elif record.opcode == Opcode.HEADER:
            self._take_header(file.body(record))
        else:
            self._take(record.opcode, file.body(record), record.position)

    def _take_header(self, body: bytes) -> None:
        """Note whose file it is: this project's recorders number the messages of each topic without gaps."""
        self.contents.is_own = is_of_this_project(body)
        self._numbering.is_on = self.contents.is_own

    def _data_end(self, file: RecordFile, record: Record) -> Iterator[list[RawMessage]]:
        """Read the journal of a file whose writer was stopped: it ends properly, but has no summary yet."""
        self.contents.complete = True
        (checksum,) = struct.unpack("<I", file.body(record))
        if self._numbering.is_on and has_interim_ending(file, record.end):
            yield from self._journalled(file, record.position)
            return
        self._settle_lost_chunk()
        if not ends_properly(file):
            self._lose(record.position, "the file ends within its summary", 0)
        elif self._summary is None and not has_interim_ending(file, record.end):
            self._lose(record.position, "a damaged summary", 0)
        elif self._account.is_empty and checksum not in (0, file.checksum(record.position)):
            self._lose(0, "data other than messages has changed (the file's checksum does not match)", 0)

    def _journalled(self, file: RecordFile, position: int) -> Iterator[list[RawMessage]]:
        """Read the journal of what was to follow at `position`, or at the end of a damaged file."""
        self._settle_lost_chunk()
        journal = read_journal(self.path)
        if journal is not None and journal.position in (position, file.size):
            yield from self._walk(journal.records, _IN_JOURNAL, may_be_cut=True)
        elif journal is not None and journal.position > file.size:
            self._lose(position, "the file ends before its journal begins", None)
        if not self._account.is_open:
            self._lose(position, NO_FOOTER, 0)

    def _cut_off(self, file: RecordFile, record: Record) -> Iterator[list[RawMessage]]:
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

    def _chunk(self, body: bytes, position: int) -> Iterator[list[RawMessage]]:
        try:
            _, _, size, checksum, compression, packed = split_chunk(body)
            records = unpack(compression, packed, size)
            if checksum and zlib.crc32(records) != checksum:
                raise ValueError("its checksum does not match")
        except DAMAGED_CHUNK as error:
            self._lose_chunk(body, position, " ".join(str(error).split()) or "unreadable")
            return
        yield from self._walk(records, position)

    def _walk(self, records: bytes, position: int, *, may_be_cut: bool = False) -> Iterator[list[RawMessage]]:
        """Yield the messages of plain records, which may be cut off in the midst of one if they are a journal's."""
        size, offset = len(records), 0
        channels, counts, numbering = self.contents.channels, self.counts, self._numbering
        unpack_head, unpack_message = HEAD.unpack_from, MESSAGE_HEAD.unpack_from
        is_after_loss = self._account.is_open
        messages: list[RawMessage] = []
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
            if channel not in channels or log_time > LATEST_TIME:
                undefined += 1
                continue
            if numbering.is_on and numbering.is_repeated(channel, sequence):
                repeated += 1
                continue
            data = records[body + MESSAGE_HEAD.size : offset]
            if channel not in counts and data.startswith(ZSTD_MAGIC):
                raise BagError(f"{self.path}: each message is compressed: use ros2 bag convert, of a full ROS 2")
            counts[channel] = counts.get(channel, 0) + 1
            if is_after_loss:
                self._account.end_at(log_time)
                is_after_loss = False
            self._last_time = log_time
            messages.append(RawMessage(channels[channel].topic, log_time, data, publish_time, sequence))
            if len(messages) == MOST_IN_BLOCK:
                yield from self._block(messages, position)
                messages = []
        yield from self._block(messages, position)
        if offset != size and not may_be_cut:
            self._lose(position, "corrupt records in a chunk", None)
        self._lose_some(position, repeated, undefined)

    def _lose_some(self, position: int, repeated: int, undefined: int) -> None:
        if repeated:
            self._lose(position, f"{repeated} duplicate messages", 0)
        if undefined:
            self._lose(position, "messages with an undefined channel or an impossible time", undefined)

    def _block(self, messages: list[RawMessage], position: int) -> Iterator[list[RawMessage]]:
        """Yield messages, if there are any."""
        if messages:
            times = [message.log_time for message in messages]
            first, last = self.spans.get(position, (times[0], times[0]))
            self.spans[position] = (min(first, *times), max(last, *times))
            yield messages

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
            self.contents.channels[record.id] = record
        elif isinstance(record, Metadata):
            self.contents.metadata.append(record)
        elif isinstance(record, Attachment):
            problem = attachment_problem(record, body, self.contents.attachments)
            if problem:
                self._lose(position, problem, 0)
            else:
                self.contents.attachments.append(record)

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
        lacking = expected - read if expected is not None and expected >= read else None
        if expected is not None and self.contents.complete and read > expected:
            self._lose(0, f"{read - expected} messages more than the file says it has: some are repeated", 0)
        self._account.in_gaps = self._numbering.missing
        self.contents.losses = self._account.settle(lacking, is_cut=not self.contents.complete)
        self._numbering.carry_on()


def is_like_magic(begins: bytes) -> bool:
    """Return whether `begins`, the first bytes of a file, are those of MCAP, one of them damaged at most."""
    return len(begins) == len(MAGIC) and sum(a != b for a, b in zip(begins, MAGIC, strict=True)) <= 1


WANTED = "give the folder of a bag, or its .mcap file"
"""What a command on a bag takes."""


def why_not_read(begins: bytes) -> str:
    """Return why a file that `begins` so is not read as MCAP; "" if it is."""
    if is_like_magic(begins):
        return ""
    if begins.startswith(ZSTD_MAGIC):
        return "compressed as a whole; unpack it: zstd -d FILE"
    is_text = bool(begins) and all(byte >= 32 or chr(byte).isspace() for byte in begins)
    return "a text file, not an MCAP file" if is_text else "not an MCAP file"


def attachment_problem(attachment: Attachment, body: bytes, before: Sequence[Attachment]) -> str:
    """Return why an `attachment` with a `body` is not taken after those `before`; "" if it is."""
    (checksum,) = struct.unpack_from("<I", body, len(body) - 4)
    if checksum and zlib.crc32(memoryview(body)[:-4]) != checksum:
        return f"the attachment {attachment.name} is damaged"
    if sum(len(other.data) for other in before) + len(attachment.data) > LARGEST_RECORD:
        return f"the attachment {attachment.name} is skipped: at most {LARGEST_RECORD} bytes of attachments are read"
    return ""


def is_of_this_project(header: bytes) -> bool:
    """Return whether the body of a file's `header` says that this project has written it."""
    return header.endswith(struct.pack("<I", len(LIBRARY)) + LIBRARY.encode())
