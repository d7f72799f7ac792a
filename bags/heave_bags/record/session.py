"""What a recorder does with messages: write them to a bag, keep the last ones for a snapshot, start, stop and
split. No ROS.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from heave_node.interface.alarm import read_alarms

from heave_bags.errors import BagError, StorageError
from heave_bags.mcap.bag_writer import DESCRIPTION_PERIOD, BagWriter
from heave_bags.mcap.files import SNAPSHOT
from heave_bags.mcap.loss import RecordedLoss
from heave_bags.mcap.ros.qos import OfferedQos

ALARMS = read_alarms(Path(__file__).with_name("alarms.yaml"))
"""Alarms of the recorder."""
STOPPED = "after that nothing was written"
"""Why messages that came after a bag was given up are not in it."""


class SnapshotRing:
    """The last messages of all topics, within a `span` of log time [ns], 0 keeps nothing, and a `limit` [bytes]; those
    of latched topics outlive the span.
    """

    def __init__(self, span: int, limit: int) -> None:
        self.span = span
        self._limit = limit
        self._messages: deque[tuple[str, int, bytes]] = deque()
        self._latched: dict[str, tuple[int, bytes]] = {}
        self._size = 0

    def put(self, topic: str, log_time: int, data: bytes, *, latched: bool = False) -> None:
        """Take the message `data` of `topic` at `log_time` [ns]; the oldest leave.

        Of a `latched` topic the newest is kept for good.
        """
        if self.span <= 0:
            return
        if latched:
            self._latched[topic] = (log_time, data)
            return
        self._messages.append((topic, log_time, data))
        self._size += len(data)
        while self._messages and (log_time - self._messages[0][1] > self.span or self._size > self._limit):
            self._size -= len(self._messages.popleft()[2])

    def since(self, start: int) -> list[tuple[str, int, bytes]]:
        """Return latched messages, then the others from log time `start` [ns] on, in the order of time."""
        if not self._messages:
            return []
        first = max(start, self._messages[0][1])
        latched = [(topic, max(time, first), data) for topic, (time, data) in self._latched.items()]
        return sorted(latched + [entry for entry in self._messages if entry[1] >= first], key=lambda entry: entry[1])

    def __len__(self) -> int:
        return len(self._messages)


@dataclass
class _KnownTopic:
    type: str
    qos: tuple[OfferedQos, ...]
    latched: bool = False
    last: tuple[int, bytes] | None = None  # the last message of a latched topic: a bag begun later starts with it


@dataclass
class SessionState:
    """How recording goes: messages `written` and `unwritten`, and `problems` in words."""

    written: int = 0
    unwritten: int = 0  # messages that came while a bag should have been written and could not be
    problems: list[str] = field(default_factory=list)


class RecordingSession:
    """Writes one bag after another, by the writer that `make_writer` gives for a folder; `ring` is what is kept for
    snapshots.

    A disk that refuses ends the bag, not the session, where it is to `survive`; else the StorageError is raised.
    """

    def __init__(self, make_writer: Callable[[Path], BagWriter], ring: SnapshotRing, *, survive: bool) -> None:
        self._make_writer = make_writer
        self._topics: dict[str, _KnownTopic] = {}
        self._survive = survive
        self._writer: BagWriter | None = None
        self._broken: BagWriter | None = None
        self._told_at = 0.0
        self._since: RecordedLoss | None = None
        self.ring = ring
        self.state = SessionState()
        self.last_time = 0

    @property
    def folder(self) -> Path | None:
        """Folder of the bag that is being written; None between bags."""
        return self._writer.folder if self._writer else None

    @property
    def is_recording(self) -> bool:
        """Return whether a bag is being written."""
        return self._writer is not None

    def start(self, folder: Path) -> None:
        """Begin a bag. Raises BagError while one is being written, or if the folder exists."""
        if self._writer:
            raise BagError(f"{self._writer.folder} is being recorded: stop it first")
        self._report_unwritten(at_once=True)
        self._broken = None
        self._writer = self._make_writer(folder)
        for name, topic in self._topics.items():
            self._writer.add_topic(name, topic.type, topic.qos)
        for name in sorted(self._topics):
            last = self._topics[name].last
            if last and self.last_time:
                self._writer.write(name, self.last_time, last[1])

    def stop(self, outcome: Mapping[str, str] | None = None) -> str:
        """End the bag, with the `outcome` of the run in its metadata; return its folder.

        Raises BagError if there is none, StorageError if it could not be completed.
        """
        if not self._writer:
            raise BagError("no recording is in progress")
        writer, self._writer = self._writer, None
        writer.close(outcome)
        return str(writer.folder)

    def split(self) -> None:
        """Begin the next file of the bag. Raises BagError if no recording is in progress."""
        if not self._writer:
            raise BagError("no recording is in progress")
        self._writer.split()

    def add_topic(self, name: str, message_type: str, qos: Sequence[OfferedQos]) -> str:
        """Make the topic `name` of `message_type` known, as its publishers offer it (`qos`).

        Returns "" or what a reader of the bag will lack.
        """
        latched = bool(qos) and all(offer.durability == "transient_local" for offer in qos)
        self._topics[name] = _KnownTopic(message_type, tuple(qos), latched)
        return self._writer.add_topic(name, message_type, qos) if self._writer else ""

    def write(self, topic: str, log_time: int, data: bytes) -> None:
        """Take the message `data` of `topic` at `log_time` [ns].

        Raises StorageError if the disk refuses and the session does not survive it.
        """
        self.last_time = log_time
        known = self._topics[topic]
        if known.latched:
            known.last = (log_time, data)
        if self.ring.span:
            self.ring.put(topic, log_time, data, latched=known.latched)
        if self._writer is None:
            if self._broken is not None:
                self.state.unwritten += 1
                self._since = RecordedLoss(STOPPED, 1, log_time, log_time).joined(self._since)
            return
        try:
            self._writer.write(topic, log_time, data)
        except StorageError:
            self._give_up()
        except BagError as error:  # one message that no bag takes; the others go on
            self.state.unwritten += 1
            self._writer.note_loss("a message that no bag takes", 1, log_time)
            if str(error) not in self.state.problems:
                self.state.problems.append(str(error))
        else:
            self.state.written += 1

    def acknowledge(self) -> None:
        """Make what was written survive a crash of this process."""
        if self._writer is None:
            self._report_unwritten()
            return
        try:
            self._writer.acknowledge()
        except StorageError:
            self._give_up()

    def _give_up(self) -> None:
        """End a bag that the disk refuses."""
        assert self._writer is not None
        writer, self._writer = self._writer, None
        self._broken = writer
        try:
            writer.close({"ended": "a write to the disk failed"})
        except StorageError as error:
            self.state.problems.append(str(error))
            if not self._survive:
                raise

    def note_missed(self, messages: int, why: str) -> None:
        """Note that a number of `messages` did not come to the recorder, and `why`; the bag will say so."""
        if self._writer is not None:
            self.state.unwritten += messages
            self._writer.note_loss(why, messages, self.last_time)

    def finish(self) -> None:
        """Let a bag that the disk has refused say how much was not written until now."""
        self._report_unwritten(at_once=True)

    def _report_unwritten(self, *, at_once: bool = False) -> None:
        """Tell the bag that was given up, now and then, how many messages came since."""
        if self._broken is None or self._since is None or (time.monotonic() < self._told_at and not at_once):
            return
        self._told_at = time.monotonic() + DESCRIPTION_PERIOD
        lost, self._since = self._since, None
        self._broken.note_loss(lost.reason, lost.messages, lost.start, lost.end)

    def save_snapshot(self, folder: Path, span: int = 0) -> int:
        """Write the last `span` [ns] (0: all that is kept) to a bag of their own; return the number of messages.

        Raises BagError if nothing is kept or the folder exists, StorageError if the disk refuses.
        """
        if not self.ring.span:
            raise BagError("no snapshot is kept: begin the run with --set recorder.snapshot_duration=60")
        messages = self.ring.since(self.last_time - span if span else 0)
        writer = self._make_writer(folder)
        for name, topic in self._topics.items():
            writer.add_topic(name, topic.type, topic.qos)
        for name, log_time, data in messages:
            writer.write(name, log_time, data)
        writer.close({"ended": SNAPSHOT})
        return len(messages)

    def counts(self) -> dict[str, int]:
        """Return the number of messages in the present bag, by topic."""
        if not self._writer:
            return {}
        return {topic.name: topic.message_count for topic in self._writer.summary().topics}


def missing_messages(published: Mapping[str, int], recorded: Mapping[str, int]) -> dict[str, int]:
    """Return by how many messages recorded topics hold fewer than were published on them; those that hold all are not
    in it.
    """
    lacking = {topic: count - recorded[topic] for topic, count in published.items() if topic in recorded}
    return {topic: count for topic, count in lacking.items() if count > 0}


def missing_words(missing: Mapping[str, int], published: Mapping[str, int]) -> str:
    """Say what is `missing` of what was `published`, by topic; "" for nothing."""
    return ", ".join(f"{topic} {count} of {published[topic]}" for topic, count in missing.items())
