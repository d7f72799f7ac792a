"""In which order the messages of a bag are read: by log time, or as its files have them where a clock was reset.

Messages in no order are sorted in runs of bounded size, which lie in a temporary folder (`TMPDIR`), and are merged.
"""

from __future__ import annotations

import heapq
import marshal
import shutil
import weakref
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from tempfile import gettempdir, mkdtemp

from heave_bags.errors import BagError
from heave_bags.mcap.read.scan import RawMessage

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

    def observe(self, messages: Sequence[RawMessage]) -> None:
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


class SortedMessages:
    """Messages of `blocks` in any order by log time, sorted in runs; these lie in a temporary folder, which goes with
    this object.

    Raises BagError where there is no room for them; it names the `path` of the bag.
    """

    def __init__(self, path: Path, blocks: Iterable[Sequence[RawMessage]]) -> None:
        self._runs: list[Path] = []
        held: list[RawMessage] = []
        size = 0
        try:
            self._folder = Path(mkdtemp(prefix="heave_bag_"))
            weakref.finalize(self, shutil.rmtree, self._folder, ignore_errors=True)
            for message in chain.from_iterable(blocks):
                held.append(message)
                size += len(message.data) + MESSAGE_OVERHEAD
                if size > MOST_HELD:
                    self._write_run(held)
                    held, size = [], 0
            self._write_run(held)
        except OSError as error:
            free = shutil.disk_usage(gettempdir()).free
            reason = f"no room to sort its messages in {gettempdir()} ({free / 1e9:.1f} GB free): {error.strerror}"
            raise BagError(f"{path}: {reason}; set TMPDIR to a folder with more room") from error

    def _write_run(self, messages: list[RawMessage]) -> None:
        messages.sort(key=lambda message: (message.log_time, message.sequence))
        self._runs.append(self._folder / str(len(self._runs)))
        with self._runs[-1].open("wb") as stream:
            for message in messages:
                marshal.dump(tuple(message), stream)

    def __iter__(self) -> Iterator[RawMessage]:
        return heapq.merge(*map(_read_run, self._runs), key=lambda message: message.log_time)


def _read_run(path: Path) -> Iterator[RawMessage]:
    with path.open("rb") as stream, suppress(EOFError):
        while True:
            yield RawMessage(*marshal.load(stream))
