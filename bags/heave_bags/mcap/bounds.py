"""Limits on what a file may demand, and unpacking of its chunks within them.

A sound bag comes nowhere near these bounds; a damaged or hostile one is held to them.
"""

from __future__ import annotations

import lz4.frame
import zstandard

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
