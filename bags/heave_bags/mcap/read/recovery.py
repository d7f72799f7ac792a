"""Repair, then read: a bag that is not sound is copied, as far as it can be read, to files that are.

Damaged files, files without an index, compressed ones and ones in no order become indexed files of messages in order;
then `rosbags` reads them as it reads any other bag. Messages in no order are sorted in pieces of bounded size, each a
run of chunks in order, and a reader by log time merges the runs.

Log times also go back where the clock of a simulation was reset: then the order of the files is the order, and each
reset begins another file.
"""

from __future__ import annotations

import shutil
import weakref
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from tempfile import gettempdir, mkdtemp
from typing import IO

from heave_bags.errors import BagError
from heave_bags.mcap.loss import Loss
from heave_bags.mcap.read.decode import BagTopic
from heave_bags.mcap.read.scan import FoundMessage, McapScan
from heave_bags.mcap.read.survey import Survey
from heave_bags.mcap.writer import McapWriter

Progress = Callable[[float], None]
"""Called with the share of the work that is done, 0 to 1."""

MOST_HELD = 64 << 20
"""Bytes of messages that are sorted at once."""
MESSAGE_OVERHEAD = 512
"""Bytes that a message takes in memory beside its data."""
CLOCK_STEP = 1_000_000_000
"""A log time that is earlier than the one before by more than this may be due to a reset [ns]."""
_FIRST_TIMES = 500
"""Times of a topic that are remembered, by which a run that begins again is known."""
_RAREST_STEPS = 20
"""A clock is reset less often than once in so many messages."""

NOT_IN_ORDER = "its messages are not in the order of their log times: they are read in that order"
RESET = "its clock was reset: its messages are read in the order of its files, in which log times go back"


def no_progress(_share: float) -> None:
    """Report no progress."""


@dataclass
class _FirstTimes:
    """Some of the times at which a topic first had messages [ns]."""

    times: set[int]
    earliest: int
    latest: int

    def add(self, time: int) -> None:
        self.times.add(time)
        self.earliest, self.latest = min(self.earliest, time), max(self.latest, time)


class ClockWatch:
    """Distinguishes a simulation's clock that was reset from messages that were written late, in bounded memory.

    After a reset, topics have messages at the very times of the earlier run, which are ticks. Late messages have their
    own times; and where messages come in no order at all, time goes back more often than any clock is reset.
    """

    def __init__(self) -> None:
        self._first: dict[str, _FirstTimes] = {}
        self._previous = 0
        self._messages = self._steps = self._again = self._other = 0
        self.is_ascending = True

    def observe(self, messages: Sequence[FoundMessage]) -> None:
        """Take the next messages in the order of the files."""
        self._messages += len(messages)
        for topic, log_time, *_ in messages:
            if log_time < self._previous:
                self.is_ascending = False
                self._steps += log_time < self._previous - CLOCK_STEP
            self._previous = log_time
            first = self._first.setdefault(topic, _FirstTimes(set(), log_time, log_time))
            if self._steps and log_time in first.times:
                self._again += 1
            elif self._steps and first.earliest < log_time < first.latest:
                self._other += 1
            elif len(first.times) < _FIRST_TIMES:
                first.add(log_time)

    @property
    def note(self) -> str:
        """What a reader must know of the order; "" for messages in order."""
        if self.is_ascending:
            return ""
        is_reset = self._steps * _RAREST_STEPS <= self._messages and self._again > self._other
        return RESET if is_reset else NOT_IN_ORDER


@dataclass
class Recovered:
    """What was recovered of a bag: `files` that are sound, in order, the `losses`, and a `note` on the order."""

    files: list[Path] = field(default_factory=list)
    losses: list[Loss] = field(default_factory=list)
    note: str = ""


def recover(
    surveys: Sequence[Survey],
    expected: Mapping[Path, int],
    topics: Mapping[str, BagTopic],
    progress: Progress = no_progress,
) -> Recovered:
    """Copy the messages of a bag to sound files in a temporary folder, which goes with what is returned.

    Parameters
    ----------
    surveys : of its files, in their order
    expected : how many messages a file has, as is written beside it; a file that is not in it has an unknown number
    topics : by name
    progress : called with the share done

    Raises BagError where there is no room for the copy.
    """
    is_own = all(survey.contents.is_own for survey in surveys)
    result = Recovered(note="" if is_own else _note(surveys))
    numbering: dict[str, int] | None = {} if surveys[0].is_first else None
    sizes = [survey.path.stat().st_size for survey in surveys]
    total, before = max(sum(sizes), 1), 0
    try:
        folder = Path(mkdtemp(prefix="heave_bag_"))
        weakref.finalize(result, shutil.rmtree, folder, ignore_errors=True)
        copy = _Copy(folder, topics, sorts=result.note == NOT_IN_ORDER)
        for survey, previous, size in zip(surveys, (None, *surveys), sizes, strict=False):
            if previous is not None and survey.follows_gap(previous):
                numbering = None
            scan = McapScan(survey.path, expected=expected.get(survey.path), numbering=numbering)
            for block in scan.blocks():
                copy.take(block)
                progress((before + scan.position) / total)
            result.losses += scan.contents.losses
            before += size
        result.files = copy.close()
    except OSError as error:
        free = shutil.disk_usage(gettempdir()).free
        reason = f"no room for a sound copy in {gettempdir()} ({free / 1e9:.1f} GB free): {error.strerror}"
        raise BagError(f"{surveys[0].path.parent}: {reason}; set TMPDIR to a folder with more room") from error
    return result


def _note(surveys: Iterable[Survey]) -> str:
    watch = ClockWatch()
    for block in chain.from_iterable(McapScan(survey.path).blocks() for survey in surveys):
        watch.observe(block)
    return watch.note


class _Sink:
    """What an MCAP file is written to, without a journal."""

    def __init__(self, stream: IO[bytes]) -> None:
        self.write = self.finish = stream.write


class _Copy:
    """Writes messages to files in `folder`: in order by sorted runs, or a file for each time the clock goes back."""

    def __init__(self, folder: Path, topics: Mapping[str, BagTopic], *, sorts: bool) -> None:
        self._folder = folder
        self._topics = topics
        self._sorts = sorts
        self._files: list[Path] = []
        self._held: list[FoundMessage] = []
        self._size = 0
        self._open()

    def _open(self) -> None:
        self._files.append(self._folder / f"{len(self._files)}.mcap")
        self._stream = self._files[-1].open("wb")
        self._writer = McapWriter(_Sink(self._stream))
        self._channels: dict[str, int] = {}
        self._latest = 0

    def take(self, messages: Sequence[FoundMessage]) -> None:
        """Take the next messages in the order of the files."""
        if not self._sorts:
            for message in messages:
                if message.log_time < self._latest:
                    self._finish()
                    self._open()
                self._latest = message.log_time
                self._write(message)
            return
        for message in messages:
            self._held.append(message)
            self._size += len(message.data) + MESSAGE_OVERHEAD
            if self._size > MOST_HELD:
                self._write_run()

    def _write_run(self) -> None:
        for message in sorted(self._held, key=lambda message: (message.log_time, message.sequence)):
            self._write(message)
        self._writer.close_chunk()
        self._held, self._size = [], 0

    def _write(self, message: FoundMessage) -> None:
        topic, log_time, publish_time, sequence, data = message
        channel = self._channels.get(topic)
        if channel is None:
            known = self._topics[topic]
            schema = self._writer.add_schema(known.type, "ros2msg" if known.schema else "", known.schema.encode())
            channel = self._channels[topic] = self._writer.add_channel(topic, schema, {})
        self._writer.write(channel, log_time, data, publish_time=publish_time, sequence=sequence)

    def _finish(self) -> None:
        self._writer.finish()
        self._stream.close()

    def close(self) -> list[Path]:
        """Write what is held; return the files."""
        if self._held:
            self._write_run()
        self._finish()
        return self._files
