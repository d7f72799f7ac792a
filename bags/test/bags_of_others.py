"""Bags as recorders, systems and accidents of others leave them, made of a heave that is known in closed form."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable, Sequence
from pathlib import Path

import yaml
import zstandard
from heave_bags.mcap.files import METADATA_ROOT
from mcap.writer import CompressionType, Writer

START = 1_750_000_000_000_000_000
"""Log time of the first message [ns]."""
PERIOD = 100_000_000
"""Time between messages [ns]."""
AMPLITUDE, WAVE_PERIOD = 1.5, 9.0
TOPIC = "/mru/heave"

Sample = tuple[int, float]
"""Log time [ns] and heave [m]."""


def heave_at(time: float) -> float:
    """Return the heave `time` after the first message [s]."""
    return AMPLITUDE * math.sin(2.0 * math.pi * time / WAVE_PERIOD)


def samples(count: int = 6000, first: int = 0) -> list[Sample]:
    """Return `count` samples of the heave from number `first` on, in order."""
    return [(START + PERIOD * number, heave_at(number * PERIOD * 1e-9)) for number in range(first, first + count)]


def write_mcap(
    path: Path,
    messages: Iterable[Sample],
    *,
    encoding: str = "ros2msg",
    definition: str = "float64 data\n",
    packed: bool = False,
    **options: object,
) -> Path:
    """Write samples as std_msgs/Float64 to an MCAP file in the order in which they come; `options` are the writer's."""
    with path.open("wb") as stream:
        writer = Writer(stream, **{"compression": CompressionType.NONE, **options})
        writer.start(profile="ros2", library="rosbag2")
        schema = writer.register_schema("std_msgs/msg/Float64", encoding, definition.encode())
        channel = writer.register_channel(TOPIC, "cdr", schema)
        for time, value in messages:
            data = b"\x00\x01\x00\x00" + struct.pack("<d", value)
            writer.add_message(channel, time, zstandard.compress(data) if packed else data, time)
        writer.finish()
    return path


def write_metadata(folder: Path, parts: Sequence[tuple[str, Sequence[Sample]]], **changes: object) -> None:
    """Write the `metadata.yaml` that rosbag2 would write of files, each a name and its samples."""
    files = [
        {
            "path": name,
            "starting_time": {"nanoseconds_since_epoch": min(part)[0]},
            "duration": {"nanoseconds": max(part)[0] - min(part)[0]},
            "message_count": len(part),
        }
        for name, part in parts
    ]
    count = sum(len(part) for _, part in parts)
    topic = {"name": TOPIC, "type": "std_msgs/msg/Float64", "serialization_format": "cdr", "offered_qos_profiles": []}
    information = {
        "version": 9,
        "storage_identifier": "mcap",
        "message_count": count,
        "topics_with_message_count": [{"topic_metadata": topic, "message_count": count}],
        "relative_file_paths": [name for name, _ in parts],
        "files": files,
        "compression_format": "",
        "compression_mode": "",
        **changes,
    }
    (folder / "metadata.yaml").write_text(yaml.safe_dump({METADATA_ROOT: information}))


def write_split(folder: Path, names: Sequence[str], count: int = 1000) -> list[list[Sample]]:
    """Write a bag of files with names, `count` samples in each; return the samples of each."""
    folder.mkdir()
    parts = [samples(count, number * count) for number in range(len(names))]
    for name, part in zip(names, parts, strict=True):
        write_mcap(folder / name, part)
    write_metadata(folder, list(zip(names, parts, strict=True)))
    return parts
