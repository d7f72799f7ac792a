"""What a topic of the suite is: its name, its type, its publisher and how it is carried."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Role(Enum):
    """How a topic is carried."""

    STREAM = "stream"
    """Reliable, volatile, a queue deep enough for a slow recorder."""
    COMMAND = "command"
    """Reliable, volatile, also from hardware. The reader takes the newest one of its owner that is not too old: a short
    queue would not do, since a stranger's message would push the owner's out of it.
    """
    LATCHED = "latched"
    """Reliable, transient local: late subscribers get the last message."""
    KEPT = "kept"
    """Reliable, transient local, and each message counts: late subscribers get the last few, oldest first."""


LASTING = (Role.LATCHED, Role.KEPT)
"""Roles of which late subscribers get what came before."""


@dataclass(frozen=True)
class Topic:
    """A topic of the suite."""

    name: str  # relative, or absolute for one that ROS has fixed
    type: str  # of its messages, for example "heave_msgs/msg/MruSample"
    publisher: str  # node that publishes it; "" for many
    role: Role = Role.STREAM  # how it is carried
    # the loop does not close without it: where its publisher is external, the start waits for it
    is_needed: bool = False
