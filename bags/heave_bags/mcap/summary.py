"""The summary at the end of an MCAP file: definitions, counts, and where chunks, attachments and metadata are."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field
from typing import NamedTuple

from mcap.opcode import Opcode
from mcap.records import Channel, Schema

from heave_bags.mcap.bounds import LARGEST_SUMMARY
from heave_bags.mcap.records import HEAD, UNPARSEABLE, RecordFile, parse

MAGIC = b"\x89MCAP0\r\n"
_FOOTER = struct.Struct("<BQQQI")
"""Opcode, length, start of the summary, start of its offsets, checksum of everything from there to here."""
_FOOTER_LENGTH = 20
_ENDING = _FOOTER.size + len(MAGIC)
_STATISTICS = struct.Struct("<QHIIIIQQI")
_COUNT = struct.Struct("<HQ")
_CHUNK_INDEX = struct.Struct("<QQQQI")
"""First and last log time, position and length of the chunk, bytes of the map of its message indexes."""
_CHUNK_SIZES = struct.Struct("<QI")
"""Bytes of its message indexes, bytes of the name of its compression."""
_UNPACKED_SIZE = struct.Struct("<8xQ")
_INDEX_HEAD = 15
_INDEX_ENTRY = 16
_OFFSET = struct.Struct("<Q")
_DATA_END_HEAD = HEAD.pack(Opcode.DATA_END, 4)
DATA_END_SIZE = HEAD.size + 4


class ChunkEntry(NamedTuple):
    """What the summary says of a chunk.

    Attributes
    ----------
    position, length : of its record in the file [bytes]
    first, last : log times of its messages [ns]
    size : unpacked [bytes]
    messages : in it, by its message indexes; None where it has none
    """

    position: int
    length: int
    first: int
    last: int
    size: int
    messages: int | None


@dataclass
class Summary:
    """What the summary of a file says.

    Attributes
    ----------
    schemas, channels : by id
    message_count, counts : messages in all and by channel; None where the file does not say
    span : first and last log time [ns]; None for a file without messages
    chunk_count : of the file; None where it does not say
    chunks : what is said of the chunk at each position
    attachments, metadata : positions of these records
    """

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    message_count: int | None = None
    counts: dict[int, int] | None = None
    span: tuple[int, int] | None = None
    chunk_count: int | None = None
    chunks: dict[int, ChunkEntry] = field(default_factory=dict)
    attachments: list[int] = field(default_factory=list)
    metadata: list[int] = field(default_factory=list)


def ends_properly(file: RecordFile) -> bool:
    """Return whether a file ends as every completed MCAP file does."""
    return file.size >= _ENDING and file.read(file.size - len(MAGIC), len(MAGIC)) == MAGIC


def has_interim_ending(file: RecordFile, data_end: int) -> bool:
    """Return whether a `file` that ends properly has but a footer without a summary after its data.

    `data_end` is where they end [bytes]. So end files that are being written, and those whose writer was stopped.
    """
    return ends_properly(file) and file.size - data_end == _ENDING


def interim_ending() -> bytes:
    """Return what makes the file of a writer that was stopped one that every reader opens."""
    footer = _FOOTER.pack(Opcode.FOOTER, _FOOTER_LENGTH, 0, 0, 0)
    return _DATA_END_HEAD + bytes(4) + footer + MAGIC


def read_summary(file: RecordFile) -> Summary | None:
    """Return the summary of a file; None if it has none, or one whose checksum is wrong.

    Where the footer points elsewhere, since bytes before it were lost or put in, it is searched for after the data.
    """
    if not ends_properly(file):
        return None
    opcode, length, start, _, _ = _FOOTER.unpack(file.read(file.size - _ENDING, _FOOTER.size))
    if opcode == Opcode.FOOTER and length == _FOOTER_LENGTH:
        found = _read_from(file, start) if start else None
        if found is not None or not start:
            return found
    tail_start = max(0, file.size - LARGEST_SUMMARY)
    tail = file.read(tail_start, LARGEST_SUMMARY)
    behind_data = tail.rfind(_DATA_END_HEAD)
    return None if behind_data < 0 else _read_from(file, tail_start + behind_data + DATA_END_SIZE)


def _read_from(file: RecordFile, start: int) -> Summary | None:
    """Return the summary that begins at `start` and ends with the footer; None if its checksum says it does not."""
    size = file.size - len(MAGIC) - start
    if not _FOOTER.size <= size <= LARGEST_SUMMARY:
        return None
    data = file.read(start, size)
    (checksum,) = struct.unpack_from("<I", data, size - 4)
    if checksum and zlib.crc32(memoryview(data)[:-4]) != checksum:
        return None
    return _parsed(memoryview(data)[: size - _FOOTER.size])


def _parsed(data: memoryview) -> Summary | None:
    summary = Summary()
    offset = 0
    try:
        while offset < len(data):
            opcode, length = HEAD.unpack_from(data, offset)
            offset += HEAD.size
            if length > len(data) - offset:
                return None
            _take(summary, opcode, data[offset : offset + length])
            offset += length
    except UNPARSEABLE:
        return None
    return summary


def _take(summary: Summary, opcode: int, body: memoryview) -> None:
    if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
        record = parse(opcode, bytes(body))
        if isinstance(record, Schema):
            summary.schemas[record.id] = record
        elif isinstance(record, Channel):
            summary.channels[record.id] = record
    elif opcode == Opcode.STATISTICS:
        messages, _, _, _, _, summary.chunk_count, first, last, size = _STATISTICS.unpack_from(body)
        counts = dict(_COUNT.iter_unpack(body[_STATISTICS.size : _STATISTICS.size + size]))
        summary.message_count = messages
        summary.counts = counts if sum(counts.values()) == messages else None
        summary.span = (first, last) if messages else None
    elif opcode == Opcode.CHUNK_INDEX:
        entry = _chunk_entry(body)
        summary.chunks[entry.position] = entry
    elif opcode == Opcode.ATTACHMENT_INDEX:
        summary.attachments.append(_OFFSET.unpack_from(body)[0])
    elif opcode == Opcode.METADATA_INDEX:
        summary.metadata.append(_OFFSET.unpack_from(body)[0])


def _chunk_entry(body: memoryview) -> ChunkEntry:
    first, last, position, length, offsets = _CHUNK_INDEX.unpack_from(body)
    sizes_at = _CHUNK_INDEX.size + offsets
    index_bytes, name = _CHUNK_SIZES.unpack_from(body, sizes_at)
    (size,) = _UNPACKED_SIZE.unpack_from(body, sizes_at + _CHUNK_SIZES.size + name)
    channels = offsets // 10
    messages = (index_bytes - _INDEX_HEAD * channels) // _INDEX_ENTRY if index_bytes else None
    return ChunkEntry(position, length, first, last, size, messages)
