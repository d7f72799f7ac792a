"""An FMU file, unpacked: a ZIP archive that somebody else made is held to bounds first."""

from __future__ import annotations

from pathlib import Path

from heave_bringup.errors import CommandError
from heave_bringup.tables.archive import files_in

LARGEST_FMU = 512 << 20
"""Bytes of all files of an FMU: one with its libraries for three systems has some ten million."""


def unpack_fmu(file: Path, folder: Path) -> None:
    """Unpack an FMU, the `file`, into a `folder`.

    Raises CommandError, in one line, where it is no archive, has a name that leads elsewhere, has a file twice, or is
    larger than LARGEST_FMU or has too many files.
    """
    try:
        for path, content in files_in(file, LARGEST_FMU):
            place = folder / path
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(content)
    except (OSError, ValueError) as error:
        raise CommandError(f"{file}: no FMU that can be used: {' '.join(str(error).split())}") from error
