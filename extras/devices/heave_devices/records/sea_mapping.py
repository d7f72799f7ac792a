"""Where the motion of a ship is found in its records: a mapping file, or what the type of a topic suggests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from heave_bags.errors import BagError
from heave_bags.mcap.reader import Bag
from heave_node.interface.codes import MruStatus

from heave_devices.maps.channel import Channel, MapError
from heave_devices.maps.device_map import DeviceMap, read_device_map
from heave_devices.records.ship_time import DATE_ORDERS

MOTIONS = ("surge", "sway", "heave", "roll", "pitch")


@dataclass(frozen=True)
class SeaMapping:
    """How a record becomes boom-tip motion."""

    channels: Mapping[str, Channel]  # per motion (surge, sway, heave, roll, pitch), of a sea; heave there must be
    lever_arm: tuple[float, float, float] = (0.0, 0.0, 0.0)  # boom tip from the sensor, x forward, y to port, z up [m]
    # of a log: its heading, or those of date and time or of GPS week and seconds; "": found by its name
    time_column: str | Sequence[str] = ""
    time_scale: float = 1.0  # numbers are seconds after the scale, or found out: see `ship_time`
    date_order: str = ""  # of dates with the year last, dmy or mdy; "": as the dates themselves show
    rate: float = 20.0  # samples per second of the result [1/s]
    # the whole map, where the record is what a device sent, line by line; None: a bag, or columns
    device: DeviceMap | None = None


def read_mapping(path: Path, quantities: Sequence[str] = MOTIONS) -> SeaMapping:
    """Read a mapping file, or the map of a device: `heave_devices.maps.device_map` has the form.

    Parameters
    ----------
    path : of the file (YAML)
    quantities : of the map that are wanted; by default those of a sea, which needs heave

    Raises BagError with the file and the entry that is wrong.
    """
    try:
        device = read_device_map(path)
    except MapError as error:
        raise BagError(str(error)) from error
    channels = {name: device.channels[name] for name in quantities if name in device.channels}
    if quantities is MOTIONS and "heave" not in channels:
        raise BagError(f"{path}: heave is missing: give its topic and field, or its column")
    record = device.record
    if record.date_order not in ("", *DATE_ORDERS):
        raise BagError(f"{path}: date_order must be one of {', '.join(DATE_ORDERS)}")
    return SeaMapping(
        channels,
        device.lever_arm,
        record.time_column,
        record.time_scale,
        record.date_order,
        record.rate,
        device if device.format else None,
    )


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
