"""An FMU file, unpacked: a ZIP archive that somebody else made is held to bounds first."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path

from heave_bringup.errors import CommandError
from heave_bringup.tables.archive import MOST_MEMBERS, is_plain_name

LARGEST_FMU = 512 << 20
"""Bytes of all files of an FMU: one with its libraries for three systems has some ten million."""


def unpack_fmu(file: Path, folder: Path) -> None:
    """Unpack an FMU, the `file`, into a `folder`.

    Raises CommandError, in one line, where it is no archive, has a name that leads elsewhere, has a file twice, or is
    larger than LARGEST_FMU or MOST_MEMBERS files.
    """
    try:
        with zipfile.ZipFile(file) as archive:
            members = [member for member in archive.infolist() if not member.is_dir()]
            names = {_checked(member.filename) for member in members}
            if len(members) > MOST_MEMBERS or sum(member.file_size for member in members) > LARGEST_FMU:
                raise ValueError(f"it holds more than {MOST_MEMBERS} files or {LARGEST_FMU >> 20} MiB")
            if len(names) != len(members):
                raise ValueError("it holds a file twice")
            for member in members:
                place = folder / member.filename
                place.parent.mkdir(parents=True, exist_ok=True)
                place.write_bytes(archive.read(member))  # no more bytes than the archive says: else it is broken
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, OSError, ValueError) as error:
        raise CommandError(f"{file}: no FMU that can be used: {' '.join(str(error).split())}") from error


def _checked(name: str) -> str:
    if not all(map(is_plain_name, name.split("/"))):
        raise ValueError(f"it holds {name[:80]!r}, which is no name of a file in it")
    return name
