"""Where the motion of a ship is found in its records: a mapping file, or what the type of a topic suggests."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from heave_node.files.bounded_yaml import parse_yaml
from heave_node.files.given_files import read_given
from heave_node.interface.codes import MruStatus

from heave_bags.errors import BagError
from heave_bags.mcap.reader import Bag
from heave_bags.play.ship_time import DATE_ORDERS

MOTIONS = ("surge", "sway", "heave", "roll", "pitch")
EULER_PARTS = ("roll", "pitch", "yaw")
DEFAULT_CUT_OFF = 2.0 * math.pi / 40.0
"""Motion slower than this is taken out when acceleration is integrated [rad/s]: no sea is slower."""


@dataclass(frozen=True)
class Channel:
    """Where one motion is found.

    Attributes
    ----------
    topic, field : of a bag, such as "/imu/data", "linear_acceleration.z"; `field` may be a quaternion if `part`
        is given
    column : of a CSV log
    part : "roll", "pitch" or "yaw" of a quaternion [rad]
    scale, offset : motion = scale * value + offset, to metres or radians
    acceleration : the value is an acceleration [m/s^2]; it is integrated twice
    cut_off : what is slower is then taken out [rad/s]
    valid : field of the same topic, or column, that calls each sample valid by a number other than 0 or a word such as
        `true`; what is not valid is a gap. "": of a log, a column named after this one with `_valid`, or `valid`
    invalid_bits : `valid` is a status instead, and a sample with one of these bits set is not valid
    """

    topic: str = ""
    field: str = "data"
    column: str = ""
    part: str = ""
    scale: float = 1.0
    offset: float = 0.0
    acceleration: bool = False
    cut_off: float = DEFAULT_CUT_OFF
    valid: str = ""
    invalid_bits: int = 0


@dataclass(frozen=True)
class SeaMapping:
    """How a record becomes boom-tip motion.

    Attributes
    ----------
    channels : per motion (surge, sway, heave, roll, pitch); heave there must be
    lever_arm : boom tip from the sensor, x forward, y to port, z up [m]
    time_column, time_scale : of a log: its heading, or those of date and time or of GPS week and seconds ("": found by
        its name); numbers are seconds after the scale, or found out: see `ship_time`
    date_order : of dates with the year last, dmy or mdy; "": as the dates themselves show
    rate : samples per second of the result
    """

    channels: Mapping[str, Channel]
    lever_arm: tuple[float, float, float] = (0.0, 0.0, 0.0)
    time_column: str | Sequence[str] = ""
    time_scale: float = 1.0
    date_order: str = ""
    rate: float = 20.0


def read_mapping(path: Path) -> SeaMapping:
    """Read the mapping file `path` (YAML). Raises BagError with the file and the entry that is wrong."""
    try:
        content = parse_yaml(read_given(path))
    except (OSError, ValueError) as error:
        raise BagError(f"{path}: cannot be read as a mapping: {' '.join(str(error).split())}") from error
    if not isinstance(content, dict):
        raise BagError(f"{path}: a mapping must name heave and where it is found")
    entries = dict(content)
    channels = {name: _channel(path, name, entries.pop(name)) for name in MOTIONS if name in entries}
    if "heave" not in channels:
        raise BagError(f"{path}: heave is missing: give its topic and field, or its column")
    known = ("lever_arm", "time_column", "time_scale", "date_order", "rate")
    unknown = sorted(set(entries) - set(known))
    if unknown:
        raise BagError(f"{path}: unknown entry {unknown[0]}; known: {', '.join((*MOTIONS, *known))}")
    try:
        arm = tuple(float(value) for value in entries.pop("lever_arm", (0.0, 0.0, 0.0)))
        mapping = SeaMapping(channels, arm, **entries)  # type: ignore[arg-type]
        if len(arm) != 3 or not mapping.rate > 0.0:
            raise ValueError("lever_arm must have three numbers, rate must be above 0")
        if mapping.date_order not in ("", *DATE_ORDERS):
            raise ValueError(f"date_order must be one of {', '.join(DATE_ORDERS)}")
    except (TypeError, ValueError) as error:
        raise BagError(f"{path}: {error}") from error
    return mapping


def _channel(path: Path, name: str, entry: Any) -> Channel:
    if not isinstance(entry, dict):
        raise BagError(f"{path}: {name} must give topic and field, or column")
    try:
        channel = Channel(**entry)
    except TypeError:
        known = ", ".join(Channel.__dataclass_fields__)
        raise BagError(f"{path}: {name} has an unknown entry; known: {known}") from None
    if bool(channel.topic) == bool(channel.column):
        raise BagError(f"{path}: {name} needs either a topic or a column")
    if not isinstance(channel.invalid_bits, int) or channel.invalid_bits < 0:
        raise BagError(f"{path}: {name}: invalid_bits must be a whole number such as 6 or 0x8000")
    if channel.invalid_bits and not channel.valid:
        raise BagError(f"{path}: {name}: invalid_bits needs valid: the column or field of the status")
    if channel.part and channel.part not in EULER_PARTS:
        raise BagError(f"{path}: {name}: part must be one of {', '.join(EULER_PARTS)}")
    return channel


def mapping_for_topic(bag: Bag, topic: str) -> SeaMapping:
    """Return the mapping that the standard type of a `topic` of `bag` suggests.

    That is Odometry, Imu, Float64, Float32, and the suite's own. Raises BagError for others.
    """
    name = bag.resolve(topic)
    kind = bag.topics[name].type
    positions = {
        "nav_msgs/msg/Odometry": "pose.pose.position",
        "geometry_msgs/msg/PoseStamped": "pose.position",
        "geometry_msgs/msg/PoseWithCovarianceStamped": "pose.pose.position",
        "geometry_msgs/msg/PointStamped": "point",
        "heave_msgs/msg/PointMotion": "position",
    }
    if kind in positions:
        at = positions[kind]
        named = {"surge": "x", "sway": "y", "heave": "z"}
        return SeaMapping({motion: Channel(topic=name, field=f"{at}.{axis}") for motion, axis in named.items()})
    heaves = {
        "std_msgs/msg/Float64": Channel(topic=name),
        "std_msgs/msg/Float32": Channel(topic=name),
        "heave_msgs/msg/MruSample": Channel(
            topic=name, field="heave", valid="status", invalid_bits=int(MruStatus.INVALID)
        ),
        "heave_msgs/msg/WaveElevation": Channel(topic=name, field="elevation"),
        "sensor_msgs/msg/Imu": Channel(topic=name, field="linear_acceleration.z", acceleration=True),
    }
    if kind not in heaves:
        raise BagError(f"{bag.path}: {name} is {kind}, which is not a motion by itself: write a mapping file")
    return SeaMapping({"heave": heaves[kind]})
