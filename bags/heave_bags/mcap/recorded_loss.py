"""What a recorder knows that its bag lacks: written into `metadata.yaml` as the recorder's own data, and read again."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from heave_bags.errors import one_line
from heave_bags.mcap.bounds import LATEST_TIME
from heave_bags.mcap.loss import Loss

_REASON, _MESSAGES, _FROM, _TO = (f"heave_lost_{name}" for name in ("reason", "messages", "from_ns", "to_ns"))
LONGEST_REASON = 500
"""Characters of a reason that are read."""


@dataclass(frozen=True)
class RecordedLoss:
    """Messages that a recorder should have written and did not.

    Attributes
    ----------
    reason : in words
    messages : how many
    start, end : log times between which they lie [ns]
    """

    reason: str
    messages: int
    start: int
    end: int

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
