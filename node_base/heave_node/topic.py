"""What a topic of the suite is: its name, its type, its publisher and how it is carried."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Role(Enum):
    """How a topic is carried."""

    STREAM = "stream"
    """Reliable, volatile, a queue deep enough for a slow recorder."""
    LATCHED = "latched"
    """Reliable, transient local: late subscribers get the last message."""


@dataclass(frozen=True)
class Topic:
    """A topic of the suite."""

    name: str
    type: str
    publisher: str
    """Node that publishes it; "" for many."""
    role: Role = Role.STREAM
    is_needed: bool = False
    """The loop does not close without it: where its publisher is external, the start waits for it."""
