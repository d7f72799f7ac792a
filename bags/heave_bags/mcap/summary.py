"""The summary at the end of an MCAP file: definitions, counts, and where attachments and metadata are."""

from __future__ import annotations

import struct
import zlib

from mcap.opcode import Opcode
from mcap.records import AttachmentIndex, Channel, MetadataIndex, Schema, Statistics
from mcap.summary import Summary

from heave_bags.mcap.bounds import LARGEST_SUMMARY
from heave_bags.mcap.records import HEAD, UNPARSEABLE, RecordFile, parse

MAGIC = b"\x89MCAP0\r\n"
_FOOTER = struct.Struct("<BQQQI")
"""Opcode, length, start of the summary, start of its offsets, checksum of everything from there to here."""
_FOOTER_LENGTH = 20
_ENDING = _FOOTER.size + len(MAGIC)
_DATA_END_HEAD = HEAD.pack(Opcode.DATA_END, 4)
DATA_END_SIZE = HEAD.size + 4


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
    has_footer = opcode == Opcode.FOOTER and length == _FOOTER_LENGTH
    found = _read_from(file, start) if has_footer and start else None
    if found is not None or (has_footer and start == 0):
        return found
    tail_start = max(0, file.size - LARGEST_SUMMARY)
    behind_data = file.read(tail_start, LARGEST_SUMMARY).rfind(_DATA_END_HEAD)
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
    summary = Summary()
    offset, end = 0, size - _FOOTER.size
    try:
        while offset < end:
            opcode, length = HEAD.unpack_from(data, offset)
            offset += HEAD.size + length
            if offset > end:
                return None
            _take(summary, parse(opcode, data[offset - length : offset]))
    except UNPARSEABLE:
        return None
    return summary


def _take(summary: Summary, record: object) -> None:
    if isinstance(record, Schema):
        summary.schemas[record.id] = record
    elif isinstance(record, Channel):
        summary.channels[record.id] = record
    elif isinstance(record, Statistics):
        summary.statistics = record
    elif isinstance(record, AttachmentIndex):
        summary.attachment_indexes.append(record)
    elif isinstance(record, MetadataIndex):
        summary.metadata_indexes.append(record)
