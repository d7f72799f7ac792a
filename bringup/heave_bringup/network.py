"""Who can join a run: nodes on this machine alone, unless the user opens it."""

from __future__ import annotations

import sys

from heave_node.ros.transport.environment import open_to_network, prepare_environment


def set_up_transport(*, network: bool) -> None:
    """Set up the transport of this command and of the nodes it starts; say on the terminal where it is not loopback.

    Parameters
    ----------
    network : open it to other hosts
    """
    if network:
        open_to_network()
    notice = prepare_environment()
    if notice:
        sys.stderr.write(f"heave: {notice}\n")
