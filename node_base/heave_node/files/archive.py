"""A file, or a folder of files, as a ZIP archive in memory; an archive that somebody else made is held to its word."""

from __future__ import annotations

import hashlib
import io
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePath, PurePosixPath
from typing import BinaryIO

MOST_MEMBERS = 1000
"""Files of an archive: a bag has one for each split."""

LONGEST_NAME = 255
"""Bytes of a name: what file systems take."""

_EPOCH = (1980, 1, 1, 0, 0, 0)
"""Time of every packed file: equal contents give equal bytes."""


def pack(contents: Mapping[PurePath, bytes]) -> bytes:
    """Return `contents`, by path, as an archive; equal contents give equal bytes."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for path, content in contents.items():
            archive.writestr(zipfile.ZipInfo(path.as_posix(), _EPOCH), content, zipfile.ZIP_DEFLATED)
    return buffer.getvalue()


def unpack(packed: bytes, name: str, size: int) -> dict[PurePosixPath, bytes]:
    """Return the contents of an archive, by path.

    Parameters
    ----------
    packed : the archive
    name : of the one file or folder in it
    size : of its contents together [bytes]; no more is ever unpacked

    Raises ValueError, in words, where the archive holds anything else, or anything twice.
    """
    contents = dict(files_in(io.BytesIO(packed), size))
    if sum(map(len, contents.values())) != size:
        raise ValueError(f"it does not hold the {size} bytes that it should")
    for path in contents:
        if path.parts[0] != name:
            raise ValueError(f"it holds {str(path)[:80]!r}, which is no part of {name}")
    return contents


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


def digest_in(contents: Mapping[PurePosixPath, bytes], name: str) -> str:
    """Return the SHA-256 of a file in `contents`; of a folder that of the lines that `sha256sum` has of its files.

    Parameters
    ----------
    contents : by path
    name : of the file or folder
    """
    digests = {path: hashlib.sha256(content).hexdigest() for path, content in sorted(contents.items())}
    own = PurePosixPath(name)
    if own in digests:
        return digests[own]
    lines = "".join(f"{digest}  {path.relative_to(own).as_posix()}\n" for path, digest in digests.items())
    return hashlib.sha256(lines.encode()).hexdigest()
