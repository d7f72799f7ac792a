"""A ZIP archive that somebody else made is held to its word."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import BinaryIO

MOST_MEMBERS = 1000
"""Files of an archive: a bag has one for each split."""

LONGEST_NAME = 255
"""Bytes of a name: what file systems take."""


def files_in(file: Path | BinaryIO, room: int) -> Iterator[tuple[PurePosixPath, bytes]]:
    """Yield path and content of each file in an archive, one after the other; before the first one all are checked.

    Parameters
    ----------
    file : the archive
    room : for its contents together [bytes]; no more is ever unpacked

    Raises ValueError, in words, where it is no archive, holds more, has a name that leads elsewhere or one twice.
    """
    try:
        with zipfile.ZipFile(file) as archive:
            members = [member for member in archive.infolist() if not member.is_dir()]
            if len(members) > MOST_MEMBERS or sum(member.file_size for member in members) > room:
                raise ValueError(f"it holds more than {MOST_MEMBERS} files or {room} bytes")
            paths = {_checked_path(member.filename): member for member in members}
            if len(paths) != len(members):
                raise ValueError("it holds a file twice")
            if any(folder in paths for path in paths for folder in path.parents):
                raise ValueError("it holds a file that is a folder, too")
            for path, member in paths.items():
                yield path, archive.read(member)  # no more bytes than the archive says: else it is broken
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, OSError) as error:
        raise ValueError(" ".join(str(error).split())) from error


def _checked_path(member: str) -> PurePosixPath:
    parts = member.split("/")
    if not all(map(is_plain_name, parts)):
        raise ValueError(f"it holds {member[:80]!r}, which is no name of a file in it")
    return PurePosixPath(*parts)


def is_plain_name(name: object) -> bool:
    """Return whether `name` is that of a file in its folder: no path, nothing that is not printed."""
    if not isinstance(name, str) or name in ("", ".", ".."):
        return False
    return name.isprintable() and not set(name) & set("/\\:") and len(name.encode(errors="replace")) <= LONGEST_NAME
