"""What a device says, in SI units and in the suite's signs; and what is counted of its line.

Signs: heave and its derivatives positive up; roll positive starboard down, pitch positive bow down (REP-103, x forward,
y to port, z up); heading positive clockwise from north; payout positive lets cable out. A decoder turns the signs of
its format into these, and says by which published document it knows them.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, Protocol

from heave_node.interface.codes import MruStatus

DAY = 86_400.0
"""Length of a day [s]."""
_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)")


class TimeBase(Enum):
    """What a device's own time counts from."""

    NONE = "none"
    """The sample has no time: that of its arrival counts."""
    UNIX = "unix"
    """UTC, from 1970."""
    DAY = "day"
    """UTC, from midnight."""
    COUNTER = "counter"
    """A clock of its own, from its start."""


@dataclass(frozen=True)
class Sample:
    """One sentence, frame or message of a device."""

    kind: str  # name of the sentence or frame, such as PSXN23
    values: Mapping[str, float]  # finite numbers by quantity, SI units, the suite's signs
    # quantities that the device itself calls invalid; they are not among the values
    invalid: frozenset[str] = frozenset()
    status: MruStatus = MruStatus.OK  # whether the motion has settled, as the device says
    time: float | None = None  # of the device's own clock [s]; None: the sample has none
    time_base: TimeBase = TimeBase.NONE  # what that time counts from
    # fields that hold other text than a number, by name: what a validity may be read from
    words: Mapping[str, str] = field(default_factory=dict)


def sample_without(kind: str, values: Mapping[str, float], bad: frozenset[str], **rest: Any) -> Sample:
    """Return a sample of a `kind` with the `values` that are not `bad`, those that are as invalid, and the `rest`."""
    return Sample(
        kind, {name: value for name, value in values.items() if name not in bad}, bad & frozenset(values), **rest
    )


@dataclass
class Counters:
    """What came on a line, counted."""

    bytes: int = 0  # received
    samples: int = 0  # sentences or frames that were read
    checksum_errors: int = 0  # whose checksum does not fit, or is missing
    malformed: int = 0  # whose content is not as the format has it
    incomplete_lines: int = 0  # that were begun and not ended
    unknown: dict[str, int] = field(default_factory=dict)  # sentences that no table knows, by name
    lost: int = 0  # numbered datagrams that never came
    repeated: int = 0  # numbered datagrams that came twice
    late: int = 0  # numbered datagrams that came after a newer one

    def note_unknown(self, name: str) -> None:
        """Count a sentence `name` that no table knows; of more than 50 names the rest is one."""
        kept = name if name in self.unknown or len(self.unknown) < 50 else "others"
        self.unknown[kept] = self.unknown.get(kept, 0) + 1


class Decoder(Protocol):
    """Reads one format. What it returns depends on the bytes alone, not on how they are cut into pieces."""

    counters: Counters

    def feed(self, data: bytes) -> list[Sample]:
        """Return what is complete with the next bytes of a stream, `data`."""

    def end(self) -> list[Sample]:
        """Return what the end of a datagram or of a file completes; the rest is counted."""


def is_number(text: str) -> bool:
    """Return whether a `text` is a decimal number; nan and 1_000 are none."""
    return _NUMBER.fullmatch(text) is not None


def number(text: str) -> float:
    """Return the decimal number that `text` is; raise ValueError where it is none."""
    if not is_number(text):
        raise ValueError(f"{text[:20]!r} is no number")
    return float(text)


def time_of_day(text: str) -> float:
    """Return the seconds since midnight of a time hhmmss.sss; raise ValueError where `text` is none."""
    number(text)
    hours, minutes, seconds = int(text[0:2]), int(text[2:4]), float(text[4:])
    if hours > 23 or minutes > 59 or seconds >= 61.0:
        raise ValueError(f"{text[:20]!r} is no time of the day")
    return 3600.0 * hours + 60.0 * minutes + seconds
