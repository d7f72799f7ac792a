"""The folder of a rosbag2 bag: names of its files and its `metadata.yaml`, version 9."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from heave_bags.mcap.qos import OfferedQos

METADATA_NAME = "metadata.yaml"
METADATA_VERSION = 9
"""The highest that today's readers outside of ROS take as well."""

STORAGE = "mcap"
METADATA_RECORD = "rosbag2"
METADATA_KEY = "serialized_metadata"

RUN_RECORD = "heave_run"
"""Name of the MCAP metadata record that says what a bag is: scenario, seed, versions."""

OUTCOME_RECORD = "heave_outcome"
"""Name of the MCAP metadata record that says how a run went: real-time factor, missed deadlines, how it ended."""


@dataclass
class TopicSummary:
    """One topic of a bag."""

    name: str
    type: str
    qos: tuple[OfferedQos, ...] = ()
    type_hash: str = ""
    message_count: int = 0


@dataclass
class FileSummary:
    """One file of a bag; times in nanoseconds, start of the first message and end of the last."""

    path: str
    start_time: int = 0
    end_time: int = 0
    message_count: int = 0


@dataclass
class BagSummary:
    """What `metadata.yaml` says of a bag."""

    files: list[FileSummary] = field(default_factory=list)
    topics: list[TopicSummary] = field(default_factory=list)
    custom_data: Mapping[str, str] = field(default_factory=dict)
    ros_distro: str = ""

    def to_mapping(self) -> dict[str, Any]:
        """Return the content of `metadata.yaml`."""
        spans = [(part.start_time, part.end_time) for part in self.files if part.message_count]
        start = min((span[0] for span in spans), default=0)
        end = max((span[1] for span in spans), default=0)
        return {
            "rosbag2_bagfile_information": {
                "version": METADATA_VERSION,
                "storage_identifier": STORAGE,
                "duration": {"nanoseconds": end - start},
                "starting_time": {"nanoseconds_since_epoch": start},
                "message_count": sum(part.message_count for part in self.files),
                "topics_with_message_count": [_topic_mapping(topic) for topic in self.topics],
                "compression_format": "",
                "compression_mode": "",
                "relative_file_paths": [part.path for part in self.files],
                "files": [_file_mapping(part) for part in self.files],
                "custom_data": dict(self.custom_data) or None,
                "ros_distro": self.ros_distro,
            }
        }

    def to_yaml(self) -> str:
        """Return the text of `metadata.yaml`."""
        return str(yaml.safe_dump(self.to_mapping(), sort_keys=False, width=1000))


def _topic_mapping(topic: TopicSummary) -> dict[str, Any]:
    return {
        "topic_metadata": {
            "name": topic.name,
            "type": topic.type,
            "serialization_format": "cdr",
            "offered_qos_profiles": [profile.to_mapping() for profile in topic.qos],
            "type_description_hash": topic.type_hash,
        },
        "message_count": topic.message_count,
    }


def _file_mapping(part: FileSummary) -> dict[str, Any]:
    return {
        "path": part.path,
        "starting_time": {"nanoseconds_since_epoch": part.start_time},
        "duration": {"nanoseconds": part.end_time - part.start_time},
        "message_count": part.message_count,
    }


def file_name(bag: Path, number: int) -> str:
    """Return the name of the bag's file `number`, from 0."""
    return f"{bag.name}_{number}.mcap"


def write_metadata(bag: Path, summary: BagSummary) -> None:
    """Write `metadata.yaml` in one step: a crash leaves the old one or the new one."""
    temporary = bag / (METADATA_NAME + ".new")
    temporary.write_text(summary.to_yaml(), encoding="utf-8")
    temporary.replace(bag / METADATA_NAME)


def sorted_files(names: Sequence[Path]) -> list[Path]:
    """Return bag files in the order of their number (file 10 after file 9), then by name."""

    def key(path: Path) -> tuple[int, str]:
        number = path.stem.rsplit("_", 1)[-1]
        return (int(number) if number.isdigit() else -1, path.name)

    return sorted(names, key=key)
