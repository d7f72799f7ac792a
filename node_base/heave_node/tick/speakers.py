"""Who may publish on a topic: known by the identity of the process, which no message can claim for itself."""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum

ANYONE = ""
"""Identity of a process that the middleware does not tell: it passes everywhere, and only the graph can show it."""


class Standing(Enum):
    """What the sender of a message is on its topic."""

    LAWFUL = "lawful"
    STRANGER = "stranger"
    UNKNOWN = "unknown"
    """The roster that says it has not come yet."""


class Speakers:
    """The processes whose messages on one topic are taken.

    One that `is_external` comes from outside the protocol, where no roster names its publisher: the first process that
    is heard keeps it, until `release`.
    """

    def __init__(self, *, is_external: bool = False) -> None:
        self.is_external = is_external
        self.identities: frozenset[str] | None = None

    def appoint(self, identities: Iterable[str]) -> None:
        """Let the processes of these identities speak, and no others."""
        self.identities = frozenset(identities)

    def release(self) -> None:
        """Let the next process that publishes keep an external topic: the one that had it has left."""
        if self.is_external:
            self.identities = None

    def standing(self, identity: str) -> Standing:
        """Return what the process of an `identity` is here; the first one heard on an external topic owns it."""
        if identity == ANYONE:
            return Standing.LAWFUL
        if self.identities is None:
            if not self.is_external:
                return Standing.UNKNOWN
            self.appoint([identity])
        assert self.identities is not None
        is_lawful = identity in self.identities or ANYONE in self.identities
        return Standing.LAWFUL if is_lawful else Standing.STRANGER
