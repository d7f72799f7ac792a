"""What the nodes of a run reported last of all of it: durations in wall time, late commands, the cable's strain."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from heave_node.interface import topics
from heave_node.interface.codes import COMMANDS, LATE
from heave_node.tick.durations import parse_histogram

from heave_bags.analyse.reading.stored import as_number
from heave_bags.mcap.reader import Bag

LAST_WORDS = 5_000_000_000
"""Time before the end of a bag within which every node publishes diagnostics [ns]."""
STRAIN_KEY = "largest strain"
"""Name of the plant's figure in its diagnostics."""
TIMING_PREFIX = "timing "
"""Begins the name of a diagnostic status with a histogram of durations in wall time."""


@dataclass
class LastWords:
    """What the diagnostics at the end of a bag say of the whole run."""

    # histograms of durations in wall time by name: upper edge [ms] -> count
    timings: dict[str, dict[str, int]] = field(default_factory=dict)
    late_commands: float = math.nan  # number of them [-]; NaN: not reported
    largest_strain: float = math.nan  # of the cable [-]; NaN: not reported


def last_words(bag: Bag, *, is_paced: bool) -> LastWords:
    """Return what the nodes of a `bag` published last; durations and late commands if the run `is_paced`."""
    found = LastWords()
    for _, message in bag.decoded([topics.DIAGNOSTICS.name], start=bag.end_time - LAST_WORDS):
        for title, values in _statuses(message):
            node, _, name = title.partition(": ")
            if is_paced and name.startswith(TIMING_PREFIX) and "histogram_ms" in values:
                found.timings[f"{node}: {name.removeprefix(TIMING_PREFIX)}"] = parse_histogram(values["histogram_ms"])
            if is_paced and name == COMMANDS:
                found.late_commands = as_number(values.get(LATE))
            found.largest_strain = as_number(values.get(STRAIN_KEY, found.largest_strain))
    return found


def _statuses(message: Any) -> list[tuple[str, dict[str, Any]]]:
    """Return name and values of each status of a diagnostic message; none of one whose definition is another."""
    try:
        return [(str(part.name), {value.key: value.value for value in part.values}) for part in message.status]
    except (AttributeError, TypeError):
        return []
