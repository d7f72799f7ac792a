"""The process behind a message, as the middleware knows it.

The identifier of a publisher (GID) begins, in every DDS, with the prefix of its participant: one per process. A sender
cannot choose it, and no two processes share it. Fast DDS writes a number of the host into it, which it makes from the
host's addresses: the same for all processes of a machine (of a container, where that has addresses of its own), but no
name. A name is known only of hosts on which a node of this suite has reported it (TickJoin). The number of a machine is
printed there by `python -m heave_node.ros.transport.identity`.
"""

from __future__ import annotations

import secrets
import socket
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import rclpy
from builtin_interfaces.msg import Time
from rclpy.node import Node

from heave_node.ros.transport.environment import prepare_environment
from heave_node.tick.speakers import ANYONE

_PREFIX = 12
"""Bytes of a GID that all publishers of one process share: DDSI-RTPS 2.5, section 8.2.4.1 (GuidPrefix_t)."""
_OF_DDS = ("fastrtps", "cyclonedds", "connextdds")
UNKNOWN_SENDER = "a node that has left"
NAMELESS_SENDER = "a program without a ROS node name"
NO_NAME = "_NODE_NAME_UNKNOWN_"
"""Name in the graph of an endpoint that is of no ROS node, or whose node is not known yet."""
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
    """Return the identity of the process of a publisher by the graph's entry for it, `info`."""
    return _identity(info.endpoint_gid)


def node_of_endpoint(info: Any) -> str:
    """Return the full name of the node of a publisher or subscription by the graph's entry for it, `info`."""
    return f"{info.node_namespace.rstrip('/')}/{info.node_name}"


def identity_of_sender(info: Mapping[str, Any]) -> str:
    """Return the identity of the process that sent a message by its `info`; ANYONE where this release has no such."""
    gid = info.get("publisher_gid")
    return ANYONE if gid is None else _identity(gid["data"])


def describe_sender(node: Node, topic: str, identity: str, own: str, hosts: Mapping[str, str] | None = None) -> str:
    """Describe the process that published on a topic: nodes, process, machine.

    Parameters
    ----------
    node : that looks at the graph
    topic : resolved name
    identity : of the process
    own : identity of this process
    hosts : names of machines, as far as they are known, by `host_of`
    """
    if ANYONE in (identity, own):
        return UNKNOWN_SENDER
    found = [info for info in node.get_publishers_info_by_topic(topic) if identity_of_endpoint(info) == identity]
    names = {node_of_endpoint(info) for info in found if info.node_name != NO_NAME}
    who = " and ".join(sorted(names)) or (NAMELESS_SENDER if found else UNKNOWN_SENDER)
    return f"{who} ({place_of(identity, own, hosts)})"


def host_of(identity: str) -> str:
    """Return the number of the machine of a process of an `identity`, in hexadecimal; "" where the DDS gives none."""
    prefix = bytes.fromhex(identity)
    return prefix[2:4].hex() if prefix.startswith(_FAST_DDS) else ""


def place_of(identity: str, own: str, hosts: Mapping[str, str] | None = None) -> str:
    """Describe where the process of an `identity` runs, seen from the process `own`.

    `hosts` are names of machines, as far as they are known, by `host_of`.
    """
    host, here = host_of(identity), host_of(own)
    if not host or not here:
        return f"process {identity}"
    process = int.from_bytes(bytes.fromhex(identity)[4:6], "little")  # the low 16 bits of its number
    if host == here:
        return f"process {process} on this machine" if Path(f"/proc/{process}").exists() else "on this machine"
    name = (hosts or {}).get(host, "")
    machine = f"machine {name}" if name else "another machine or container"
    return f"process {process} on {machine}, DDS host {host}"


def _identity(gid: bytes | Sequence[int]) -> str:
    return bytes(gid)[:_PREFIX].hex()


def main() -> None:
    """Print the number of this machine, as it is named in alarms about processes on other machines."""
    prepare_environment()
    rclpy.init()
    node = rclpy.create_node("heave_identity")
    try:
        sys.stdout.write(f"{socket.gethostname()} is DDS host {host_of(own_identity(node)) or 'without a number'}\n")
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
