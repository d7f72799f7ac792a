"""Who can join a run: nodes on this machine alone, unless the user opens it."""

from __future__ import annotations

import os
import sys

from heave_node.parameters import ParameterError
from heave_node.ros.transport.environment import open_to_network, prepare_environment

LARGEST_DOMAIN = 232
"""Of the ports of DDS (OMG RTPS 9.6.1.1)."""


def set_up_transport(*, network: bool) -> None:
    """Set up the transport of this command and of the nodes it starts; say on the terminal where it is not loopback.

    Parameters
    ----------
    network : open it to other hosts

    Raises ParameterError for a ROS domain that is none.
    """
    domain = os.environ.get("ROS_DOMAIN_ID", "")
    if domain and not (domain.isdecimal() and int(domain) <= LARGEST_DOMAIN):
        raise ParameterError(f"ROS_DOMAIN_ID={domain!r}: must be a whole number from 0 to {LARGEST_DOMAIN}")
    if network:
        open_to_network()
    notice = prepare_environment()
    if notice:
        sys.stderr.write(f"heave: {notice}\n")
