"""Which files are sound: whole by every length and checksum, indexed, with messages in the order of their log times.

`rosbags` trusts what a file says of itself: it unpacks what it is given, takes sizes and positions from the index, and
passes over chunks that the index does not explain. So a file is checked before, chunk by chunk within bounds.
"""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
from mcap.opcode import Opcode
from mcap.records import ChunkIndex
from mcap.summary import Summary
from numpy.typing import NDArray
from rosbags.rosbag2 import Reader

from heave_bags.mcap.bounds import LARGEST_RECORD, LATEST_TIME, ZSTD_MAGIC, is_packed, unpack
from heave_bags.mcap.read.scan import DAMAGED_CHUNK, MOST_IN_BLOCK
from heave_bags.mcap.records import HEAD, UNPARSEABLE, Record, RecordFile, split_chunk
from heave_bags.mcap.ros.qos import UNREADABLE, from_yaml
from heave_bags.mcap.summary import MAGIC, read_summary, stated_start

SUFFIX = ".mcap"
_BETWEEN_CHUNKS = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.METADATA, Opcode.ATTACHMENT)
_INDEX = struct.Struct("<HI")
_HEAD = np.dtype(
    [("opcode", "u1"), ("length", "<u8"), ("channel", "<u2"), ("sequence", "<u4"), ("time", "<u8"), ("sent", "<u8")]
)
"""Head of a message record, before its data."""


def is_sound(path: Path) -> bool:
    """Return whether the file at `path` can be read by its index as it stands, and gives all that it holds."""
    if path.suffix != SUFFIX or is_packed(path):
        return False
    with RecordFile(path) as file:
        try:
            summary = read_summary(file)
            return summary is not None and _Walk(file, summary).is_sound() and _opens(path, summary)
        except (*DAMAGED_CHUNK, *UNPARSEABLE, *UNREADABLE):
            return False


def _opens(path: Path, summary: Summary) -> bool:
    """Return whether rosbags opens a file: it asks for a profile, kinds of definitions and all of an offered QoS.

    Raises one of UNREADABLE for an offered QoS that is no plain YAML.
    """
    for channel in summary.channels.values():
        from_yaml(channel.metadata.get("offered_qos_profiles", ""))
    try:
        with Reader(path):
            return True
    except Exception:
        return False


class _Walk:
    """Follows the records of a `file` from front to back, and compares them with its `summary`."""

    def __init__(self, file: RecordFile, summary: Summary) -> None:
        self._file = file
        self._chunks = {index.chunk_start_offset: index for index in summary.chunk_indexes}
        self._summary = summary
        self._latest = 0
        self._count = 0

    def is_sound(self) -> bool:
        """Return whether the file is sound; raises errors of a damaged chunk or record where it is not."""
        header = self._file.record_at(len(MAGIC))
        if self._file.read(0, len(MAGIC)) != MAGIC or header is None or header.opcode != Opcode.HEADER:
            return False
        if len(self._chunks) != len(self._summary.chunk_indexes):
            return False
        position = header.end
        while (record := self._file.record_at(position)) is not None and record.opcode != Opcode.DATA_END:
            if record.end > self._file.size or record.length > 2 * LARGEST_RECORD:
                return False
            position = record.end
            if record.opcode == Opcode.CHUNK:
                index = self._chunks.pop(record.position)
                if not self._is_as_indexed(record, index):
                    return False
                position += index.message_index_length
            elif record.opcode not in _BETWEEN_CHUNKS:
                return False
        return record is not None and self._ends_well(record)

    def _ends_well(self, data_end: Record) -> bool:
        """Return whether every chunk, every message and every byte up to the summary is accounted for."""
        (checksum,) = struct.unpack("<I", self._file.body(data_end))
        statistics = self._summary.statistics
        return (
            not self._chunks
            and statistics is not None
            and statistics.message_count == self._count
            and stated_start(self._file) == data_end.end
            and (not checksum or checksum == self._file.checksum(data_end.position))
        )

    def _is_as_indexed(self, record: Record, index: ChunkIndex) -> bool:
        """Return whether a chunk holds what its `index` and its message indexes say, in the order of log times."""
        _, _, size, checksum, compression, packed = split_chunk(self._file.body(record))
        about = (record.end - record.position, compression, len(packed), size)
        if about != (index.chunk_length, index.compression, index.compressed_size, index.uncompressed_size):
            return False
        records = unpack(compression, packed, size)
        if checksum and zlib.crc32(records) != checksum:
            return False
        channels, times, offsets = self._entries(record.end, index)
        if not times.size:
            return _are_definitions(records)
        is_ascending = self._latest <= times[0] and bool((times[1:] >= times[:-1]).all())
        self._latest = int(times[-1])
        self._count += times.size
        return (
            is_ascending
            and (int(times[0]), self._latest) == (index.message_start_time, index.message_end_time)
            and self._latest <= LATEST_TIME
            and times.size <= MOST_IN_BLOCK
            and _are_messages(records, channels, times, offsets)
        )

    def _entries(self, position: int, index: ChunkIndex) -> tuple[NDArray[np.uint64], ...]:
        """Return channel, log time [ns] and offset of each message of a chunk, by offset.

        Raises ValueError where the message indexes are not those that the `index` of the chunk names.
        """
        data = self._file.read(position, index.message_index_length)
        parts, found, at = [np.empty((0, 2), np.uint64)], {}, 0
        while at < len(data):
            opcode, length = HEAD.unpack_from(data, at)
            channel, size = _INDEX.unpack_from(data, at + HEAD.size)
            if opcode != Opcode.MESSAGE_INDEX or length != _INDEX.size + size or channel not in self._summary.channels:
                raise ValueError("a false message index")
            found[channel] = position + at
            pairs = np.frombuffer(data, "<u8", size // 8, at + HEAD.size + _INDEX.size).reshape(-1, 2)
            parts.append(pairs)
            at += HEAD.size + length
        if found != index.message_index_offsets:
            raise ValueError("a false chunk index")
        channels = np.repeat(np.array([0, *found], np.uint64), [len(part) for part in parts])
        times, offsets = np.concatenate(parts).T
        order = np.argsort(offsets)
        return channels[order], times[order], offsets[order]


def _are_messages(
    records: bytes, channels: NDArray[np.uint64], times: NDArray[np.uint64], offsets: NDArray[np.uint64]
) -> bool:
    """Return whether plain `records` are the messages of an index, by offset, with definitions between them."""
    raw, starts = np.frombuffer(records, np.uint8), offsets.astype(np.int64)
    if starts[0] < 0 or starts[-1] + _HEAD.itemsize > raw.size:
        return False
    heads = raw[starts[:, None] + np.arange(_HEAD.itemsize)].reshape(-1).view(_HEAD)
    lengths = heads["length"].astype(np.int64)
    if not (heads["opcode"] == Opcode.MESSAGE).all() or (lengths < _HEAD.itemsize - HEAD.size).any():
        return False
    if (heads["time"] != times).any() or (heads["channel"] != channels).any():
        return False
    begins = np.append(starts, raw.size)
    ends = np.append(0, starts + HEAD.size + lengths)
    are_separate = bool((ends <= begins).all())
    gaps = zip(ends[ends < begins].tolist(), begins[ends < begins].tolist(), strict=True)
    is_packed_singly = ZSTD_MAGIC in records and any(
        records.startswith(ZSTD_MAGIC, start + _HEAD.itemsize) for start in starts.tolist()
    )
    return are_separate and not is_packed_singly and all(_are_definitions(records[a:b]) for a, b in gaps)


def _are_definitions(records: bytes) -> bool:
    """Return whether plain `records` are schemas and channels alone, whole."""
    at = 0
    while at < len(records):
        opcode, length = HEAD.unpack_from(records, at)
        if opcode not in (Opcode.SCHEMA, Opcode.CHANNEL):
            return False
        at += HEAD.size + length
    return at == len(records)
