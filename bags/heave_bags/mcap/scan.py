"""Reads one MCAP file from front to back, whatever state it is in, and says what could not be read.

No index is needed: a file whose writer was killed reads to its end, and damage costs the records it hit. Every loss
is named by its
place, its span of time and, where it can be known, its messages.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import IO, NamedTuple

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Attachment, Channel, Metadata, Schema

from heave_bags.errors import BagError
from heave_bags.mcap.storage import read_journal
from heave_bags.mcap.writer import MAGIC

_HEAD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")
_CHUNK = struct.Struct("<QQQI")
_MAX_RECORD = 1 << 32
_CHUNK_NAMES = (b"\x04\x00\x00\x00zstd", b"\x03\x00\x00\x00lz4")
_NAME_OFFSET = _HEAD.size + _CHUNK.size
_SEARCH_BLOCK = 1 << 20

NO_FOOTER = "the file ends without a footer (its writer was stopped)"


class Message(NamedTuple):
    """One serialised message; times in nanoseconds."""

    channel: int
    log_time: int
    publish_time: int
    sequence: int
    data: bytes


@dataclass(frozen=True)
class Loss:
    """A part of a file that could not be read.

    Attributes
    ----------
    file, position : where it begins [bytes]
    reason : what is wrong there
    start, end : log times between which messages are missing [ns]; None where it cannot be known
    messages : how many were lost; None where it cannot be known
    """

    file: Path
    position: int
    reason: str
    start: int | None = None
    end: int | None = None
    messages: int | None = None

    def __str__(self) -> str:
        if self.start is None or self.end is None:
            span = "an unknown span of time"
        else:
            span = f"{(self.end - self.start) * 1e-9:.3f} s (from {self.start * 1e-9:.3f} s to {self.end * 1e-9:.3f} s)"
        count = "an unknown number of" if self.messages is None else str(self.messages)
        return f"{self.file.name}: {self.reason} at byte {self.position}: {span} with {count} messages lost"


@dataclass
class FileContents:
    """What a scan has found in a file beside its messages."""

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
    """One pass over an MCAP file. `contents` fills while `messages` is iterated, and is whole at its end.

    Parameters
    ----------
    start, end : log times [ns]; chunks that lie outside are skipped without being unpacked
    wanted : whether the messages of a channel are wanted
    progress : called with the position in the file [bytes]
    """

    def __init__(
        self,
        path: Path,
        *,
        start: int = 0,
        end: int = 1 << 63,
        wanted: Callable[[Channel], bool] | None = None,
        progress: Callable[[int], None] = _no_progress,
    ) -> None:
        self.path = path
        self.contents = FileContents()
        self._start = start
        self._end = end
        self._wanted = wanted
        self._unwanted: set[int] = set()
        self._progress = progress
        self._last_time: int | None = None
        self._lost_chunk: Loss | None = None
        self._lost_count: int | None = None

    def messages(self) -> Iterator[Message]:
        """Yield the messages in the order of the file. Raises BagError if the file is not MCAP or cannot be opened."""
        try:
            size = self.path.stat().st_size
            stream = self.path.open("rb")
        except OSError as error:
            raise BagError(f"{self.path}: cannot be read: {error.strerror}") from error
        with stream:
            if stream.read(len(MAGIC)) != MAGIC:
                raise BagError(f"{self.path}: this is not an MCAP file")
            self._take_summary(stream)
            stream.seek(len(MAGIC))
            yield from self._records(stream, size)
            self._settle_lost_chunk()

    def _take_summary(self, stream: IO[bytes]) -> None:
        """Take channels and schemas from the summary, if there is one: they outlive damage to their own chunk."""
        try:
            summary = make_reader(stream).get_summary()
        except (McapError, struct.error, ValueError, OSError, UnicodeDecodeError):
            return
        if summary:
            self.contents.schemas |= summary.schemas
            for channel in summary.channels.values():
                self._take_channel(channel)

    def _take_channel(self, channel: Channel) -> None:
        self.contents.channels[channel.id] = channel
        if self._wanted and not self._wanted(channel):
            self._unwanted.add(channel.id)

    def _records(self, stream: IO[bytes], size: int) -> Iterator[Message]:
        position = len(MAGIC)
        while position + _HEAD.size <= size:
            self._progress(position)
            stream.seek(position)
            opcode, length = _HEAD.unpack(stream.read(_HEAD.size))
            if not 1 <= opcode <= Opcode.DATA_END or length > _MAX_RECORD:
                found = _next_chunk(stream, position + 1, size)
                self._lose(position, "records that make no sense", None)
                if found is None:
                    return
                position = found
                continue
            following = position + _HEAD.size + length
            if following > size:
                yield from self._truncated(stream, opcode, position)
                return
            if opcode == Opcode.DATA_END:
                self.contents.complete = True
                self._check_end(stream, position, size)
                return
            yield from self._record(stream, opcode, position, length)
            position = following
        yield from self._walk(read_journal(self.path, position), position)
        self._settle_lost_chunk()
        self._lose(position, NO_FOOTER, 0)

    def _check_end(self, stream: IO[bytes], position: int, size: int) -> None:
        """Note a file whose summary was cut off; no message is lost by that."""
        stream.seek(size - len(MAGIC))
        if stream.read() != MAGIC:
            self._lose(position, "the file ends within its summary", 0)

    def _record(self, stream: IO[bytes], opcode: int, position: int, length: int) -> Iterator[Message]:
        if opcode == Opcode.MESSAGE_INDEX:
            if self._lost_chunk:
                self._count_lost(stream.read(length))
            return
        self._settle_lost_chunk()
        if opcode == Opcode.CHUNK:
            yield from self._chunk(stream.read(length), position)
        elif opcode in (Opcode.ATTACHMENT, Opcode.METADATA, Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE):
            yield from self._walk(_HEAD.pack(opcode, length) + stream.read(length), position)

    def _truncated(self, stream: IO[bytes], opcode: int, position: int) -> Iterator[Message]:
        """Read what is there of the last record; a compressed chunk gives the blocks that are whole."""
        journal = read_journal(self.path, position)
        if journal:
            yield from self._walk(journal, position)
            self._lose(position, NO_FOOTER, 0)
            return
        rest = stream.read()
        reason = "the file ends within a record"
        if opcode != Opcode.CHUNK or len(rest) < _CHUNK.size + 12:
            self._lose(position, reason, None)
            return
        start, end, _size, _crc = _CHUNK.unpack_from(rest)
        name, data = _chunk_data(rest)
        before = self._last_time
        yield from self._walk(_unpack_part(name, data), position)
        got_some = self._last_time is not None and self._last_time != before
        first = self._last_time if got_some else start
        self.contents.losses.append(Loss(self.path, position, reason, first, max(end, first or 0), None))

    def _chunk(self, record: bytes, position: int) -> Iterator[Message]:
        try:
            start, end, size, crc = _CHUNK.unpack_from(record)
            if (end < self._start or start > self._end) and self.contents.channels and start <= end:
                return
            name, data = _chunk_data(record)
            records = _unpack(name, data, size)
        except (struct.error, zstandard.ZstdError, RuntimeError, ValueError) as error:
            self._lose_chunk(record, position, str(error) or "unreadable")
            return
        if crc and zlib.crc32(records) != crc:
            self._lose_chunk(record, position, "its checksum is wrong")
            return
        yield from self._walk(records, position)

    def _walk(self, records: bytes, position: int) -> Iterator[Message]:
        """Yield the messages of plain records; stop at one that is cut off."""
        offset, size = 0, len(records)
        unwanted = self._unwanted
        while offset + 9 <= size:
            opcode, length = _HEAD.unpack_from(records, offset)
            body = offset + 9
            offset = body + length
            if offset > size:
                return
            if opcode == Opcode.MESSAGE:
                channel, sequence, log_time, publish_time = _MESSAGE.unpack_from(records, body)
                self._last_time = log_time
                if channel not in unwanted and self._start <= log_time <= self._end:
                    yield Message(channel, log_time, publish_time, sequence, records[body + 22 : offset])
            else:
                self._take(opcode, records[body:offset], position)

    def _take(self, opcode: int, body: bytes, position: int) -> None:
        stream = ReadDataStream(BytesIO(body))
        try:
            if opcode == Opcode.SCHEMA:
                schema = Schema.read(stream)
                self.contents.schemas[schema.id] = schema
            elif opcode == Opcode.CHANNEL:
                self._take_channel(Channel.read(stream))
            elif opcode == Opcode.METADATA:
                self.contents.metadata.append(Metadata.read(stream))
            elif opcode == Opcode.ATTACHMENT:
                self.contents.attachments.append(Attachment.read(stream))
        except (McapError, struct.error, UnicodeDecodeError) as error:
            self._lose(position, f"a record of kind {opcode} is broken ({error})", 0)

    def _lose(self, position: int, reason: str, messages: int | None) -> None:
        start = self._last_time
        end = start if messages == 0 else None
        self.contents.losses.append(Loss(self.path, position, reason, start, end, messages))

    def _lose_chunk(self, record: bytes, position: int, error: str) -> None:
        """Note a chunk that cannot be unpacked; the message indexes behind it say how many messages it had."""
        start, end, _size, _crc = _CHUNK.unpack_from(record)
        self._lost_chunk = Loss(self.path, position, f"a damaged chunk ({error})", start, end)
        self._lost_count = None

    def _count_lost(self, index: bytes) -> None:
        if len(index) >= 6:
            self._lost_count = (self._lost_count or 0) + struct.unpack_from("<I", index, 2)[0] // 16

    def _settle_lost_chunk(self) -> None:
        lost = self._lost_chunk
        if lost:
            self.contents.losses.append(
                Loss(lost.file, lost.position, lost.reason, lost.start, lost.end, self._lost_count)
            )
        self._lost_chunk = None


def _chunk_data(record: bytes) -> tuple[str, bytes]:
    """Return compression and compressed records of a chunk record, which may be cut off."""
    offset = _CHUNK.size
    (length,) = struct.unpack_from("<I", record, offset)
    name = record[offset + 4 : offset + 4 + length].decode("ascii")
    return name, record[offset + 4 + length + 8 :]


def _unpack(name: str, data: bytes, size: int) -> bytes:
    if name == "zstd":
        return zstandard.ZstdDecompressor().decompress(data, max_output_size=size)
    if name == "lz4":
        unpacked: bytes = lz4.frame.decompress(data)
        return unpacked
    if name:
        raise ValueError(f"unknown compression {name!r}")
    return data


def _unpack_part(name: str, data: bytes) -> bytes:
    """Unpack the beginning of a cut-off chunk as far as it goes."""
    try:
        if name == "zstd":
            return zstandard.ZstdDecompressor().decompressobj().decompress(data)
        if name == "lz4":
            part: bytes = lz4.frame.LZ4FrameDecompressor().decompress(data)
            return part
    except (zstandard.ZstdError, RuntimeError):
        return b""
    return data


def _next_chunk(stream: IO[bytes], position: int, size: int) -> int | None:
    """Return where the next chunk seems to begin, from `position` on; None if there is none."""
    while position < size:
        stream.seek(position)
        block = stream.read(_SEARCH_BLOCK + 64)
        for name in _CHUNK_NAMES:
            found = block.find(name, _NAME_OFFSET)
            while found >= 0:
                start = found - _NAME_OFFSET
                opcode, length = _HEAD.unpack_from(block, start)
                if opcode == Opcode.CHUNK and length <= size - position - start:
                    return position + start
                found = block.find(name, found + 1)
        position += _SEARCH_BLOCK
    return None
