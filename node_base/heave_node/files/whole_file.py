"""A file of which no half is ever seen: written beside its place, and put there once it is whole."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give the place to write what is to be the file at `path`; it takes that place at the end, or leaves nothing.

    Raises OSError where it cannot be written.
    """
    unfinished = path.with_name(f".{path.name}.writing")
    try:
        yield unfinished
        unfinished.replace(path)
    except BaseException:
        unfinished.unlink(missing_ok=True)
        raise
