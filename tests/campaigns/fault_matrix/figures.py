"""What all cases came to: shares against the bars, by fault, moment and scenario, and the worst with their reasons."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from tests.campaigns.fault_matrix.cases import Cell
from tests.campaigns.fault_matrix.judge import LARGEST_UNIT
from tests.campaigns.fault_matrix.run import Outcome

Ran = tuple[Cell, Outcome]
Case = TypeVar("Case")

NEAR = 1.02
"""Times the bounds of the envelope that count as within: the MRU by which it goes has noise, the boom tip here none."""

SAME = 0.001
"""Difference of travel over its limit between two runs whose drum goes the same way: they differ in readings."""


@dataclass(frozen=True)
class Bar:
    """A line of the promise."""

    name: str  # what is asked
    counts: Callable[[Outcome], bool]  # whether a case is asked
    holds: Callable[[Outcome], bool]  # whether it keeps it
    share: float  # of the cases that are asked which have to


BARS = (
    Bar("drum within the envelope", lambda _: True, lambda one: one.envelope <= NEAR, 1.0),
    Bar(
        "travel within the heave of the minute + 0.3 m",
        lambda _: True,
        lambda one: one.travel <= max(1.0, one.without + SAME),
        0.999,
    ),
    Bar(
        f"unit at most {LARGEST_UNIT:g} times the locked one",
        lambda one: math.isfinite(one.unit),
        lambda one: one.unit <= LARGEST_UNIT * max(1.0, one.stopped),
        0.99,
    ),
    Bar(
        "part at fault named",
        lambda one: one.is_visible is True,
        lambda one: math.isfinite(one.named),
        0.97,
    ),
    Bar("no healthy part blamed", lambda _: True, lambda one: not one.wrong, 0.99),
)
"""The promise."""


def kept(bar: Bar, ran: Iterable[tuple[Any, Outcome]]) -> tuple[int, int]:
    """Return how many cases keep a `bar`, of how many that are asked."""
    asked = [found for _, found in ran if not found.failure and bar.counts(found)]
    return sum(map(bar.holds, asked)), len(asked)


def breaches(found: Outcome) -> list[str]:
    """Return the bars that a case does not keep, with its figures, in words."""
    if found.failure:
        return [found.failure]
    values = {
        0: f"envelope {found.envelope:.2f}",
        1: f"travel {found.travel:.2f}",
        2: f"unit {found.unit:.2f}",
        3: "not named",
        4: f"blames {', '.join(found.wrong)}",
    }
    return [values[place] for place, bar in enumerate(BARS) if bar.counts(found) and not bar.holds(found)]


def badness(found: Outcome) -> float:
    """Return by how much a case is beyond the bars of drum and unit; a name that is missing or false counts little."""
    unit = found.unit / (LARGEST_UNIT * max(1.0, found.stopped)) if math.isfinite(found.unit) else 0.0
    names = 0.5 * (found.is_visible is True and math.isinf(found.named)) + 0.3 * bool(found.wrong)
    return max(found.envelope, found.travel, unit) + 0.01 * names if not found.failure else 0.0


def broken(ran: Sequence[Ran]) -> list[str]:
    """Return the bars that are not kept by so many as promised, in words."""
    words = []
    for bar in BARS:
        good, asked = kept(bar, ran)
        if asked and good < bar.share * asked:
            words.append(f"{bar.name}: {good} of {asked}, promised {100 * bar.share:g} %")
    return words


GROUPS: dict[str, Callable[[Cell], str]] = {
    "fault": lambda one: one.fault.name,
    "moment": lambda one: one.base.moment,
    "scenario": lambda one: one.base.case.scenario,
    "law": lambda one: one.base.case.law,
    "belief": lambda one: "off" if one.base.case.deviations else "nominal",
}
"""By what the matrix is laid out."""


def rows_by(group: str, ran: Sequence[Ran]) -> list[list[str]]:
    """Return a row for each value of a `group`: cases, shares that keep each bar, times to alarm and rest, largest."""
    of: dict[str, list[Ran]] = {}
    for one in ran:
        of.setdefault(GROUPS[group](one[0]), []).append(one)
    return [[name, *cells_of(of[name])] for name in sorted(of)]


COLUMNS = ("cases", "envelope", "travel", "unit", "named", "not blamed", "alarm, s", "rest, s", "largest")
"""Columns of a table of the matrix, after the first."""


def cells_of(ran: Sequence[Any]) -> list[str]:
    """Return what cases came to, each with its outcome, by `COLUMNS`."""
    sound = [found for _, found in ran if not found.failure]
    shares = [f"{good}/{asked}" if asked else "" for good, asked in (kept(bar, ran) for bar in BARS)]
    largest = [_largest(found.travel for found in sound), _largest(found.unit for found in sound)]
    times = [times_of([found.named for found in sound]), times_of([found.rest for found in sound])]
    return [str(len(sound)), *shares, *times, " / ".join(largest)]


def _largest(values: Iterable[float]) -> str:
    finite = [value for value in values if math.isfinite(value)]
    return f"{max(finite):.2f}" if finite else "-"


def times_of(times: Sequence[float]) -> str:
    """Return median and largest of the finite `times` [s], in words."""
    finite = [time for time in times if math.isfinite(time)]
    return f"{np.median(finite):.2g}, {max(finite):.3g}" if finite else "-"


def worst(ran: Sequence[tuple[Case, Outcome]], count: int = 10) -> list[tuple[Case, Outcome]]:
    """Return the `count` cases that are furthest beyond the bars, the worst first."""
    return sorted((one for one in ran if breaches(one[1])), key=lambda one: -badness(one[1]))[:count]


def line(one: Cell, found: Outcome) -> str:
    """Return a case and what it came to in two lines."""
    if found.failure:
        return f"{one.words}\n      FAILED: {found.failure}"
    named = f"{found.named:.2f} s" if math.isfinite(found.named) else "never"
    rest = f"{found.rest:.1f} s" if math.isfinite(found.rest) else "goes on"
    bad = "; ".join(breaches(found))
    return (
        f"{one.words}\n      named {named}{'' if found.is_visible else ' (does not show)'}, rest {rest}, travel "
        f"{found.travel:.2f}, envelope {found.envelope:.2f}, unit {found.unit:.2f}, tension {found.tension:.2f}, "
        f"slack {found.slack:.2f}, rate {found.rate:.2f} m/s{f'  BROKEN: {bad}' if bad else ''}"
    )
