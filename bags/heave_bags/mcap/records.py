"""The records of an MCAP file by position: which bytes are a record, and where the next one begins after damage.

A record is accepted only if its length agrees with the lengths of its parts, since one flipped bit in a length would
otherwise skip sound records without a word.
"""

from __future__ import annotations

import os
import re
import struct
import zlib
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, AttachmentIndex, Channel, McapRecord, Metadata, MetadataIndex, Schema, Statistics

from heave_bags.errors import BagError
from heave_bags.mcap.bounds import LARGEST_RECORD

HEAD = struct.Struct("<BQ")
MESSAGE_HEAD = struct.Struct("<HIQQ")
CHUNK_HEAD = struct.Struct("<QQQI")
"""First log time, last log time, unpacked size, checksum."""
_LENGTH = struct.Struct("<I")
_LONG_LENGTH = struct.Struct("<Q")

_LONGEST_NAME = 1 << 16
_READ_AT_ONCE = 1 << 20
_SEARCH_BLOCK = 1 << 20
_LONGEST_CHUNK_HEAD = HEAD.size + CHUNK_HEAD.size + 16
_CHUNK = re.compile(rb"\x06(?=.{36}(?:\x04\0\0\0zstd|\x03\0\0\0lz4|\0\0\0\0))", re.DOTALL)
_PRIVATE = 0x80
"""Opcodes from here on belong to applications, and readers pass over them."""

UNPARSEABLE = (McapError, struct.error, UnicodeDecodeError)
"""Errors that reading the parts of a damaged record raises."""

_READERS: dict[int, Callable[[ReadDataStream], McapRecord]] = {
    Opcode.SCHEMA: Schema.read,
    Opcode.CHANNEL: Channel.read,
    Opcode.METADATA: Metadata.read,
    Opcode.ATTACHMENT: Attachment.read,
    Opcode.STATISTICS: Statistics.read,
    Opcode.ATTACHMENT_INDEX: AttachmentIndex.read,
    Opcode.METADATA_INDEX: MetadataIndex.read,
}

_PARTS: dict[int, tuple[int, str] | tuple[int, str, int]] = {
    Opcode.HEADER: (0, "ss"),
    Opcode.SCHEMA: (2, "ssb"),
    Opcode.CHANNEL: (4, "ssb"),
    Opcode.CHUNK: (CHUNK_HEAD.size, "sB"),
    Opcode.MESSAGE_INDEX: (2, "b"),
    Opcode.ATTACHMENT: (16, "ssB", 4),
    Opcode.METADATA: (0, "sb"),
    Opcode.DATA_END: (4, ""),
}
"""Body of each record: a number of bytes, then names (s), bytes (b) and bytes with a long length (B),
then a number of bytes again.
"""


def parse(opcode: int, body: bytes) -> McapRecord | None:
    """Return the record of kind `opcode` with a `body`; None for kinds that are not parsed here.

    Raises one of UNPARSEABLE.
    """
    read = _READERS.get(opcode)
    return None if read is None else read(ReadDataStream(BytesIO(body)))


class Record(NamedTuple):
    """Where a record is: its opcode, the position of its head, and the length of its body [bytes]."""

    opcode: int
    position: int
    length: int

    @property
    def body(self) -> int:
        """Position of the body."""
        return self.position + HEAD.size

    @property
    def end(self) -> int:
        """Position after the record."""
        return self.body + self.length


class RecordFile:
    """The MCAP file `path` to be read by position; to be used as a context.

    Raises BagError if it cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self._file = os.open(path, os.O_RDONLY)
            self.size = os.fstat(self._file).st_size
        except OSError as error:
            raise BagError(f"{path}: cannot be read: {error.strerror}") from error

    def __enter__(self) -> RecordFile:
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self._file)

    def read(self, position: int, count: int) -> bytes:
        """Return up to `count` bytes from `position` on."""
        left = max(0, min(count, self.size - position))
        try:
            return os.pread(self._file, left, position) if left else b""
        except OSError as error:
            raise BagError(f"{self.path}: cannot be read: {error.strerror}") from error

    def body(self, record: Record) -> bytes:
        """Return the body of a record."""
        return self.read(record.body, record.length)

    def record_at(self, position: int) -> Record | None:
        """Return the record that begins at `position`, whole or cut off by the end of the file; None if none does."""
        stated = self._stated(position)
        true_length = None if stated is None else self._length_by_parts(stated)
        if stated is None or true_length is None:
            return None
        if true_length == stated.length:
            return stated
        repaired = stated._replace(length=true_length)  # a damaged length shows by what follows the true one
        return repaired if repaired.end < self.size and self._begins_record(repaired.end) else None

    def record_of_stated_length(self, position: int) -> Record | None:
        """Return a record at `position` whose parts are damaged, if its length leads to another record; None if not."""
        record = self._stated(position)
        is_followed = record is not None and record.end < self.size and self._begins_record(record.end)
        return record if is_followed else None

    def _stated(self, position: int) -> Record | None:
        """Return what the bytes at `position` say as the head of a record; None where the file ends."""
        head = self.read(position, HEAD.size)
        if len(head) < HEAD.size:
            return None
        opcode, length = HEAD.unpack(head)
        return Record(opcode, position, length)

    def _begins_record(self, position: int) -> bool:
        record = self._stated(position)
        return record is not None and self._length_by_parts(record) == record.length

    def _length_by_parts(self, record: Record) -> int | None:
        """Return the length of a body as its parts add up to it; None where they do not make sense."""
        if record.opcode in _PARTS:
            return self._sum(record.body, *_PARTS[record.opcode])
        if record.opcode == Opcode.MESSAGE:
            return record.length if MESSAGE_HEAD.size <= record.length <= LARGEST_RECORD else None
        if record.opcode >= _PRIVATE and record.end < self.size and self._begins_record(record.end):
            return record.length
        return None

    def _sum(self, start: int, size: int, parts: str, rest: int = 0) -> int | None:
        """Return the length of a body of `size` bytes, the parts after them, and `rest` bytes."""
        position = start + size
        for part in parts:
            form = _LONG_LENGTH if part == "B" else _LENGTH
            data = self.read(position, form.size)
            if len(data) < form.size:
                return None
            (length,) = form.unpack(data)
            if length > (_LONGEST_NAME if part == "s" else self.size):
                return None
            position += form.size + length
        return position + rest - start

    def messages_from(self, record: Record) -> bytes:
        """Return a message outside of chunks, `record`, with those that follow it without anything between them."""
        data = self.read(record.position, max(record.end - record.position, _READ_AT_ONCE))
        end = record.end - record.position
        while end + HEAD.size <= len(data):
            opcode, length = HEAD.unpack_from(data, end)
            following = end + HEAD.size + length
            if opcode != Opcode.MESSAGE or length < MESSAGE_HEAD.size or following > len(data):
                break
            end = following
        return data[:end]

    def checksum(self, end: int) -> int:
        """Return the checksum of the file up to byte `end`."""
        checksum = 0
        for position in range(0, end, _READ_AT_ONCE):
            checksum = zlib.crc32(self.read(position, min(_READ_AT_ONCE, end - position)), checksum)
        return checksum

    def next_chunk(self, position: int) -> int | None:
        """Return where the next chunk begins, from `position` on; None if there is none."""
        while position < self.size:
            block = self.read(position, _SEARCH_BLOCK + _LONGEST_CHUNK_HEAD)
            for match in _CHUNK.finditer(block, 0, _SEARCH_BLOCK + _LONGEST_CHUNK_HEAD):
                start = position + match.start()
                record = self.record_at(start)
                if record is not None and record.end <= self.size:
                    return start
            position += _SEARCH_BLOCK
        return None


def split_chunk(body: bytes) -> tuple[int, int, int, int, str, memoryview]:
    """Return first and last log time, unpacked size, checksum, compression and packed records of a chunk's `body`.

    The last may be cut off. Raises struct.error or ValueError where the head is damaged.
    """
    start, end, size, checksum = CHUNK_HEAD.unpack_from(body)
    (length,) = _LENGTH.unpack_from(body, CHUNK_HEAD.size)
    name_at = CHUNK_HEAD.size + _LENGTH.size
    if length > len(body):
        raise ValueError("the name of its compression is truncated")
    name = body[name_at : name_at + length].decode("ascii")
    return start, end, size, checksum, name, memoryview(body)[name_at + length + _LONG_LENGTH.size :]
