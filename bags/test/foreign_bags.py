"""Bags as other recorders write them: without the suite's own records, by another clock, unnumbered."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from heave_bags.mcap.files import RUN_RECORD
from heave_bags.mcap.reader import Bag, RawMessage
from heave_bags.mcap.ros.qos import to_yaml
from mcap.writer import Writer

HOST_TIME = 1_795_000_000_000_000_000
"""A time of a host's clock [ns]: in the year 2026."""
PACE = 40
"""A lockstep run goes so many times faster than its own time."""


def by_host_clock(message: RawMessage, chance: random.Random) -> int:
    """Return when a message of a lockstep run arrives by the host's clock, up to a millisecond late [ns]."""
    return HOST_TIME + message.log_time // PACE + chance.randrange(400_000)


def by_simulated_clock(message: RawMessage, chance: random.Random) -> int:
    """Return when a message arrives by /clock, which may still stand at the tick before [ns]."""
    tick = 50_000_000
    return max(message.log_time - tick * chance.randrange(2), 1)


def write_foreign(
    source: Path,
    folder: Path,
    log_time: Callable[[RawMessage, random.Random], int],
    *,
    without: Iterable[str] = (),
    namespace: str = "",
) -> Path:
    """Write the messages of a bag as another recorder would have, in the order of their arrival.

    Topics `without` which the bag is to be are left out; the others get a `namespace` in front of their names.
    """
    chance = random.Random(1)
    bag = Bag(source)
    arrivals = sorted(((log_time(message, chance), message) for message in bag.messages()), key=lambda pair: pair[0])
    folder.mkdir(parents=True)
    with (folder / f"{folder.name}_0.mcap").open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="rosbag2 0.29")
        channels = {}
        for name, topic in bag.topics.items():
            schema = writer.register_schema(topic.type, "ros2msg", topic.schema.encode())
            metadata = {"offered_qos_profiles": to_yaml(topic.qos)}
            channels[name] = writer.register_channel(f"{namespace}{name}", "cdr", schema, metadata)
        for time, message in arrivals:
            if message.topic not in without:
                writer.add_message(channels[message.topic], time, message.data, time)
        writer.finish()
    return folder


def copy_messages(bag: Bag, files: Mapping[Path, Iterable[tuple[int, RawMessage]]], **options: object) -> None:
    """Write numbered messages of a bag to files as another recorder would, in the order in which they come.

    Each file carries the attachments and what the bag reports of its run; `options` are of the writer.
    """
    for path, messages in files.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("wb") as stream:
            writer = Writer(stream, **options)
            writer.start(profile="ros2", library="rosbag2 0.29")
            for name, attached in bag.attached.items():
                writer.add_attachment(0, 0, name, attached.media_type, attached.data)
            writer.add_metadata(RUN_RECORD, bag.run)
            channels = {}
            for name, topic in bag.topics.items():
                schema = writer.register_schema(topic.type, "ros2msg", topic.schema.encode())
                channels[name] = writer.register_channel(name, "cdr", schema)
            for number, message in messages:
                writer.add_message(channels[message.topic], message.log_time, message.data, message.log_time, number)
            writer.finish()
