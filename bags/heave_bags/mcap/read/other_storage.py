"""Bags of another storage: SQLite, the default of ROS 2 before Iron, and ROS 1. They are copied to MCAP, then read.

The copy lies in a temporary folder (`TMPDIR`) and goes with the bag that was opened. A bag of ROS 2 before Iron holds
no definitions: they are those of Humble, or the suite's own.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from heave_node.cdr.definitions import schema_text
from rosbags.convert.converter import convert
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from heave_bags.errors import BagError
from heave_bags.mcap.read.folder import OTHERS

SQLITE, ROS_1 = OTHERS

_SQLITE_MAGIC, _ROS_1_MAGIC = b"SQLite format 3\x00", b"#ROSBAG V2.0\n"
_METADATA_VERSION = 9


class Copied:
    """A bag as MCAP: its `path`, and `notes` on what was copied and what could not be. It lies in a `folder` that goes
    with this object.
    """

    def __init__(self, path: Path, notes: list[str], folder: tempfile.TemporaryDirectory[str]) -> None:
        self.path, self.notes, self._folder = path, notes, folder


def source_of(path: Path) -> Path | None:
    """Return what is to be copied of the bag at `path`, of another storage; None: it is MCAP, or no bag."""
    if path.is_file():
        return path if _begins(path) in (SQLITE, ROS_1) else None
    if not path.is_dir() or any(path.glob("*.mcap*")):
        return None
    found = sorted(file for file in path.iterdir() if file.is_file() and _begins(file) in (SQLITE, ROS_1))
    return found[0] if found else None


def copied(source: Path) -> Copied:
    """Return the copy of a `source`, as `source_of` gives it. Raises BagError, in one line, where it cannot be read."""
    folder = tempfile.TemporaryDirectory(prefix="heave_bag_")
    copy, store = Path(folder.name) / "bag", get_typestore(Stores.ROS2_HUMBLE)
    try:
        read = source if _is_ros_1(source) else source.parent  # where the `metadata.yaml` of SQLite lies
        with AnyReader([read], default_typestore=store) as reader:
            unknown = _unknown(reader, store)
        convert(
            srcs=[read],
            dst=copy,
            dst_storage="mcap",
            dst_version=_METADATA_VERSION,
            compress=None,
            compress_mode="none",
            default_typestore=store,
            typestore=store,
            exclude_topics=[],
            include_topics=[],
            exclude_msgtypes=sorted(unknown),
            include_msgtypes=[],
        )
    except Exception as error:  # whatever somebody else's file brings about
        folder.cleanup()
        words = " ".join(str(error).split()) or type(error).__name__
        repair = "rosbag reindex, of ROS 1" if _is_ros_1(source) else "ros2 bag reindex, of a full ROS 2"
        raise BagError(
            f"{source}: a bag of {_kind(source)} that cannot be read ({words}); "
            f"try: {repair}; or rosbags-convert --src BAG --dst FOLDER --dst-storage mcap"
        ) from error
    notes = [f"{source.name} is a bag of {_kind(source)}: it was copied to MCAP, then read"]
    if unknown:
        notes.append(f"{source.name} holds no definition of {', '.join(sorted(unknown))}: not read")
    return Copied(copy, notes, folder)


def _begins(file: Path) -> str:
    """Return the ending that files have that begin as this one; "": another one."""
    try:
        with file.open("rb") as opened:
            start = opened.read(len(_SQLITE_MAGIC))
    except OSError:
        return ""
    return SQLITE if start == _SQLITE_MAGIC else ROS_1 if start.startswith(_ROS_1_MAGIC) else ""


def _kind(source: Path) -> str:
    return "ROS 1" if _is_ros_1(source) else "storage sqlite3 (ROS 2 before Iron)"


def _is_ros_1(source: Path) -> bool:
    return source.is_file() and _begins(source) == ROS_1


def _unknown(reader: AnyReader, store: Any) -> set[str]:
    """Return the types in a bag of which nobody has a definition; those of the suite are put into the `store`."""
    unknown = set()
    for connection in reader.connections:
        name = connection.msgtype
        if name in reader.typestore.fielddefs:
            continue
        try:
            store.register(get_types_from_msg(schema_text(name), name))
        except Exception:
            unknown.add(name)
    return unknown
