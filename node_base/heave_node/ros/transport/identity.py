"""The process behind a message, as the middleware knows it.

The identifier of a publisher (GID) begins, in every DDS, with the prefix of its participant: one per process. A sender
cannot choose it, and no two processes share it.
"""

from __future__ import annotations

import secrets
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import rclpy
from builtin_interfaces.msg import Time
from rclpy.node import Node

from heave_node.tick.speakers import ANYONE

_PREFIX = 12
"""Bytes of a GID that all publishers of one process share: DDSI-RTPS 2.5, section 8.2.4.1 (GuidPrefix_t)."""
_OF_DDS = ("fastrtps", "cyclonedds", "connextdds")
UNKNOWN_SENDER = "a node that has left"
_FAST_DDS = bytes([0x01, 0x0F])
"""Vendor number at the start of Fast DDS's prefixes; 2 bytes for the host and 2 for the process follow."""


def own_identity(node: Node) -> str:
    """Return the identity of this process, which has a `node`; ANYONE where the middleware has none."""
    if not any(name in rclpy.get_rmw_implementation_identifier() for name in _OF_DDS):
        return ANYONE
    topic = f"/_process_{secrets.token_hex(8)}"  # used by nothing else: what the graph shows there is this process
    publisher = node.create_publisher(Time, topic, 1)
    try:
        found = [identity_of_endpoint(info) for info in node.get_publishers_info_by_topic(topic)]
    finally:
        node.destroy_publisher(publisher)
    return found[0] if found else ANYONE


def identity_of_endpoint(info: Any) -> str:
    """Return the identity of the process of a publisher by what the graph says of it, `info`."""
    return _identity(info.endpoint_gid)


def identity_of_sender(info: Mapping[str, Any]) -> str:
    """Return the identity of the process that sent a message by its `info`; ANYONE where this release has no such."""
    gid = info.get("publisher_gid")
    return ANYONE if gid is None else _identity(gid["data"])


def describe_sender(node: Node, topic: str, identity: str, own: str) -> str:
    """Describe the process that published on a topic: nodes, process, machine.

    Parameters
    ----------
    node : that looks at the graph
    topic : resolved name
    identity : of the process
    own : identity of this process
    """
    if ANYONE in (identity, own):
        return UNKNOWN_SENDER
    names = {
        f"{info.node_namespace.rstrip('/')}/{info.node_name}"
        for info in node.get_publishers_info_by_topic(topic)
        if identity_of_endpoint(info) == identity
    }
    return f"{' and '.join(sorted(names)) or UNKNOWN_SENDER} ({place_of(identity, own)})"


def place_of(identity: str, own: str) -> str:
    """Describe where the process of an `identity` runs, seen from the process `own`."""
    prefix, here = bytes.fromhex(identity), bytes.fromhex(own)
    if not prefix.startswith(_FAST_DDS) or not here.startswith(_FAST_DDS):
        return f"process {identity}"
    if prefix[2:4] != here[2:4]:
        return f"on another machine, process {identity}"
    process = int.from_bytes(prefix[4:6], "little")  # the low 16 bits of its number
    return f"process {process} on this machine" if Path(f"/proc/{process}").exists() else "on this machine"


def _identity(gid: bytes | Sequence[int]) -> str:
    return bytes(gid)[:_PREFIX].hex()
