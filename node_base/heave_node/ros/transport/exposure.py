"""Whether the middleware did what the profile of the transport requests: the ports of a process, as the kernel
shows them.

A profile that Fast DDS cannot read is an error in its log, and then its defaults hold: every interface.
"""

from __future__ import annotations

import ipaddress
import sys
from collections.abc import Collection
from contextlib import suppress
from pathlib import Path

FIRST_PORT = 7400
PORTS_PER_DOMAIN = 250
"""Ports of a ROS domain d, FIRST_PORT + PORTS_PER_DOMAIN d and up: DDSI-RTPS 2.5, section 9.6.2 (PB, DG)."""


def exposed_ports(domain: int, inherited: Collection[str] = ()) -> list[str]:
    """Return this process's UDP ports of a ROS domain that are not bound to loopback, as ADDRESS:PORT, sorted.

    Empty where the kernel does not tell (other systems than Linux).

    Parameters
    ----------
    domain : number of the ROS domain
    inherited : sockets of the process that started this one, which a launch with nodes of its own leaves open in it
    """
    own = own_sockets() - set(inherited)
    first = FIRST_PORT + PORTS_PER_DOMAIN * domain
    return sorted(
        f"{address}:{port}"
        for address, port, inode in _bound_sockets()
        if inode in own and port in range(first, first + PORTS_PER_DOMAIN) and not address.is_loopback
    )


def own_sockets() -> set[str]:
    """Return the inodes of the sockets that this process has open."""
    own = set()
    folder = Path("/proc/self/fd")
    for descriptor in list(folder.iterdir()) if folder.is_dir() else []:
        with suppress(OSError):  # closed meanwhile
            name = str(descriptor.readlink())
            if name.startswith("socket:["):
                own.add(name[len("socket:[") : -1])
    return own


def _bound_sockets() -> list[tuple[ipaddress.IPv4Address | ipaddress.IPv6Address, int, str]]:
    """Return address, port and inode of every UDP socket of this network namespace."""
    found = []
    for table in (Path("/proc/self/net/udp"), Path("/proc/self/net/udp6")):
        for line in table.read_text().splitlines()[1:] if table.exists() else []:
            fields = line.split()
            text, _, port = fields[1].partition(":")
            # words of 32 bits, each in the byte order of the machine
            words = [int(text[i : i + 8], 16).to_bytes(4, sys.byteorder) for i in range(0, len(text), 8)]
            found.append((ipaddress.ip_address(b"".join(words)), int(port, 16), fields[9]))
    return found
