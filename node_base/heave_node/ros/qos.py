"""Quality of service by role: one definition for publishers, subscribers and the recorder."""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from heave_node.topics import Role

STREAM_DEPTH = 200
"""Messages kept for a subscriber that is slower than its publisher: ten seconds at 20 Hz."""


def qos_of(role: Role) -> QoSProfile:
    """Return the quality of service of topics of this `role`."""
    latched = role is Role.LATCHED
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=1 if latched else STREAM_DEPTH,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )
