"""Passes over the files of a bag: as they come where they are in order, merged by log time where they are not."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import chain
from pathlib import Path

from heave_bags.mcap.bounds import LATEST_TIME
from heave_bags.mcap.loss import Loss
from heave_bags.mcap.read.contents import Block, FileContents, RawMessage
from heave_bags.mcap.read.order import NOT_IN_ORDER, RESET, ClockWatch, FileOrder, Merge, Span, are_ascending
from heave_bags.mcap.read.scan import McapScan
from heave_bags.mcap.read.survey import Survey

Progress = Callable[[float], None]
"""Called with the share of the work that is done, 0 to 1."""


def no_progress(_share: float) -> None:
    """Report no progress."""


class BagPasses:
    """Reads the messages of the files of a bag.

    Files of this project are in their order, even where a reset has set the clock back; those of others are in the
    order of log times.

    Parameters
    ----------
    surveys : of the files, in their order
    expected : how many messages a file has, as is written beside it; a file that is not in it has an unknown number

    Attributes
    ----------
    losses : what could not be read in the last pass
    note : what a reader must know of the order, after the first pass; "" for a bag in order
    """

    def __init__(self, surveys: Sequence[Survey], expected: Mapping[Path, int]) -> None:
        self._surveys = surveys
        self._expected = expected
        self._is_own = all(survey.contents.is_own for survey in surveys)
        self.losses: list[Loss] = []
        self.note = ""

    def messages(
        self,
        wanted: Collection[str] | None = None,
        start: int = 0,
        end: int = LATEST_TIME,
        progress: Progress = no_progress,
    ) -> Iterator[RawMessage]:
        """Yield the messages of `wanted` topics (None: all) with log times from `start` to `end` [ns], in order.

        `progress` is called with the share that is read.
        """
        if self._is_in_file_order:
            yield from self._as_they_come(wanted, start, end, progress)
        else:
            yield from self._merged(wanted, start, end, progress)
        progress(1.0)

    @cached_property
    def _is_in_file_order(self) -> bool:
        if self._is_own or self._is_said_to_be_in_order:
            return True
        look = self._look
        if are_ascending((span.first, span.last) for span in look.spans):
            return True
        self.note = RESET if look.was_reset else NOT_IN_ORDER
        return look.was_reset

    @property
    def _is_said_to_be_in_order(self) -> bool:
        """Whether the summaries of the files vouch for their order."""
        blocks = [survey.blocks for survey in self._surveys]
        return None not in blocks and are_ascending(chain.from_iterable(part for part in blocks if part is not None))

    @cached_property
    def _look(self) -> _Look:
        return _Look(self._surveys, self._expected)

    def _as_they_come(
        self, wanted: Collection[str] | None, start: int, end: int, progress: Progress
    ) -> Iterator[RawMessage]:
        self.losses = []
        order = FileOrder(note=self.note)
        sizes = [survey.path.stat().st_size for survey in self._surveys]
        before, total = 0, max(sum(sizes), 1)
        numbering: dict[str, int] | None = {} if self._surveys[0].is_first else None
        for number, (survey, size) in enumerate(zip(self._surveys, sizes, strict=True)):
            if number and survey.follows_gap(self._surveys[number - 1]):
                numbering = None
            scan = McapScan(
                survey.path,
                start=start,
                end=end,
                wanted=wanted,
                expected=self._expected.get(survey.path),
                numbering=numbering,
                progress=_shared_progress(progress, before, total),
            )
            for block in scan.blocks():
                yield from block.messages if self._is_own else order.messages(block)
            self.losses += scan.contents.losses
            before += size
        self.note = order.note

    def _merged(self, wanted: Collection[str] | None, start: int, end: int, progress: Progress) -> Iterator[RawMessage]:
        self.losses = list(self._look.losses)
        spans = [span for span in self._look.spans if span.first <= end and span.last >= start]

        def read(span: Span) -> Iterator[Block]:
            scan = McapScan(self._surveys[span.file].path, start=start, end=end, wanted=wanted)
            return scan.again([span.place], self._look.contents[span.file])

        first = min((span.first for span in spans), default=0)
        length = max(max((span.last for span in spans), default=0) - first, 1)
        for count, message in enumerate(Merge(spans, read).messages()):
            if not count % _PROGRESS_EVERY:
                progress((message.log_time - first) / length)
            yield message


_PROGRESS_EVERY = 1000


class _Look:
    """What is found in one pass over all files, in their order: where their messages lie, and what is lost.

    Attributes
    ----------
    spans : of the blocks
    contents : of each file
    losses : what could not be read
    was_reset : the clock was reset
    """

    def __init__(self, surveys: Sequence[Survey], expected: Mapping[Path, int]) -> None:
        self.spans: list[Span] = []
        self.contents: list[FileContents] = []
        self.losses: list[Loss] = []
        watch = ClockWatch()
        for number, survey in enumerate(surveys):
            scan = McapScan(survey.path, expected=expected.get(survey.path))
            for block in scan.blocks():
                watch.observe(block.messages)
                self.spans.append(Span(number, block.place, *block.span))
            self.contents.append(scan.contents)
            self.losses += scan.contents.losses
        self.was_reset = watch.was_reset


def _shared_progress(progress: Progress, before: int, total: int) -> Callable[[int], None]:
    return lambda position: progress((before + position) / total)
