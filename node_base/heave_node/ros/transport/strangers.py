"""Who publishes where only others may, and which of their messages were rejected: noticed, named, and never obeyed."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass

from rclpy.node import Node

from heave_node.interface.alarm import NODE_ALARMS, Alarm
from heave_node.ros.diagnostics import Health, Level
from heave_node.ros.transport.identity import (
    NAMELESS_SENDER,
    UNKNOWN_SENDER,
    describe_sender,
    host_of,
    identity_of_endpoint,
)
from heave_node.tick.speakers import Speakers, Standing

PART = "strangers"
"""Part of a node's diagnostics that names them."""
LOOK_PERIOD = 0.4
"""Wall time between two looks at the publishers of the run's topics [s]: a stranger is named within a second."""
_MOST = 20
"""Strangers that are listed one by one; any more are counted together."""


@dataclass
class Stranger:
    """One process on one topic that is not its own."""

    who: str  # its nodes, process and machine in words
    refused: int = 0  # messages of it that were refused
    why: str = ""  # what was wrong with a message of the protocol; "" where the sender was


class Strangers:
    """The strangers that one node has noticed.

    Parameters
    ----------
    node : that listens
    own : identity of its process

    Attributes
    ----------
    has_news : somebody was noticed since the last `health`
    """

    def __init__(self, node: Node, own: str) -> None:
        self._node = node
        self._own = own
        self._known: dict[tuple[str, str, str], Stranger] = {}
        self._looked_at = self._left_looked_at = 0.0
        self._hosts: dict[str, str] = {}
        self.has_news = False

    def note_host(self, identity: str, name: str) -> None:
        """Note that the machine of the process of an `identity` has this `name`: strangers on it are named with it."""
        if identity and name and len(self._hosts) < _MOST:
            self._hosts.setdefault(host_of(identity), name)

    def _describe(self, topic: str, identity: str) -> str:
        return describe_sender(self._node, topic, identity, self._own, self._hosts)

    def refuse(self, topic: str, identity: str, why: str = "") -> None:
        """Note that a message on a resolved `topic` was refused.

        Parameters
        ----------
        topic : resolved name
        identity : of the process that sent it
        why : what is wrong with the message; "": its sender is not part of the run
        """
        stranger = self._notice(topic, identity, why)
        stranger.refused += 1
        is_unknown = stranger.who.startswith((UNKNOWN_SENDER, NAMELESS_SENDER))
        if is_unknown and stranger.refused < _MOST:  # its name may come a little later
            stranger.who = self._describe(topic, identity)

    def refuse_speaker(self, topic: str, identity: str, speakers: Speakers) -> None:
        """Note that the process of an `identity` is none of the `speakers` of a `topic`.

        Where these have left an external topic, the next process keeps it; looked at twice a second.
        """
        self.refuse(topic, identity)
        now = time.monotonic()
        if speakers.is_external and now - self._left_looked_at >= LOOK_PERIOD:
            self._left_looked_at = now
            self._look_at(topic, speakers)

    def look(self, speakers: Mapping[str, Speakers]) -> None:
        """Look at the publishers of topics, a few times per second of wall time; the first time at once.

        `speakers` may publish, by resolved name; there are none before the run is known.
        """
        now = time.monotonic()
        if not speakers or now - self._looked_at < LOOK_PERIOD:
            return
        self._looked_at = now
        for topic, lawful in speakers.items():
            expected = 0 if lawful.identities is None else len(lawful.identities)
            if lawful.is_external or self._node.count_publishers(topic) > expected:
                self._judge_publishers(topic, lawful)

    def _judge_publishers(self, topic: str, lawful: Speakers) -> None:
        for identity in sorted(self._look_at(topic, lawful)):
            if lawful.standing(identity) is Standing.STRANGER:
                self._notice(topic, identity, "")

    def _look_at(self, topic: str, speakers: Speakers) -> set[str]:
        """Return who publishes on a `topic`; where its `speakers` have left it, the next one is no stranger."""
        present = {identity_of_endpoint(info) for info in self._node.get_publishers_info_by_topic(topic)}
        if speakers.is_external and not present & (speakers.identities or frozenset()):
            speakers.release()
            kept = {key: stranger for key, stranger in self._known.items() if key[0] != topic or stranger.why}
            self.has_news, self._known = self.has_news or len(kept) < len(self._known), kept
        return present

    def health(self) -> list[Health]:
        """Return what was noticed so far, for diagnostics; empty where nothing was."""
        self.has_news = False
        if not self._known:
            return []
        words = "; ".join(str(_alarm(topic, stranger)) for (topic, _, _), stranger in self._known.items())
        values = {f"{topic} of {s.who}": f"{s.refused} refused" for (topic, _, _), s in self._known.items()}
        return [Health(PART, Level.ERROR, words, values)]

    def _notice(self, topic: str, identity: str, why: str) -> Stranger:
        key = (topic, identity, why)
        if key not in self._known and len(self._known) >= _MOST:
            key = ("other topics", "", "")
        if key not in self._known:
            self._known[key] = Stranger(self._describe(topic, identity), why=why)
            self.has_news = True
            self._node.get_logger().error(str(_alarm(topic, self._known[key])))
        return self._known[key]


def _alarm(topic: str, stranger: Stranger) -> Alarm:
    if stranger.why:
        return NODE_ALARMS.alarm("MESSAGE_REJECTED", who=stranger.who, topic=topic, why=stranger.why)
    return NODE_ALARMS.alarm("UNKNOWN_PUBLISHER", who=stranger.who, topic=topic)
