"""Files that a user, or a file of somebody else, names: read as far as memory allows, and only where they end."""

from __future__ import annotations

import gzip
import zlib
from pathlib import Path

LARGEST_FILE = 128 << 20
"""Bytes of a file, unpacked: a day of motion at 20 Hz is half of it."""
_GZIP = b"\x1f\x8b"


def read_given(path: Path) -> bytes:
    """Return the content of the file at a `path`; of one that gzip has compressed, whatever its name, unpacked.

    Raises OSError where it cannot be read, and ValueError where it is no file (a pipe or a device may never end),
    larger than LARGEST_FILE, or damaged.
    """
    if path.exists() and not path.is_file():
        raise ValueError("is not a file")
    with path.open("rb") as stream:
        is_packed = stream.read(len(_GZIP)) == _GZIP
        stream.seek(0)
        try:
            content = (gzip.GzipFile(fileobj=stream) if is_packed else stream).read(LARGEST_FILE + 1)
        except (EOFError, zlib.error, gzip.BadGzipFile) as error:
            raise ValueError(f"cannot be read to its end: {error}") from error
    if len(content) > LARGEST_FILE:
        raise ValueError(f"is larger than {LARGEST_FILE >> 20} MB")
    return content
