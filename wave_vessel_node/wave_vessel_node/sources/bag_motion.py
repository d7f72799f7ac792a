"""Samples of motion from a bag (MCAP), by the messages of this suite.

What can be read of a bag is read and the rest is named: a power cut leaves empty files, files of zeros and files
without an end beside sound ones. `heave repair` gets more out of a damaged file.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import IO

import zstandard
from heave_node.files.bounded_yaml import YamlError, parse_yaml
from heave_node.interface.codes import MruStatus
from heave_node.interface.messages import MessageReader
from mcap.exceptions import McapError
from mcap.reader import McapReader, NonSeekingReader, make_reader
from mcap.records import Channel, Message, Schema

Sample = tuple[float, float, float, float]
"""Stamp [s] and x, y, z [m]."""

TOPICS = ("boom_tip", "mru")
"""What is read of a bag: the last part of the topic's name, the first of these that has samples."""

_DAMAGE = (McapError, struct.error, zstandard.ZstdError, RuntimeError, ValueError, EOFError, OSError, MemoryError)
"""Errors that the readers of MCAP and of its compressions raise for a file that is cut off or damaged."""
_ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"


class BagMotionError(ValueError):
    """A bag that holds no motion that can be used; the message is one line."""


def bag_samples(path: Path) -> tuple[list[Sample], list[str]]:
    """Return the samples of a bag, in the order of its files, and what could not be read of it, one line each.

    `path` is a file, or a folder with MCAP files. Raises BagMotionError if nothing is there, or it is of another type,
    or packed.
    """
    for topic in TOPICS:
        samples, lost, found = _samples_of(path, topic)
        if samples:
            return samples, lost
    wanted = " or ".join(TOPICS)
    if lost:
        raise BagMotionError(f"{path}: no sample of {wanted} can be read: {lost[0]}")
    raise BagMotionError(f"{path}: there is no topic {wanted}; found {', '.join(sorted(found)) or 'none'}")


def _samples_of(path: Path, topic: str) -> tuple[list[Sample], list[str], set[str]]:
    """Return the samples of a `topic` in a bag, what could not be read, and the names of all topics found."""
    samples: list[Sample] = []
    lost = _missing(path) if path.is_dir() else []
    found: set[str] = set()
    for file in _files(path):
        before = len(samples)
        try:
            with file.open("rb") as stream:
                for schema, channel, message in _messages(stream):
                    found.add(channel.topic)
                    if channel.topic.rsplit("/", 1)[-1] == topic:
                        samples.append(_sample(path, schema, channel, message.data))
        except BagMotionError:
            raise
        except _DAMAGE as error:
            lost.append(_damage(file, error, len(samples) - before))
    return samples, lost, found


def _files(path: Path) -> list[Path]:
    """Return the files of a bag. Raises BagMotionError where there is none."""
    if not path.is_dir():
        return [path]
    files = sorted(file for file in path.glob("*.mcap") if not file.name.startswith("._"))  # macOS leaves such
    if files:
        return files
    packed = sorted(file.name for file in path.glob("*.mcap.z*"))
    if packed:
        raise BagMotionError(f"{path}: {packed[0]} is compressed; unpack it: zstd -d {packed[0]}")
    raise BagMotionError(f"{path}: the folder has no .mcap file")


def _missing(folder: Path) -> list[str]:
    """Return the files that the description of a bag lists and that are not there, a line each."""
    try:
        described = parse_yaml((folder / "metadata.yaml").read_text(encoding="utf-8"))
        listed = described["rosbag2_bagfile_information"]["relative_file_paths"]
        names = [Path(str(name)).name for name in listed]
    except (OSError, YamlError, ValueError, LookupError, TypeError):
        return []  # without a description, what is there is read
    there = {file.name for file in folder.iterdir()}
    if any(name not in names for name in there if name.endswith(".mcap") and not name.startswith("._")):
        return []  # under a name that nobody lists: files were renamed
    return [f"{name}: the file is missing, which the bag lists" for name in names if name not in there]


def _messages(stream: IO[bytes]) -> Iterator[tuple[Schema | None, Channel, Message]]:
    """Yield the messages of a file by its index; from its beginning on where it has none."""
    reader: McapReader = make_reader(stream)
    try:
        indexed = reader.get_summary() is not None
    except _DAMAGE:
        indexed = False
    if not indexed:
        stream.seek(0)
        reader = NonSeekingReader(stream)
    return iter(reader.iter_messages(log_time_order=False))  # they are sorted by their stamps


def _damage(file: Path, error: BaseException, read: int) -> str:
    """Return what is wrong with a file of which `read` samples were read."""
    if not file.stat().st_size:
        return f"{file.name}: the file is empty"
    reason = " ".join(str(error).split()) or type(error).__name__
    text = f"{file.name}: is not a complete MCAP file ({reason})"
    return f"{text}: {read} samples were read up to there; heave repair may recover more" if read else text


def _plain(path: Path, data: bytes) -> bytes:
    if data.startswith(_ZSTD_MAGIC):  # no serialised message begins so
        raise BagMotionError(f"{path}: its messages are compressed one by one; write it anew: ros2 bag convert")
    return data


_FIELDS = {
    "heave_msgs/msg/PointMotion": ("position.x", "position.y", "position.z"),
    "heave_msgs/msg/MruSample": ("heave", "status"),
}
"""Types that hold a motion, with the fields that are read of them."""


def _sample(path: Path, schema: Schema | None, channel: Channel, data: bytes) -> Sample:
    """Return the sample in the `data` of a message; heave that the MRU calls invalid is NaN."""
    kind = schema.name if schema else ""
    if kind not in _FIELDS:
        known = ", ".join(sorted(_FIELDS))
        raise BagMotionError(f"{path}: topic {channel.topic} has the wrong type: expected {known}")
    reading = _reader(kind).reading(_plain(path, data))
    seconds, nanoseconds = divmod(reading.stamp, 1_000_000_000)
    time, numbers = seconds + 1e-9 * nanoseconds, reading.numbers
    if kind.endswith("MruSample"):
        return time, 0.0, 0.0, math.nan if numbers[1] == MruStatus.INVALID else numbers[0]
    return time, numbers[0], numbers[1], numbers[2]


@cache
def _reader(kind: str) -> MessageReader:
    return MessageReader(kind, _FIELDS[kind])
