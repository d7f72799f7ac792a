"""The pose of a crane as a serialised message."""

from __future__ import annotations

from heave_node.cdr.packer import Packer
from heave_node.crane.pose import POSE_FIELDS
from heave_node.interface import topics
from heave_node.interface.sensors import WireReading

_POSE = Packer(topics.CRANE_POSE.type, ("header.stamp", *POSE_FIELDS), {"header.frame_id": "vessel"})


def pose_message(reading: WireReading) -> bytes:
    """Return the message heave_msgs/CranePose that carries a `reading` of POSE_FIELDS."""
    return _POSE.pack(reading.stamp, *reading.numbers)
