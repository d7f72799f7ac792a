"""Who takes part in a run: what the clock master knows of each participant, and they of one another; without ROS."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from heave_node.interface.topics import is_part
from heave_node.tick.speakers import ANYONE

NOT_WAITED_FOR = 2**32 - 1
"""Lag of a participant that nobody waits for, not even at the end: it works beside the ticks, and may be gone."""


@dataclass
class Participant:
    """What one node said in its TickJoin, and how far it is."""

    name: str  # of the node
    ready: bool = False  # it waits for the first tick
    lag: int = 0  # ticks that it may be behind; NOT_WAITED_FOR: any number
    # resolved topic names, with the number of peers that each one sees
    outputs: dict[str, int] = field(default_factory=dict)
    inputs: dict[str, int] = field(default_factory=dict)  # the same of what it takes
    answered: int = 0  # last tick that it has answered
    published: Sequence[int] = ()  # messages that it has sent so far on each output
    waiting_for: str = ""  # what it lacks, in its own words
    lost: int = 0  # messages of the run that never came to it, as it says at the end
    identity: str = ""  # of its process
    host: str = ""  # name of its machine
    entry: int = 0  # first one of its counters in the roster


class Roster:
    """The participants of a run, their outputs and their counters.

    Without the nodes of the names `expected` no tick begins; the master's comes first.
    """

    def __init__(self, expected: Iterable[str]) -> None:
        self.expected = tuple(expected)
        self.participants: dict[str, Participant] = {}
        self._present: list[Participant] = []
        self._entries: list[tuple[str, str]] = []

    def join(self, participant: Participant) -> None:
        """Take what a `participant` reports of itself; its progress is kept."""
        known = self.participants.get(participant.name)
        if known is not None:
            participant.answered, participant.published = known.answered, known.published
        self.participants[participant.name] = participant
        self._present = [self.participants[name] for name in self.expected if name in self.participants]

    def missing(self, external_topics: Mapping[str, int], needed: Collection[str] = ()) -> list[str]:
        """Return in words what keeps the run from starting; empty where nothing does.

        Parameters
        ----------
        external_topics : resolved topics that come from outside the protocol, each with the number of its publishers
        needed : those of them that must have one
        """
        lacking = [f"{name} (not seen)" for name in self.expected if name not in self.participants]
        lacking += [f"{p.name} (not ready)" for p in self._present if not p.ready]
        lacking += [f"a publisher of {topic} (external)" for topic in needed if external_topics[topic] == 0]
        return lacking + self._unmatched() + self._deaf_to(external_topics)

    def _deaf_to(self, external_topics: Mapping[str, int]) -> list[str]:
        """Return in words who does not see an external publisher that is there: yet, or ever, for its QoS."""
        published = [topic for topic, count in external_topics.items() if count > 0]
        return [
            f"{participant.name} sees no publisher of {topic} (external)"
            for participant in self._present
            for topic in published
            if participant.inputs.get(topic) == 0
        ]

    def _unmatched(self) -> list[str]:
        """Return in words which participants do not see each other on a topic yet."""
        lacking = []
        readers = Counter(topic for participant in self._present for topic in participant.inputs)
        for participant in self._present:
            for topic, matched in participant.outputs.items():
                expected = readers[topic]
                if matched < expected:
                    lacking.append(f"{participant.name} sees {matched} of {expected} subscribers of {topic}")
            for topic, matched in participant.inputs.items():
                expected = sum(topic in other.outputs for other in self._present)
                if matched < expected:
                    lacking.append(f"{participant.name} sees {matched} of {expected} publishers of {topic}")
        return lacking

    def freeze(self) -> None:
        """Fix the order of the counters: the run begins."""
        self._entries = [(p.name, topic) for p in self._present for topic in p.outputs]
        entry = 0
        for participant in self._present:
            participant.published, participant.entry = [0] * len(participant.outputs), entry
            entry += len(participant.outputs)

    @property
    def nodes(self) -> list[str]:
        """Publisher of each counter."""
        return [node for node, _ in self._entries]

    @property
    def topics(self) -> list[str]:
        """Topic of each counter."""
        return [topic for _, topic in self._entries]

    @property
    def identities(self) -> list[str]:
        """Process of each counter."""
        return [self.participants[node].identity for node, _ in self._entries]

    def identities_of(self, topic: str) -> list[str]:
        """Return the processes that publish a `topic` within ticks."""
        return sorted({p.identity for p in self._present if topic in p.outputs})

    @property
    def counters(self) -> list[int]:
        """Messages published so far, per entry."""
        return [count for participant in self._present for count in participant.published]

    def answer(self, name: str, tick: int, published: Sequence[int]) -> None:
        """Note that the node `name` has done its part of `tick` and sent `published` messages, per output.

        Repeated and old answers change nothing.
        """
        participant = self.participants[name]
        if tick > participant.answered:
            participant.answered = tick
            participant.published = published
            participant.waiting_for = ""

    def unanswered(self, tick: int, *, flush: bool = False) -> list[Participant]:
        """Return the participants that have not answered `tick`; without a `flush`, those that may lag have time."""
        waited_for = [p for p in self._present if p.lag != NOT_WAITED_FOR]
        return [p for p in waited_for if p.answered < tick - (0 if flush else p.lag)]

    def lost_words(self, own: int) -> str:
        """Return which messages never came to whom, in words, with the clock master's `own`; "" for none."""
        lost = {self.expected[0]: own, **{p.name: p.lost for p in self._present if p.lost}}
        reported = ", ".join(f"{count} to {name}" for name, count in lost.items() if count)
        return f"messages of the run were lost: {reported}" if reported else ""

    def answered_by_all(self) -> int:
        """Return the last tick that all have answered; those that may lag do not count."""
        return min((p.answered for p in self._present if p.lag == 0), default=0)

    def restart(self) -> None:
        """Count ticks from 1 again; message counters go on."""
        for participant in self._present:
            participant.answered = 0

    def published_by_topic(self) -> dict[str, int]:
        """Return how many messages the nodes have published on each topic, as they say."""
        totals: dict[str, int] = {}
        for (_, topic), count in zip(self._entries, self.counters, strict=True):
            if is_part(topic):
                continue
            totals[topic] = totals.get(topic, 0) + count
        return totals


class KnownRoster:
    """What a participant knows of the run that it takes part in, from the clock master's roster.

    Attributes
    ----------
    master : process of the clock master, from the roster on
    other_master : one whose run this process does not take part in
    epoch : of the run
    nodes : publisher of each counter; the clock master's come first
    """

    def __init__(self) -> None:
        self.master = self.other_master = ""
        self.epoch = 0
        self.nodes: tuple[str, ...] = ()
        self._outputs: Counter[str] = Counter()
        self._identities: dict[str, str] = {}

    def take(self, master: str, epoch: int, nodes: Sequence[str], identities: Sequence[str]) -> None:
        """Take a roster.

        Parameters
        ----------
        master : process that sent it
        epoch : of its run
        nodes, identities : publisher of each counter, and its process
        """
        self.master, self.epoch, self.nodes = master, epoch, tuple(nodes)
        self._outputs = Counter(nodes)
        self._identities = dict(zip(nodes, identities, strict=True))

    def identity_of(self, node: str) -> str:
        """Return the process of a `node`; ANYONE where the roster does not name it."""
        return self._identities.get(node, ANYONE)

    def outputs_of(self, node: str) -> int:
        """Return on how many topics a `node` publishes."""
        return self._outputs[node]
