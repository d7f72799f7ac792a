"""Limits on what a file may demand. A sound bag comes nowhere near these bounds; a damaged or hostile one is held to
them.
"""

from __future__ import annotations

from typing import Any

import lz4.frame
import yaml
import zstandard

LARGEST_RECORD = 64 << 20
"""Bytes of one record, packed and unpacked: a chunk, an attachment, a message."""
LARGEST_MESSAGE = 62 << 20
"""Bytes of one message, so that its chunk stays within LARGEST_RECORD with the definitions it needs."""
LARGEST_SUMMARY = 64 << 20
"""Bytes of a file's summary: that of days of recording without a split."""
LARGEST_YAML = 8 << 20
"""Characters of a YAML text."""
DEEPEST_YAML = 32
"""Mappings and sequences within each other in a YAML text."""
LATEST_TIME = (1 << 63) - 1
"""Times beyond this are not times [ns]: the year 2262."""


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
        records = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1)
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
    return zstandard.ZstdDecompressor().decompress(data, max_output_size=size) if size else b""


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


_YAML_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_NO_YAML = (yaml.YAMLError, ArithmeticError, LookupError, TypeError, AttributeError)


def load_yaml(text: str | bytes) -> Any:
    """Return the value of a YAML text that a file carries: plain values of bounded depth.

    Raises ValueError if it is none, exceeds the bounds, or uses aliases, with which a short text expands to a huge one.
    """
    check_yaml(text)
    try:
        return yaml.load(text, Loader=_YAML_LOADER)
    except _NO_YAML as error:
        raise _no_yaml(error) from error


def check_yaml(text: str | bytes) -> None:
    """Hold a YAML `text` to the bounds, and make nothing of it; raises ValueError as `load_yaml` does."""
    if len(text) > LARGEST_YAML:
        raise BoundError(f"it has {len(text)} characters, {LARGEST_YAML} are allowed")
    try:
        _check_depth(text)
    except _NO_YAML as error:
        raise _no_yaml(error) from error


def _no_yaml(error: Exception) -> ValueError:
    return ValueError(f"it is not valid YAML: {' '.join(str(error).split())}")


def _check_depth(text: str | bytes) -> None:
    depth = 0
    for event in yaml.parse(text, Loader=_YAML_LOADER):
        if isinstance(event, yaml.AliasEvent):
            raise BoundError("it uses aliases")
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        if depth > DEEPEST_YAML:
            raise BoundError(f"it is more than {DEEPEST_YAML} levels deep")
