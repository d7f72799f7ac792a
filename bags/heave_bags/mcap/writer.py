"""A fast MCAP writer for one file: chunked, compressed, indexed, readable up to its last chunk after a crash.

Chunks close by size or by span of log time. The same calls give the same bytes. Message records, which come by the
thousands a second, are packed here; all other records are written by the `mcap` library's own record classes.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import lz4.frame
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from heave_bags.mcap.bounds import LARGEST_MESSAGE
from heave_bags.mcap.summary import MAGIC

COMPRESSIONS = ("zstd", "lz4", "")
LIBRARY = "heave_bags"
"""Name of this writer in its files: the messages of each of their topics are numbered from 1, without gaps.
"""

_MESSAGE_HEAD = struct.Struct("<BQHIQQ")
_MESSAGE = int(Opcode.MESSAGE)
_INDEX_HEAD = struct.Struct("<BQHI")
_LENGTH_BEFORE_DATA = 22
"""Bytes of a message record between its length field and its data: channel, sequence, two times."""


class Sink(Protocol):
    """What the writer writes to."""

    def write(self, data: bytes, /) -> object:
        """Take `data`."""
        ...

    def finish(self, data: bytes, /) -> object:
        """Take `data`, with which the file is complete."""
        ...


@dataclass(frozen=True)
class ChunkPolicy:
    """When a chunk closes, and how it is compressed."""

    size: int = 192 * 1024  # uncompressed bytes from which a chunk closes
    span: int = 2_000_000_000  # log time that a chunk may cover [ns]
    compression: str = "zstd"  # "zstd", "lz4" or "" (none)
    level: int = 1  # of zstd

    def __post_init__(self) -> None:
        if self.compression not in COMPRESSIONS:
            raise ValueError(f"compression {self.compression!r} is unknown: it must be zstd, lz4 or empty for none")


@dataclass
class _OpenChunk:
    """Records waiting to be written as one chunk."""

    parts: list[bytes] = field(default_factory=list)
    size: int = 0
    start: int = 0
    end: int = 0
    # per channel: log time and offset of each message, alternating
    index: dict[int, list[int]] = field(default_factory=dict)
    definitions: list[bytes] = field(default_factory=list)  # schemas and channels that are here for the first time

    def append(self, data: bytes) -> None:
        self.parts.append(data)
        self.size += len(data)


def _encode(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]


class McapWriter:
    """Writes one MCAP file to a `sink`; `finish` completes it. Not thread-safe.

    Schemas and channels are in the chunk that needs them first and again in the chunk after it, so that no
    single damage takes them from a file that has no summary yet. Those known before the first message have a chunk of
    their own, so that any reader opens a file whose writer is killed before its first chunk of messages is full.
    `chunks` says when a chunk is full and how it is compressed.
    """

    def __init__(self, sink: Sink, *, chunks: ChunkPolicy | None = None) -> None:
        self._sink = sink
        self._chunks = chunks or ChunkPolicy()
        self._zstd = zstandard.ZstdCompressor(level=self._chunks.level)
        self._chunk = _OpenChunk()
        self._journalled = 0
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._counts: dict[int, int] = {}
        self._chunk_indexes: list[bytes] = []  # as in the file: a tenth of what the records take
        self._attachment_indexes: list[AttachmentIndex] = []
        self._metadata_indexes: list[MetadataIndex] = []
        self.start_time = 0
        self.end_time = 0
        self.message_count = 0
        self.size = 0
        self._checksum = 0
        self._to_repeat: list[bytes] = []
        self._put(MAGIC + _encode(Header(profile="ros2", library=LIBRARY)))

    @property
    def pending_bytes(self) -> int:
        """Uncompressed bytes in the open chunk, which a crash would lose."""
        return self._chunk.size

    def _put(self, data: bytes) -> None:
        self._sink.write(data)
        self._checksum = zlib.crc32(data, self._checksum)
        self.size += len(data)

    def _define(self, record: Schema | Channel) -> None:
        encoded = _encode(record)
        self._chunk.append(encoded)
        self._chunk.definitions.append(encoded)

    def add_schema(self, name: str, encoding: str, data: bytes) -> int:
        """Register the schema `data` of a type, its `name`, in an `encoding`, and return its id."""
        schema = Schema(id=len(self._schemas) + 1, name=name, encoding=encoding, data=data)
        self._schemas.append(schema)
        self._define(schema)
        return schema.id

    def add_channel(self, topic: str, schema_id: int, metadata: Mapping[str, str]) -> int:
        """Register a channel for `topic`, of `schema_id`, with `metadata`, messages in CDR; return its id."""
        channel = Channel(
            id=len(self._channels) + 1,
            topic=topic,
            message_encoding="cdr",
            schema_id=schema_id,
            metadata=dict(metadata),
        )
        self._channels.append(channel)
        self._counts[channel.id] = 0
        self._define(channel)
        return channel.id

    def write(self, channel: int, log_time: int, data: bytes, *, publish_time: int, sequence: int = 0) -> None:
        """Add a message, `data`, to a `channel`, by its id, at its `log_time` and `publish_time` [ns].

        Its `sequence` is the number that its publisher gave it; 0 where there is none.
        """
        chunk, length = self._chunk, len(data)
        if chunk.index:
            is_due = log_time - chunk.start >= self._chunks.span or chunk.size + length > LARGEST_MESSAGE
        else:
            is_due = bool(chunk.size) and not self._chunk_indexes
        if is_due:
            self.close_chunk()
            chunk = self._chunk
        if not chunk.index:
            chunk.start = chunk.end = log_time
            self._repeat_definitions()
        elif log_time > chunk.end:
            chunk.end = log_time
        elif log_time < chunk.start:
            chunk.start = log_time
        chunk.index.setdefault(channel, []).extend((log_time, chunk.size))
        head = _MESSAGE_HEAD.pack(_MESSAGE, _LENGTH_BEFORE_DATA + length, channel, sequence, log_time, publish_time)
        chunk.parts += (head, data)
        chunk.size += _MESSAGE_HEAD.size + length
        self._counts[channel] += 1
        if not self.message_count or log_time < self.start_time:
            self.start_time = log_time
        self.end_time = max(self.end_time, log_time)
        self.message_count += 1
        if chunk.size >= self._chunks.size:
            self.close_chunk()

    def _repeat_definitions(self) -> None:
        """Put those of the chunk before into this one, too."""
        for encoded in self._to_repeat:
            self._chunk.append(encoded)
        self._to_repeat = []

    def take_pending(self) -> bytes:
        """Return the records that the open chunk has gained since the last call, for a journal."""
        parts, self._journalled = self._chunk.parts[self._journalled :], len(self._chunk.parts)
        return b"".join(parts)

    def close_chunk(self) -> None:
        """Write the open chunk with its message indexes; nothing happens if it is empty."""
        chunk, self._chunk = self._chunk, _OpenChunk()
        self._journalled = 0
        if not chunk.size:
            return
        self._to_repeat += chunk.definitions
        records = b"".join(chunk.parts)
        record = Chunk(
            message_start_time=chunk.start,
            message_end_time=chunk.end,
            uncompressed_size=len(records),
            uncompressed_crc=zlib.crc32(records),
            compression=self._chunks.compression,
            data=self._compress(records),
        )
        encoded = _encode(record)
        offset = self.size
        position = offset + len(encoded)
        index_offsets: dict[int, int] = {}
        pieces = [encoded]
        for channel, entries in sorted(chunk.index.items()):
            index_offsets[channel] = position
            size = 8 * len(entries)
            piece = _INDEX_HEAD.pack(Opcode.MESSAGE_INDEX, 6 + size, channel, size)
            piece += struct.pack(f"<{len(entries)}Q", *entries)
            pieces.append(piece)
            position += len(piece)
        self._put(b"".join(pieces))
        self._chunk_indexes.append(
            _encode(
                ChunkIndex(
                    message_start_time=chunk.start,
                    message_end_time=chunk.end,
                    chunk_start_offset=offset,
                    chunk_length=len(encoded),
                    message_index_offsets=index_offsets,
                    message_index_length=position - offset - len(encoded),
                    compression=self._chunks.compression,
                    compressed_size=len(record.data),
                    uncompressed_size=len(records),
                )
            )
        )

    def _compress(self, records: bytes) -> bytes:
        if self._chunks.compression == "zstd":
            return self._zstd.compress(records)
        if self._chunks.compression == "lz4":
            compressed: bytes = lz4.frame.compress(records)
            return compressed
        return records

    def add_attachment(self, name: str, media_type: str, data: bytes) -> None:
        """Add a file of its own to the MCAP file: `name`, `media_type`, `data`; without times."""
        self.close_chunk()
        about: dict[str, Any] = {"create_time": 0, "log_time": 0, "name": name, "media_type": media_type}
        encoded = _encode(Attachment(**about, data=data))
        index = AttachmentIndex(offset=self.size, length=len(encoded), data_size=len(data), **about)
        self._attachment_indexes.append(index)
        self._put(encoded)

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Add a record `name` of names and `values`."""
        self.close_chunk()
        encoded = _encode(Metadata(name=name, metadata=dict(values)))
        self._metadata_indexes.append(MetadataIndex(offset=self.size, length=len(encoded), name=name))
        self._put(encoded)

    def finish(self) -> None:
        """Write the open chunk, the summary and the footer. The sink stays open; the writer must not be used again."""
        self.close_chunk()
        data_end = _encode(DataEnd(data_section_crc=self._checksum))
        start = self.size + len(data_end)
        summary, offsets = self._summary(start)
        offsets_start = start + len(summary)
        summary += offsets
        head = struct.pack("<BQQQ", Opcode.FOOTER, 20, start, offsets_start)
        crc = zlib.crc32(head, zlib.crc32(summary))
        footer = _encode(Footer(summary_start=start, summary_offset_start=offsets_start, summary_crc=crc))
        self._sink.finish(data_end + summary + footer + MAGIC)

    def _summary(self, start: int) -> tuple[bytes, bytes]:
        statistics = Statistics(
            attachment_count=len(self._attachment_indexes),
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=len(self._chunk_indexes),
            message_count=self.message_count,
            metadata_count=len(self._metadata_indexes),
            message_start_time=self.start_time,
            message_end_time=self.end_time,
            schema_count=len(self._schemas),
        )
        groups: list[tuple[int, Iterable[bytes]]] = [
            (Opcode.SCHEMA, map(_encode, self._schemas)),
            (Opcode.CHANNEL, map(_encode, self._channels)),
            (Opcode.STATISTICS, [_encode(statistics)]),
            (Opcode.CHUNK_INDEX, self._chunk_indexes),
            (Opcode.ATTACHMENT_INDEX, map(_encode, self._attachment_indexes)),
            (Opcode.METADATA_INDEX, map(_encode, self._metadata_indexes)),
        ]
        summary = offsets = b""
        for opcode, records in groups:
            group = b"".join(records)
            if group:
                offset = SummaryOffset(group_opcode=opcode, group_start=start + len(summary), group_length=len(group))
                offsets += _encode(offset)
                summary += group
        return summary, offsets
