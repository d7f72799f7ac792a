"""What a run, or equal runs with other seeds, let one expect of the largest motions and tensions in a longer time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np
from heave_bags.analyse.kpis.definition import QUANTITIES
from heave_bags.analyse.run_record import RunRecord
from heave_bags.signals import Signal
from heave_node.numerics.arrays import Array

from heave_studies.extremes.largest import (
    FEWEST,
    Estimate,
    block_maxima,
    cycle_maxima,
    from_blocks,
    from_peaks,
    most_probable_by_blocks,
    peaks_over_threshold,
)


@dataclass(frozen=True)
class Expected:
    """What is to be expected of a quantity."""

    name: str  # of the quantity
    unit: str  # of the quantity; SI
    mean: float  # about which it deviates, SI
    sign: float  # -1 where the smallest value is meant [-]
    seen: float  # the extreme of the records, in its unit, SI
    estimates: tuple[Estimate, ...]  # of its deviation from the mean, one for each method
    # smallest and largest of the most probable deviations when any one seed is left out; None of one run
    without_a_seed: tuple[float, float] | None = None

    def value(self, deviation: float) -> float:
        """Return the value at a `deviation` from the mean, both in the unit; a cable cannot push."""
        value = self.mean + self.sign * deviation
        return max(value, 0.0) if self.sign < 0.0 else value

    def shown(self, deviation: float) -> str:
        """Return the value at a `deviation` in the unit that people are shown."""
        return self.text(self.value(deviation))

    def text(self, value: float) -> str:
        """Return a `value` of the quantity in the unit that people are shown."""
        return f"{QUANTITIES[self.unit][1] * value:.2f}"

    @property
    def heading(self) -> str:
        """The name with the unit that people are shown."""
        return f"{self.name} [{QUANTITIES[self.unit][0]}]"

    def to_json(self) -> dict[str, object]:
        """Return it as plain data, SI units."""
        methods = []
        for estimate in self.estimates:
            plain = asdict(estimate)
            for key in ("most_probable", "p90"):
                plain[key] = self.value(plain[key])
                plain[f"{key}_range"] = sorted(self.value(end) for end in plain[f"{key}_range"])
            methods.append(plain)
        without = None if self.without_a_seed is None else sorted(map(self.value, self.without_a_seed))
        return {"name": self.name, "unit": self.unit, "seen": self.seen, "methods": methods, "without_a_seed": without}


def expected_of_run(record: RunRecord, duration: float) -> list[Expected]:
    """Return what is to be expected of a longer run in the same sea, by both methods.

    Parameters
    ----------
    record : of a run; its transient does not count
    duration : of the longer one [s]
    """
    signals = record.signals
    quantities = (
        ("load heave about its mean", "m", signals.unit_heave, 0.0),
        ("uncompensated heave about its mean", "m", signals.uncompensated_heave, 0.0),
        ("top tension, largest", "N", signals.tension, 1.0),
        ("top tension, smallest", "N", signals.tension, -1.0),
    )
    return [
        _of_signal(name, unit, signal.window(record.start, record.end), sign, duration)
        for name, unit, signal, sign in quantities
        if signal.window(record.start, record.end).size > 1
    ]


def _of_signal(name: str, unit: str, part: Signal, sign: float, duration: float) -> Expected:
    """Return it for one signal; `sign` 0: deviations to either side count."""
    mean = float(part.value.mean())
    about = part.value - mean
    sides = (1.0, -1.0) if sign == 0.0 else (sign,)
    recorded = float(part.time[-1] - part.time[0])
    crests = [cycle_maxima(side * about) for side in sides]
    cycles = len(crests[0])
    blocks = [block_maxima(side * about, cycles) for side in sides]
    largest = np.max(blocks, axis=0)
    peaks = peaks_over_threshold(np.concatenate(crests), recorded)
    found = [from_blocks(np.maximum(largest, 0.0), recorded / max(largest.size, 1), duration)]
    found.append(from_peaks(peaks, duration))
    seen = float(np.max([np.max(side * about) for side in sides]))
    centre = 0.0 if sign == 0.0 else mean
    estimates = tuple(one for one in found if one is not None)
    return Expected(name, unit, centre, sign or 1.0, centre + (sign or 1.0) * seen, estimates)


def expected_of_seeds(
    maxima: Mapping[str, tuple[str, Array, Array, float]], record: float, duration: float
) -> list[Expected]:
    """Return what is to be expected by runs that differ in their seed only.

    Parameters
    ----------
    maxima : by name: unit, mean and largest deviation of each run, and the sign that `Expected` has
    record : length of each [s]
    duration : of the time that is asked for [s]
    """
    found = []
    for name, (unit, means, deviations, sign) in maxima.items():
        estimate = from_blocks(deviations, record, duration)
        if estimate is None:
            continue
        mean = float(np.mean(means))
        seen = mean + sign * float(np.max(deviations))
        left_out = _without_each(deviations, record, duration)
        found.append(Expected(name, unit, mean, sign, seen, (estimate,), left_out))
    return found


def _without_each(deviations: Array, record: float, duration: float) -> tuple[float, float] | None:
    """Return the smallest and the largest of the most probable values without each one of the runs."""
    if deviations.size <= FEWEST:
        return None
    rest = [np.delete(deviations, index) for index in range(deviations.size)]
    values = [most_probable_by_blocks(part, record, duration) for part in rest]
    return min(values), max(values)


def table_rows(expected: Sequence[Expected]) -> list[list[str]]:
    """Return a row of cells for each quantity and method.

    Parameters
    ----------
    expected : the quantities
    """
    rows = []
    for one in expected:
        for number, estimate in enumerate(one.estimates):
            head = [one.heading, one.text(one.seen)] if number == 0 else ["", ""]
            cells = [one.shown(estimate.most_probable), _range(one, estimate.most_probable_range)]
            cells += [one.shown(estimate.p90), _range(one, estimate.p90_range)]
            without = "-" if one.without_a_seed is None else _range(one, one.without_a_seed)
            rows.append([*head, *cells, f"{estimate.method}, {estimate.sample}", without])
    return rows


def _range(one: Expected, ends: tuple[float, float]) -> str:
    low, high = sorted(one.value(end) for end in ends)
    return f"{one.text(low)} to {one.text(high)}"


COLUMNS = (
    "in the same sea",
    "seen",
    "most probable",
    "90 % sure",
    "1 in 10 above",
    "90 % sure ",
    "by",
    "without a seed",
)
"""Headings of `table_rows`."""


def warnings_of(expected: Sequence[Expected]) -> list[str]:
    """Return why to take what is `expected` with caution, each reason once; of small samples the smallest."""
    every = sorted((found for one in expected for found in one.estimates), key=lambda found: found.sample)
    kinds = {words.partition(":")[2]: words for found in reversed(every) for words in found.warnings}
    return list(kinds.values())
