"""An FMU file, unpacked and described: a ZIP archive that somebody else made is held to bounds first."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from heave_bringup.errors import CommandError, ExitStatus
from heave_node.files.archive import files_in

LARGEST_FMU = 512 << 20
"""Bytes of all files of an FMU: one with its libraries for three systems has some ten million."""


class FmuRefusedError(CommandError):
    """The file is no FMU that can be used, or not what it should be; none of its code has run."""

    status = ExitStatus.REFUSED


def unpack_fmu(file: Path, folder: Path) -> None:
    """Unpack an FMU, the `file`, into a `folder`.

    Raises FmuRefusedError, in one line, where it is no archive, has a name that leads elsewhere, has a file twice, or
    is larger than LARGEST_FMU or has too many files.
    """
    try:
        for path, content in files_in(file, LARGEST_FMU):
            place = folder / path
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(content)
    except (OSError, ValueError) as error:
        raise FmuRefusedError(f"{file}: no FMU that can be used: {' '.join(str(error).split())}") from error


def described(file: Path, folder: Path) -> Any:
    """Return FMPy's description of an FMU, the `file`, that was unpacked into a `folder`.

    Raises FmuRefusedError, in one line, where it is not for co-simulation of FMI 2.0, or has no code for this system.
    """
    from fmpy import platform, read_model_description, sharedLibraryExtension  # noqa: PLC0415 - an extra

    try:
        found = read_model_description(str(folder), validate=False)
    except Exception as error:  # whatever somebody else's file brings about
        words = " ".join(str(error).split()) or type(error).__name__
        raise FmuRefusedError(f"{file}: no FMU that can be used: {words}") from error
    if found.fmiVersion != "2.0" or found.coSimulation is None:
        kind = str(found.fmiVersion) + ("" if found.coSimulation is not None else " without co-simulation")
        raise FmuRefusedError(f"{file}: must be an FMU for co-simulation of FMI 2.0; it is FMI {kind}")
    library = f"binaries/{platform}/{found.coSimulation.modelIdentifier}{sharedLibraryExtension}"
    if not (folder / library).is_file():
        raise FmuRefusedError(f"{file}: it has no code for this system, {library}")
    return found
