"""What of a file could not be read, or was not recorded: where, why, how many messages, by the best evidence there is.

Evidence on the number of lost messages, from the strongest on: the count of the whole file (its summary, or what was
written beside it) less what was read; gaps in the numbers that this project's recorders give the messages of each
topic; the message indexes behind a chunk that cannot be unpacked. What a recorder knows that its bag lacks, it writes
into `metadata.yaml` as data of its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from heave_bags.errors import one_line
from heave_bags.mcap.bounds import LATEST_TIME

NO_FOOTER = "the file has no index (its writer did not finish)"
MISSING = "messages are missing"
MISSING_FILE = "the file is missing, which the bag lists"
_REASON, _MESSAGES, _FROM, _TO = (f"heave_lost_{name}" for name in ("reason", "messages", "from_ns", "to_ns"))
LONGEST_REASON = 500
"""Characters of a reason that are read."""
MOST_NAMED = 3
"""Losses that are named, each in a line."""


@dataclass(frozen=True)
class Loss:
    """A part of a file that could not be read."""

    file: Path  # where it is
    position: int | None  # where it begins [bytes]; None where it is no one place
    reason: str  # what is wrong there
    start: int | None = None  # log time after which messages are missing [ns]; None: not known
    # log time before which they are missing [ns]; None: not known, such as the end of what a cut has taken
    end: int | None = None
    messages: int | None = None  # how many were lost; None where it cannot be known

    def __str__(self) -> str:
        if self.start is None:
            span = "an unknown span of time"
        elif self.end is None:
            span = f"everything from {self.start * 1e-9:.3f} s on"
        else:
            span = f"{(self.end - self.start) * 1e-9:.3f} s (from {self.start * 1e-9:.3f} s to {self.end * 1e-9:.3f} s)"
        count = "an unknown number of" if self.messages is None else str(self.messages)
        place = "" if self.position is None else f" at byte {self.position}"
        return one_line(f"{self.file.name}: {self.reason}{place}: {span} with {count} messages lost")


def remarks(notes: Iterable[str], losses: Iterable[Loss]) -> list[str]:
    """Return what a reader of a bag must know, one line each: the `notes`, and the largest `losses`."""
    found = list(losses)
    largest = sorted(found, key=lambda loss: -math.inf if loss.messages is None else -loss.messages)[:MOST_NAMED]
    named = [f"not all of the bag could be read: {loss}" for loss in found if loss in largest]
    if rest := [loss.messages for loss in found if loss not in largest]:
        count = "an unknown number of" if None in rest else sum(filter(None, rest))
        named.append(f"not all of the bag could be read: {len(rest)} more places with {count} messages lost")
    return [*map(one_line, notes), *named]


class LossAccount:
    """Collects the losses of one pass over the file `path` and settles how many messages each of them cost."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._losses: list[Loss] = []
        self._settled = 0
        self.in_gaps = 0
        """Messages that gaps in the numbering say are missing."""
        self.is_open = False
        """No message was read since the last loss that cost some."""

    def add(
        self, position: int, reason: str, messages: int | None, start: int | None = None, end: int | None = None
    ) -> None:
        """Note a loss at a `position` in the file [bytes], for a `reason` in words, of `messages`; None until their
        number is known.

        The time in which they lie is from `start` to `end` [ns], where it is known.
        """
        self._losses.append(Loss(self._path, position, reason, start, end, messages))
        self.is_open = self.is_open or messages != 0

    @property
    def is_empty(self) -> bool:
        """Return whether nothing was noted."""
        return not self._losses

    def end_at(self, time: int) -> None:
        """Say at what `time` messages went on [ns]: what was lost before lies before that."""
        for index in range(self._settled, len(self._losses)):
            loss = self._losses[index]
            if loss.messages != 0:
                end = time if loss.end is None else min(loss.end, time)
                self._losses[index] = replace(loss, end=max(end, loss.start or 0))
        self._settled = len(self._losses)
        self.is_open = False

    def set_count(self, messages: int) -> None:
        """Say how many messages the last loss cost."""
        self._losses[-1] = replace(self._losses[-1], messages=messages)

    def settle(self, total: int | None, *, is_cut: bool) -> list[Loss]:
        """Return the losses of the pass, of a file that lacks `total` messages, where that is known, and that `is_cut`:
        it does not end as it should.
        """
        if is_cut and self.is_open:
            behind = [replace(loss, end=None) if loss.messages != 0 else loss for loss in self._losses[self._settled :]]
            self._losses[self._settled :] = behind
        if total is not None:
            return self._adding_up_to(total, self._losses)
        before, behind = self._losses[: self._settled], self._losses[self._settled :]
        rest = self.in_gaps - sum(loss.messages or 0 for loss in before)
        if rest > 0:  # what came after the last message is unknown, and no gap shows it
            before = self._adding_up_to(self.in_gaps, before)
        return [*before, *behind]

    def _adding_up_to(self, total: int, losses: list[Loss]) -> list[Loss]:
        """Return the losses with numbers that add up to `total`; those that cannot be distinguished are merged."""
        unknown = [loss for loss in losses if loss.messages is None]
        rest = total - sum(loss.messages or 0 for loss in losses)
        if rest == 0 or (rest > 0 and len(unknown) == 1):
            return [replace(loss, messages=rest if loss.messages is None else loss.messages) for loss in losses]
        if rest > 0 and not unknown:
            return [*losses, Loss(self._path, None, MISSING, messages=rest)]
        together = unknown if rest > 0 else [loss for loss in losses if loss.messages != 0]
        apart = [loss for loss in losses if loss not in together]
        counted = total - sum(loss.messages or 0 for loss in apart)
        return sorted([*apart, _joined(together, counted)], key=lambda loss: loss.position or 0)


def _joined(losses: list[Loss], messages: int) -> Loss:
    """Return several losses as one."""
    first = losses[0]
    starts = [loss.start for loss in losses if loss.start is not None]
    ends = [loss.end for loss in losses if loss.end is not None]
    is_known = len(starts) == len(ends) == len(losses)
    reason = first.reason
    if len(losses) > 1:
        reason += f", and {len(losses) - 1} more places up to byte {losses[-1].position}; the first"
    start, end = (min(starts), max(ends)) if is_known else (None, None)
    return Loss(first.file, first.position, reason, start, end, max(messages, 0))


@dataclass(frozen=True)
class RecordedLoss:
    """Messages that a recorder should have written and did not."""

    reason: str  # in words
    messages: int  # how many
    start: int  # first log time [ns]
    end: int  # last log time [ns]

    def joined(self, other: RecordedLoss | None) -> RecordedLoss:
        """Return this loss and the `other` one as one."""
        if other is None:
            return self
        reasons = dict.fromkeys((*self.reason.split("; "), *other.reason.split("; ")))
        start, end = min(self.start, other.start), max(self.end, other.end)
        return RecordedLoss("; ".join(reasons), self.messages + other.messages, start, end)

    def to_custom_data(self) -> dict[str, str]:
        """Return the loss as custom data of a bag."""
        numbers = {_MESSAGES: self.messages, _FROM: self.start, _TO: self.end}
        return {_REASON: one_line(self.reason), **{name: str(number) for name, number in numbers.items()}}

    def to_loss(self, path: Path) -> Loss:
        """Return the loss as one of the bag at `path`."""
        return Loss(path, None, f"not recorded: {self.reason}", self.start, self.end, self.messages)


def recorded_loss(information: Mapping[str, Any]) -> RecordedLoss | None:
    """Return the loss that the `information` of a bag states; None where it states none that makes sense."""
    custom = information.get("custom_data")
    if not isinstance(custom, Mapping) or _REASON not in custom:
        return None
    numbers = []
    for name in (_MESSAGES, _FROM, _TO):
        with suppress(ValueError, TypeError, OverflowError):
            numbers.append(min(max(int(custom.get(name, 0)), 0), LATEST_TIME))
    if len(numbers) < 3:
        return None
    messages, start, end = numbers
    return RecordedLoss(one_line(str(custom[_REASON])[:LONGEST_REASON]), messages, start, max(start, end))
