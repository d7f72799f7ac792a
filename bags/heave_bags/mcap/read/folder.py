"""The MCAP files of a bag: which are there, which are missing, and which only seem to be.

A power cut leaves empty files and files of zeros beside sound ones, other systems leave files of their own: what is no
MCAP file is named, and costs the bag nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from heave_bags.errors import NoBagError
from heave_bags.mcap.files import METADATA_NAME, ListedFile
from heave_bags.mcap.loss import Loss
from heave_bags.mcap.read.scan import WANTED, why_not_read
from heave_bags.mcap.summary import MAGIC

ENDINGS = (".mcap", ".mcap.zstd", ".mcap.zst")
"""Endings of MCAP files; those that are compressed as a whole are named, not read."""
OTHERS = (".db3", ".bag")
"""Endings of files of another storage: SQLite and ROS 1."""
_LEFT_BY_OTHERS = "._"
"""Begins the name of a file in which macOS keeps what its own file system has beside a file."""


@dataclass
class BagFiles:
    """What is in a folder."""

    files: list[Path]  # MCAP files, by name
    losses: list[Loss] = field(default_factory=list)  # files that hold nothing of what they should
    notes: list[str] = field(default_factory=list)  # on files that do not belong to the bag


def is_bag(path: Path) -> bool:
    """Return whether the folder `path` holds a bag; a damaged one may have lost its index."""
    return (path / METADATA_NAME).is_file() or (
        path.is_dir() and any(file.name.endswith((*ENDINGS, *OTHERS)) for file in path.iterdir())
    )


BAG_IN_RUN = "bag"
"""Folder of the bag in the folder of a run."""


def bag_of(path: Path) -> Path:
    """Return the bag that `path` names: itself, or where it is the folder of a run, the bag in that."""
    inside = path / BAG_IN_RUN
    return inside if path.is_dir() and not is_bag(path) and is_bag(inside) else path


def find_files(path: Path, listed: Sequence[ListedFile]) -> BagFiles:
    """Return the files of the bag `path`, a folder or a file, whose description has `listed` some.

    Raises NoBagError if there is none.
    """
    if path.is_file():
        return BagFiles([path])
    if not path.is_dir():
        raise NoBagError(f"{path}: no such bag: no file or folder has this name")
    by_name = {part.name: part for part in listed}
    found = BagFiles([])
    for file in _candidates(path, set(by_name)):
        problem = _problem(file)
        if not problem:
            found.files.append(file)
        elif file.name.startswith(_LEFT_BY_OTHERS):
            found.notes.append(f"{file.name} is a file of macOS, no part of the bag: it is not read")
        else:
            part = by_name.get(file.name, ListedFile(file.name))
            found.losses.append(Loss(file, None, problem, part.start, part.end, part.messages))
    if not found.files:
        raise NoBagError(f"{path}: {_none(path, found)}")
    return found


def _candidates(folder: Path, listed: set[str]) -> list[Path]:
    """Return the files that are listed or have the ending of an MCAP file; if none has, those that begin like one."""
    files = sorted(file for file in folder.iterdir() if file.is_file())
    named = [file for file in files if file.name.endswith(ENDINGS) or file.name in listed]
    return named or [file for file in files if not file.suffix and not _problem(file)]


def _problem(file: Path) -> str:
    """Return why a file is not read as MCAP; "" if it is."""
    try:
        with file.open("rb") as stream:
            begins = stream.read(len(MAGIC))
    except OSError as error:
        return f"the file cannot be read ({error.strerror})"
    if not begins:
        return "the file is empty"
    return why_not_read(begins) if any(begins) else "the file holds zeros, no MCAP"


def _none(folder: Path, found: BagFiles) -> str:
    """Return why there is nothing to read in a folder, and what to do."""
    if found.losses:
        return f"nothing in it can be read: {found.losses[0].file.name}: {found.losses[0].reason}"
    packed = [file for file in sorted(folder.glob("*.mcap.*")) if file.is_file()]
    if packed:
        return f"{packed[0].name} is compressed or renamed; unpack it: unpacked files end with .mcap"
    kind = "storage other than MCAP" if list(folder.glob("*.db3")) else "no MCAP file"
    return f"this folder holds {kind}; {WANTED}"
