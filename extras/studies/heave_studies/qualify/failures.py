"""The chapter of failure tests: hazard, fault and mode, what is expected, what was seen, and after what time."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterator, Sequence
from typing import Any

from heave_bringup.pages.hazards import HAZARDS, all_cases, cases_of, modes_after

MOST_SEEN = 2
"""Alarms that a row names: those seen in most of its cases."""
OTHERS = {
    "name": "Faults of commands, adviser, clocks and nodes",
    "expected": "the envelope bounds the drum; the faulty part is named. See the hazards of adviser, clock and command",
    "time": "",
    "residual": "",
}
"""Chapter of the cases whose fault is no cause of a hazard in the simulated devices."""


def chapters() -> list[dict[str, Any]]:
    """Return the hazards in their order, each with name, expected reaction, time, residual risk, and rows.

    Of a row: fault, mode or phase, number of cases, alarms, times to the alarm and to rest, cases within all bars.
    """
    found, rest = [], all_cases()
    for one in HAZARDS:
        modes = [f"{event}: mode {into}" for event, into in modes_after(one).items()]
        words = {"name": one.name, "time": one.time, "residual": one.residual}
        cases = cases_of(one)
        found.append({**words, "expected": "; ".join([one.reaction, *modes]), "rows": list(_rows(cases))})
        rest = [case for case in rest if case not in cases]
    return [*found, {**OTHERS, "rows": list(_rows(rest))}]


def _rows(cases: Sequence[dict[str, Any]]) -> Iterator[list[str]]:
    for fault, mode in sorted({(case["fault"], case["moment"]) for case in cases}):
        of = [case for case in cases if (case["fault"], case["moment"]) == (fault, mode)]
        alarms = [alarm.partition(" ")[2].partition(":")[0] for case in of for alarm in dict.fromkeys(case["alarms"])]
        alarms = [alarm for alarm in alarms if alarm != "MODE_CHANGED"]  # which every reaction has
        seen = sorted(set(alarms), key=lambda alarm: (-alarms.count(alarm), alarms.index(alarm)))[:MOST_SEEN]
        effect = [case for case in of if case["shows"]]
        words = "; ".join(seen) or ("no alarm" if effect else "no effect, no alarm")
        kept = sum(not case["case"] and not case["failure"] for case in of)
        times = [_times([case["named"] for case in effect], "never"), _times([case["rest"] for case in of], "goes on")]
        yield [fault, mode, str(len(of)), words, *times, f"{kept} of {len(of)}"]


def _times(given: Sequence[Any], none: str) -> str:
    """Return median and largest of the times `given` [s]; `none` where all are infinite."""
    times = [float(time) for time in given if time is not None]
    finite = [time for time in times if math.isfinite(time)]
    if not times:
        return "-"
    return f"{statistics.median(finite):.2g}, {max(finite):.3g} s" if finite else none
