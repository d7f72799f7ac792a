"""The folder of a rosbag2 bag: names of its files and its `metadata.yaml`, version 9."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from heave_node.files.bounded_yaml import DUMPER, LARGEST_YAML, parse_yaml
from mcap.records import Metadata

from heave_bags.mcap.ros.qos import OfferedQos

METADATA_NAME = "metadata.yaml"
METADATA_VERSION = 9
"""The highest that today's readers outside ROS accept as well."""

STORAGE = "mcap"
METADATA_RECORD = "rosbag2"
METADATA_KEY = "serialized_metadata"
METADATA_ROOT = "rosbag2_bagfile_information"
"""The key of `metadata.yaml` that holds everything. The record inside a file is without it."""

RECORDING_MARK = {"heave_recording": "in progress"}
"""Custom data of a bag that is being written, or whose writer was stopped: its counts are those of a moment before."""

RUN_RECORD = "heave_run"
"""Name of the MCAP metadata record that says what a bag is: scenario, seed, versions."""

OUTCOME_RECORD = "heave_outcome"
"""Name of the MCAP metadata record that says how a run went: real-time factor, missed deadlines, how it ended."""

COMPLETE, SNAPSHOT = "complete", "snapshot"
"""Regular ends of a bag: run or recording was over, or it holds a part of a run on purpose."""


@dataclass
class TopicSummary:
    """One topic of a bag."""

    name: str  # of the topic
    type: str  # `package/msg/Type`
    qos: tuple[OfferedQos, ...] = ()  # offered by its publishers
    type_hash: str = ""  # RIHS01; "" if not known
    message_count: int = 0  # in the bag


class ListedFile(NamedTuple):
    """A file of a bag, as its description lists it."""

    name: str  # without its folder
    start: int | None = None  # log time of its first message [ns]; None: not known
    end: int | None = None  # log time of its last message [ns]; None: not known
    messages: int | None = None  # in it; None where that is not known


@dataclass
class BagSummary:
    """What `metadata.yaml` says of a bag."""

    files: list[ListedFile] = field(default_factory=list)  # in their order
    topics: list[TopicSummary] = field(default_factory=list)  # in their order
    custom_data: Mapping[str, str] = field(default_factory=dict)  # names and values of the recorder's own
    ros_distro: str = ""  # it was recorded under

    def to_mapping(self) -> dict[str, Any]:
        """Return what rosbag2 writes of a bag: into its files as it is, into `metadata.yaml` below METADATA_ROOT."""
        start = min((part.start or 0 for part in self.files if part.messages), default=0)
        end = max((part.end or 0 for part in self.files if part.messages), default=0)
        return {
            "version": METADATA_VERSION,
            "storage_identifier": STORAGE,
            "duration": {"nanoseconds": end - start},
            "starting_time": {"nanoseconds_since_epoch": start},
            "message_count": sum(part.messages or 0 for part in self.files),
            "topics_with_message_count": [_topic_mapping(topic) for topic in self.topics],
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [part.name for part in self.files],
            "files": [_file_mapping(part) for part in self.files],
            "custom_data": dict(self.custom_data) or None,
            "ros_distro": self.ros_distro,
        }

    def to_record(self) -> str:
        """Return the text of the metadata record inside a file."""
        return _yaml(self.to_mapping())

    def to_yaml(self) -> str:
        """Return the text of `metadata.yaml`."""
        return _yaml({METADATA_ROOT: self.to_mapping()})


def _yaml(content: Mapping[str, Any]) -> str:
    return str(yaml.dump(content, Dumper=DUMPER, sort_keys=False, width=1000))


def parse_information(text: str) -> dict[str, Any]:
    """Return what the `text` of a `metadata.yaml` or of the record inside a file says of a bag.

    Empty where it says nothing sensible.
    """
    try:
        content = parse_yaml(text)
    except ValueError:
        return {}
    information = content.get(METADATA_ROOT, content) if isinstance(content, dict) else None
    return information if isinstance(information, dict) else {}


def read_information(folder: Path) -> dict[str, Any]:
    """Return what the `metadata.yaml` in a folder says; empty where there is none or it cannot be read."""
    try:
        with (folder / METADATA_NAME).open(encoding="utf-8") as stream:
            return parse_information(stream.read(LARGEST_YAML + 1))
    except (OSError, UnicodeDecodeError):
        return {}


def information_in_record(metadata: Sequence[Metadata]) -> dict[str, Any]:
    """Return what the last of the records of rosbag2 in the `metadata` of a file says; empty where there is none."""
    texts = [record.metadata.get(METADATA_KEY, "") for record in metadata if record.name == METADATA_RECORD]
    return parse_information(texts[-1]) if texts else {}


def listed_files(information: Mapping[str, Any]) -> list[ListedFile]:
    """Return the files that the `information` on a bag lists, in order; empty where it makes no sense.

    What it says of the last file is not known yet where the bag was being written then.
    """
    try:
        names = [Path(str(path)).name for path in information["relative_file_paths"]]
        parts = {Path(str(part["path"])).name: part for part in information.get("files") or ()}
        custom = information.get("custom_data") or {}
        closed = names[:-1] if RECORDING_MARK.items() <= custom.items() else names
        return [_listed(name, parts[name]) if name in closed and name in parts else ListedFile(name) for name in names]
    except (LookupError, TypeError, ValueError, AttributeError):
        return []


def _listed(name: str, part: Mapping[str, Any]) -> ListedFile:
    start, messages = int(part["starting_time"]["nanoseconds_since_epoch"]), int(part["message_count"])
    end = start + int(part["duration"]["nanoseconds"])
    return ListedFile(name, start, end, messages) if messages >= 0 else ListedFile(name)


def file_counts(information: Mapping[str, Any]) -> dict[str, int]:
    """Return the number of messages of each file of a completed bag, by name, from its `information`.

    Empty for a bag that was being written then, and where the numbers do not agree with each other.
    """
    try:
        counts = {part.name: part.messages for part in listed_files(information)}
        by_topic = [int(topic["message_count"]) for topic in information["topics_with_message_count"]]
        known = {name: count for name, count in counts.items() if count is not None}
        agrees = sum(known.values()) == sum(by_topic) == int(information["message_count"]) > 0
    except (LookupError, TypeError, ValueError, AttributeError):
        return {}
    return known if agrees and len(known) == len(counts) else {}


def count_in_record(metadata: Sequence[Metadata]) -> int | None:
    """Return the number of messages that a file says in its `metadata` it has; None where it does not."""
    counts = file_counts(information_in_record(metadata))
    return list(counts.values())[-1] if counts else None


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


def _file_mapping(part: ListedFile) -> dict[str, Any]:
    start, end = part.start or 0, part.end or 0
    times = {"starting_time": {"nanoseconds_since_epoch": start}, "duration": {"nanoseconds": end - start}}
    return {"path": part.name, **times, "message_count": part.messages or 0}


def file_name(bag: Path, number: int) -> str:
    """Return the name of the bag's file `number`, from 0."""
    return f"{bag.name}_{number}.mcap"


def write_metadata(bag: Path, summary: BagSummary) -> None:
    """Write the `summary` of `bag` to its `metadata.yaml` in one step: a crash leaves the old one or the new one."""
    replace_metadata(bag, summary.to_yaml().encode())


def replace_metadata(bag: Path, text: bytes) -> None:
    """Make `text` the `metadata.yaml` of a bag, in one step."""
    temporary = bag / (METADATA_NAME + ".new")
    try:
        temporary.write_bytes(text)
        temporary.replace(bag / METADATA_NAME)
    except OSError:
        with suppress(OSError):
            temporary.unlink()
        raise


def force_metadata(bag: Path, text: bytes) -> None:
    """Make `text` the `metadata.yaml` of a bag; on a full disk in the place of the old one, which has its blocks."""
    try:
        replace_metadata(bag, text)
    except OSError:
        with (bag / METADATA_NAME).open("r+b") as stream:
            stream.write(text)
            stream.truncate()
