"""Quality of service by role: one definition for publishers, subscribers and the recorder; and what users change of it.

Users change it by ROS's own parameters, `qos_overrides./TOPIC.publisher.POLICY` and `.subscription.`.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSCompatibility,
    QoSPolicyKind,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
)
from rclpy.qos_overriding_options import QoSOverridingOptions

from heave_node.interface.topic import LASTING, Role
from heave_node.ros.transport.identity import NO_NAME, node_of_endpoint

STREAM_DEPTH = 200
"""Messages kept for a subscriber that is slower than its publisher: ten seconds at 20 Hz."""
KEPT_DEPTH = 20
"""Messages of a kept topic that are held: it has few, one a second of simulated time."""
_DEPTH = {Role.LATCHED: 1, Role.KEPT: KEPT_DEPTH}
OVERRIDES = "qos_overrides."
PUBLISHER, SUBSCRIPTION = "publisher", "subscription"


def qos_of(role: Role) -> QoSProfile:
    """Return the quality of service that publishers of topics of this `role` offer, and readers in lockstep request."""
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=_DEPTH.get(role, STREAM_DEPTH),
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if role in LASTING else DurabilityPolicy.VOLATILE,
    )


def reader_qos_of(role: Role, *, is_external: bool) -> QoSProfile:
    """Return the quality of service that a reader within ticks requests.

    Parameters
    ----------
    role : of the topic
    is_external : hardware publishes the topic. Readings are then taken from reliable and from best-effort publishers
        (the usual profile of sensor data); commands must be reliable
    """
    qos = qos_of(role)
    qos.depth = STREAM_DEPTH  # also of latched topics: in a queue of one a stranger's message would replace the owner's
    if role is Role.KEPT:  # those of before are for who looks on; within ticks each is late
        qos.durability = DurabilityPolicy.VOLATILE
    if is_external and role is not Role.COMMAND:
        qos.reliability = ReliabilityPolicy.BEST_EFFORT
        qos.durability = DurabilityPolicy.VOLATILE
    return qos


def overriding_options(node: Node, topic: str, entity: str, *, is_lockstep: bool) -> QoSOverridingOptions | None:
    """Return which policies of a topic the user has changed by parameters; None where he has not.

    Parameters
    ----------
    node : that was given the parameters
    topic : resolved name
    entity : PUBLISHER or SUBSCRIPTION
    is_lockstep : refuses what could lose a message

    Raises ValueError for a policy that ROS does not know.
    """
    given = node.get_parameters_by_prefix(f"{OVERRIDES}{topic}.{entity}")
    if not given:
        return None
    known = {kind.name.lower(): kind for kind in QoSPolicyKind if kind is not QoSPolicyKind.INVALID}
    for name in given:
        if name not in known:
            raise ValueError(f"{OVERRIDES}{topic}.{entity}.{name}: no such policy; known: {', '.join(known)}")

    def judge(qos: QoSProfile) -> Any:
        is_allowed = not is_lockstep or qos.reliability == ReliabilityPolicy.RELIABLE
        return SetParametersResult(successful=is_allowed, reason="lockstep needs reliability: reliable")

    return QoSOverridingOptions([known[name] for name in given], callback=judge)


def unused_overrides(node: Node, used: set[tuple[str, str]]) -> list[str]:
    """Return the changes that a `node` was given for topics that are not among those it has made (`used`)."""
    prefixes = tuple(f"{topic}.{entity}." for topic, entity in used)
    given = node.get_parameters_by_prefix(OVERRIDES.rstrip("."))
    return sorted(f"{OVERRIDES}{name}" for name in given if not name.startswith(prefixes))


def mismatches(node: Node, topic: str, names: Collection[str]) -> list[str]:
    """Describe which publishers of a topic certain readers cannot receive from, and why.

    Parameters
    ----------
    node : that looks at the graph
    topic : resolved name
    names : of the nodes that read
    """
    # a node's name is discovered a moment after its publishers: it is looked at again
    publishers = [info for info in node.get_publishers_info_by_topic(topic) if info.node_name != NO_NAME]
    readers = [info for info in node.get_subscriptions_info_by_topic(topic) if info.node_name in names]
    found: dict[str, None] = {}
    for publisher in publishers:
        for reader in readers:
            words = f"{node_of_endpoint(publisher)} and {node_of_endpoint(reader)} do not match on {topic}: "
            if publisher.topic_type != reader.topic_type:
                found[words + f"the types are {publisher.topic_type} and {reader.topic_type}"] = None
                continue
            compatibility, reason = qos_check_compatible(publisher.qos_profile, reader.qos_profile)
            if compatibility == QoSCompatibility.ERROR:
                found[words + _plain(reason)] = None
    return list(found)


def _plain(reason: str) -> str:
    """Return a reason of the middleware as one short phrase."""
    return "; ".join(part.strip().removeprefix("ERROR: ").rstrip(".") for part in reason.split(";") if part.strip())
