"""Limits on what a file may demand, and unpacking within them: chunks, and files and messages that a recorder packs.

A sound bag comes nowhere near these bounds; a damaged or hostile one is held to them. A compressed file is unpacked
once into a temporary file without a name, since a bag is read by position.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from functools import lru_cache
from pathlib import Path
from typing import IO

import lz4.frame
import zstandard

from heave_bags.errors import BagError

LARGEST_RECORD = 64 << 20
"""Bytes of one record, packed and unpacked: a chunk, an attachment, a message."""
LARGEST_MESSAGE = 62 << 20
"""Bytes of one message, so that its chunk stays within LARGEST_RECORD with the definitions it needs."""
LARGEST_SUMMARY = 64 << 20
"""Bytes of a file's summary: that of days of recording without a split."""
LATEST_TIME = (1 << 63) - 1
"""Times beyond this are not times [ns]: the year 2262."""

ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
"""Begins what zstd has compressed. No serialised message begins so: the first byte of its encapsulation is 0."""
SUFFIX = ".zstd"
"""Suffix that rosbag2 appends to the name of a file that it compresses."""
_MOST_UNPACKED = 1000
"""A file may unpack to so many times its size; sound bags come to a tenth."""
_ALWAYS_ALLOWED = 64 << 20
_KEPT_FILES = 16
_BLOCK = 1 << 20


class BoundError(ValueError):
    """A file demands more than it may."""


def unpack(compression: str, data: bytes | memoryview, size: int) -> bytes:
    """Unpack the records of a chunk whose head promises `size` bytes.

    Raises BoundError if there are more, ValueError for an unknown compression or fewer bytes, and what zstandard and
    lz4 raise for damaged data.
    """
    if size > LARGEST_RECORD:
        raise BoundError(f"it demands {size} bytes, {LARGEST_RECORD} are allowed")
    if compression == "zstd":
        records = _unpack_zstd(data, size)
    elif compression == "lz4":
        frame = lz4.frame.LZ4FrameDecompressor()
        records = frame.decompress(data, max_length=size + 1)
        if frame.unused_data:
            raise BoundError("bytes follow what it says it holds")
    elif compression:
        raise ValueError(f"unknown compression {compression!r}")
    else:
        records = bytes(data)
    if len(records) != size:
        raise ValueError(f"it holds {'more' if len(records) > size else 'fewer'} bytes than its header says")
    return records


def _unpack_zstd(data: bytes | memoryview, size: int) -> bytes:
    stated = zstandard.frame_content_size(data)
    if stated not in (-1, size):  # -1: the frame does not say
        raise BoundError("its size differs from that in its header")
    return zstandard.ZstdDecompressor().decompress(data, max_output_size=size, allow_extra_data=False) if size else b""


def unpack_part(compression: str, data: bytes | memoryview) -> bytes:
    """Unpack the beginning `data` of a chunk that is cut off, as far as it goes, by its `compression`."""
    try:
        if compression == "zstd":
            reader = zstandard.ZstdDecompressor(max_window_size=LARGEST_RECORD).stream_reader(data)
            return _read_while_it_goes(reader)
        if compression == "lz4":
            part: bytes = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=LARGEST_RECORD)
            return part
    except (zstandard.ZstdError, RuntimeError):
        return b""
    return b"" if compression else bytes(data)


def _read_while_it_goes(reader: zstandard.ZstdDecompressionReader) -> bytes:
    parts: list[bytes] = []
    left = LARGEST_RECORD
    try:
        while left > 0 and (part := reader.read(min(left, 1 << 20))):
            parts.append(part)
            left -= len(part)
    except zstandard.ZstdError:
        pass  # what came before the damage is kept
    return b"".join(parts)


def is_packed(path: Path) -> bool:
    """Return whether the file `path` is compressed as a whole. Raises OSError if it cannot be read."""
    with path.open("rb") as stream:
        return stream.read(len(ZSTD_MAGIC)) == ZSTD_MAGIC


def first_bytes(path: Path, count: int) -> bytes:
    """Return the first `count` bytes of the file at `path`, unpacked. Raises OSError if it cannot be read."""
    with path.open("rb") as stream:
        begins = stream.read(count)
        if not begins.startswith(ZSTD_MAGIC):
            return begins
        stream.seek(0)
        try:
            return zstandard.ZstdDecompressor(max_window_size=LARGEST_RECORD).stream_reader(stream).read(count)
        except zstandard.ZstdError:
            return b""


def open_unpacked(path: Path) -> int:
    """Return a descriptor of the file `path`, unpacked if it is compressed, to be read by position and closed.

    Raises OSError if the file cannot be read, BagError if it cannot be unpacked.
    """
    if not is_packed(path):
        return os.open(path, os.O_RDONLY)
    state = path.stat()
    return os.dup(_unpacked(path.resolve(), state.st_size, state.st_mtime_ns).fileno())


@lru_cache(maxsize=_KEPT_FILES)
def _unpacked(path: Path, size: int, _changed: int) -> IO[bytes]:
    """Return a temporary file with the content of `path`, as far as it can be unpacked."""
    unpacked = tempfile.TemporaryFile()  # noqa: SIM115 - it lives as long as the cache holds it
    left = max(_MOST_UNPACKED * size, _ALWAYS_ALLOWED)
    try:
        with path.open("rb") as packed:
            decompressor = zstandard.ZstdDecompressor(max_window_size=LARGEST_RECORD)
            reader = decompressor.stream_reader(packed, read_across_frames=True)
            while block := _read(reader):
                left -= len(block)
                if left < 0:
                    raise BagError(f"{path}: it unpacks to more than {_MOST_UNPACKED} times its size")
                unpacked.write(block)
        unpacked.flush()
    except OSError as error:
        folder, free = tempfile.gettempdir(), shutil.disk_usage(tempfile.gettempdir()).free
        reason = f"cannot be unpacked into {folder} ({free / 1e9:.1f} GB free): {error.strerror}"
        raise BagError(f"{path}: {reason}; set TMPDIR to a folder with more room") from error
    return unpacked


def _read(reader: zstandard.ZstdDecompressionReader) -> bytes:
    try:
        return reader.read(_BLOCK)
    except zstandard.ZstdError:  # cut off or damaged: what came before is kept, and the rest is missed by its reader
        return b""


def unpack_message(data: bytes) -> bytes | None:
    """Return the message in `data`, compressed by itself; None if it is damaged or larger than a record may be."""
    try:
        size = zstandard.frame_content_size(data)
        if size > LARGEST_RECORD:
            return None
        return unpack("zstd", data, size) if size >= 0 else unpack_part("zstd", data)
    except (zstandard.ZstdError, ValueError, MemoryError):
        return None
