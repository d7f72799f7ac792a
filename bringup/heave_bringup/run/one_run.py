"""One run at a time in a ROS domain, or in a namespace of it."""

from __future__ import annotations

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

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
