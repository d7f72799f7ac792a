"""Who can join a run: nodes on this machine alone, unless the user opens it."""

from __future__ import annotations

import fcntl
import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from heave_node.parameters import ParameterError
from heave_node.ros.transport.environment import open_to_network, prepare_environment

LARGEST_DOMAIN = 232
"""Of the ports of DDS (OMG RTPS 9.6.1.1)."""


def set_up_transport(*, network: bool) -> None:
    """Set up the transport of this command and of the nodes it starts, open to other hosts for a `network`; say on the
    terminal where it is not loopback.

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


ANOTHER_RUN = "another run is in progress in this ROS domain: wait for it, or use --namespace NAME"


@contextmanager
def only_run_in_domain(namespace: str = "") -> Iterator[bool]:
    """Claim a ROS domain, or a `namespace` in it, of this user on this machine; tell whether no other run has it.

    Runs that begin together do not see each other yet; the lock of a file, which ends with its process, shows which one
    was first.
    """
    place = "-".join([os.environ.get("ROS_DOMAIN_ID", "0"), *namespace.strip("/").split("/")]).rstrip("-")
    name = f"heave-{os.getuid()}-domain-{place}.lock"
    descriptor = os.open(Path(tempfile.gettempdir()) / name, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o600)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        is_only = True
    except OSError:
        is_only = False
    try:
        yield is_only
    finally:
        os.close(descriptor)
