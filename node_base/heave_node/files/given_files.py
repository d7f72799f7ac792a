"""Text files that a user, or a file of somebody else, names: read as far as memory allows, and only where they end."""

from __future__ import annotations

import gzip
import zlib
from pathlib import Path

LARGEST_TEXT = 128 << 20
"""Bytes of a text file, unpacked: a day of motion at 20 Hz is half of it."""


def read_given(path: Path, *, encoding: str = "utf-8") -> str:
    """Return the text of the file at a `path`; of one that ends on .gz, unpacked.

    Parameters
    ----------
    path : of the file
    encoding : of the text; another one is refused

    Raises OSError where it cannot be read, and ValueError where it is no file (a pipe or a device may never end), or
    larger than LARGEST_TEXT, or not text.
    """
    if path.exists() and not path.is_file():
        raise ValueError("is not a file")
    try:
        with gzip.open(path) if path.suffix == ".gz" else path.open("rb") as stream:
            content = stream.read(LARGEST_TEXT + 1)
    except (EOFError, zlib.error) as error:
        raise ValueError(f"cannot be read to its end: {error}") from error
    if len(content) > LARGEST_TEXT:
        raise ValueError(f"is larger than {LARGEST_TEXT >> 20} MB")
    try:
        return content.decode(encoding)
    except UnicodeDecodeError as error:
        raise ValueError(f"is not a text file: byte {error.start} is not {encoding.upper()}") from error
