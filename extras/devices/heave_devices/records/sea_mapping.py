"""Where the motion of a ship is found in its records: a mapping file, or what the type of a topic suggests."""

from __future__ import annotations

from pathlib import Path

from heave_bags.errors import BagError
from heave_bags.mcap.reader import Bag
from heave_node.interface.codes import MruStatus

from heave_devices.maps.channel import Channel, MapError
from heave_devices.maps.device_map import DeviceMap, read_device_map
from heave_devices.records.ship_time import DATE_ORDERS

MOTIONS = ("surge", "sway", "heave", "roll", "pitch")
"""Quantities of a map that make up a sea, which needs heave."""


def read_mapping(path: Path) -> DeviceMap:
    """Read a mapping file at a `path`, or the map of a device: `heave_devices.maps.device_map` has the form.

    Raises BagError with the file and the entry that is wrong.
    """
    try:
        device = read_device_map(path)
    except MapError as error:
        raise BagError(str(error)) from error
    if device.date_order not in ("", *DATE_ORDERS):
        raise BagError(f"{path}: date_order must be one of {', '.join(DATE_ORDERS)}")
    return device


def mapping_for_topic(bag: Bag, topic: str) -> DeviceMap:
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
        return DeviceMap({motion: Channel(topic=name, field=f"{at}.{axis}") for motion, axis in named.items()})
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
    return DeviceMap({"heave": heaves[kind]})
