"""Bags of another storage: SQLite, the default of ROS 2 before Iron, and ROS 1. They are copied to MCAP, then read.

The copy lies in a temporary folder (`TMPDIR`) and goes with the bag that was opened. A bag of ROS 2 before Iron holds
no definitions: they are those of Humble, or the suite's own.
"""

from __future__ import annotations

import sqlite3
import tempfile
from contextlib import closing
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
    """A bag as MCAP.

    Parameters
    ----------
    path : of the bag, a folder or a file
    notes : what was copied, and what could not be
    folder : temporary, which goes with it
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
    if not found:
        return None
    return path if _begins(found[0]) == SQLITE and (path / "metadata.yaml").is_file() else found[0]


def copied(source: Path) -> Copied:
    """Return the copy of a `source`, as `source_of` gives it. Raises BagError, in one line, where it cannot be read."""
    folder = tempfile.TemporaryDirectory(prefix="heave_bag_")
    copy, store = Path(folder.name) / "bag", get_typestore(Stores.ROS2_HUMBLE)
    try:
        read = source if _is_ros_1(source) else _as_folder(source, Path(folder.name))
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
        raise BagError(
            f"{source}: a bag of {_kind(source)} that cannot be read ({words}); "
            "try: ros2 bag convert, or rosbags-convert --src BAG --dst FOLDER --dst-storage mcap"
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


def _as_folder(source: Path, place: Path) -> Path:
    """Return a folder with `metadata.yaml` that rosbags opens: `source`, or one for a single file of SQLite."""
    if source.is_dir():
        return source
    beside = source.parent / "metadata.yaml"
    folder = place / "source"
    folder.mkdir()
    (folder / source.name).symlink_to(source.resolve())
    if beside.is_file() and source.name in beside.read_text(errors="replace"):
        return source.parent
    (folder / "metadata.yaml").write_text(_metadata(source))
    return folder


def _metadata(source: Path) -> str:
    """Return what `metadata.yaml` says of a single file of SQLite."""
    with closing(sqlite3.connect(f"{source.resolve().as_uri()}?mode=ro", uri=True)) as base:
        topics = base.execute("SELECT id, name, type, serialization_format FROM topics").fetchall()
        counts = dict(base.execute("SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id").fetchall())
        first, last = base.execute("SELECT MIN(timestamp), MAX(timestamp) FROM messages").fetchone()
    first, last = first or 0, last or 0
    lines = [
        "rosbag2_bagfile_information:",
        "  version: 5",
        "  storage_identifier: sqlite3",
        "  relative_file_paths:",
        f"    - {source.name}",
        f"  duration: {{nanoseconds: {last - first}}}",
        f"  starting_time: {{nanoseconds_since_epoch: {first}}}",
        f"  message_count: {sum(counts.values())}",
        "  compression_format: ''",
        "  compression_mode: ''",
        "  topics_with_message_count:",
    ]
    for number, name, kind, form in topics:
        described = f"{{name: {name}, type: {kind}, serialization_format: {form}, offered_qos_profiles: ''}}"
        lines.append(f"    - {{topic_metadata: {described}, message_count: {counts.get(number, 0)}}}")
    return "\n".join([*lines, ""])
