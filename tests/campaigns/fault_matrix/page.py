"""The page of the matrix, made of its results: `python -m tests.campaigns.fault_matrix.page > docs/fault_matrix.md`.

Results stand in `docs/fault_matrix.json`, a table for each campaign: with `--results docs/fault_matrix.json` a campaign
adds one, or takes the place of that of the same commit and seed.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.campaigns.fault_matrix.cases import Cell
from tests.campaigns.fault_matrix.figures import BARS, COLUMNS, GROUPS, Ran, breaches, cells_of, kept, worst
from tests.campaigns.fault_matrix.judge import ENVELOPE, LARGEST_UNIT, MARGIN
from tests.campaigns.fault_matrix.run import Outcome

ROOT = Path(__file__).parents[3]
RESULTS = ROOT / "docs" / "fault_matrix.json"

NUMBERS = ("named", "rest", "travel", "envelope", "unit", "tension", "slack", "rate")
"""Figures of a case in its row, after the values of `GROUPS`."""

LATER = ("stopped", "without", "past_brake")
"""Figures at the end of a row, of which older results have the first or none."""

HEAD = f"""# Every fault in every mode

How drum, load (*unit*) and alarms react to every kind of fault of every device, in every phase of a lift, with all
values as assumed or with one that differs. Generated from `docs/fault_matrix.json` by
`python -m tests.campaigns.fault_matrix.page > docs/fault_matrix.md`.

| term | meaning |
| --- | --- |
| envelope | drum speed up to {ENVELOPE.rate_factor:g} times the boom tip's in a minute |
| | + {ENVELOPE.rate_margin:g} m/s, travel {ENVELOPE.travel_factor:g} times its heave + {ENVELOPE.travel_margin:g} m; |
| | in the first minute, at a start, in a move [as much more as it allows](guide/controller/envelope.md#bounds) |
| travel | drum travel from fault to rest, beyond the requested move: |
| | at most the heave of the last minute + {MARGIN:g} m |
| unit | load motion from 10 s after the fault on: at most {LARGEST_UNIT:g} times that with the winch locked |
| travel, otherwise | at most as far as in the same run without the fault, if both end at rest or neither does |
| unit, otherwise | at most {LARGEST_UNIT:g} times the same run without the fault, stopped at once where the drum was |
| named | an alarm names the faulty part (of faults that have an effect) |
| not blamed | no alarm names a healthy part |
| past the brake | drum travel under an ordered brake that does not hold: left out of the three above where no command |
| | acts on it, after an emergency stop and with a drive that reports a fault |
| alarm, rest | time from the fault: median, largest |
| largest | travel as a multiple of its limit / load motion as a multiple of that with the winch locked |

Load motion is the standard deviation of heave over each minute from 10 s after the fault on. It is divided by that of
the same load in the same sea with the winch locked, which is simulated alongside; the largest ratio counts. A drum that
stops at once lets the load swing for minutes, whatever stopped it. Where the ratio exceeds {LARGEST_UNIT:g}, the run is
repeated from the same state without the fault, with an emergency stop at the moment when the fault stopped the drum, if
it did. The fault may then add at most {100.0 * (LARGEST_UNIT - 1.0):g} %.

A fault without effect (a reversed drive while the brake holds) need not be named. Faults of network, PLC and recorder
are not included, because they need more than one process.
"""


@dataclass(frozen=True)
class Shown:
    """A case as its row has it, laid out like one that has just been run."""

    groups: Mapping[str, str]  # its values of `GROUPS`
    words: str  # the case, in words, where it broke a bar


def row_of(one: Cell, found: Outcome) -> list[Any]:
    """Return a case as a row of the results; numbers to six digits, what is infinite or none as null."""
    numbers = [_number(getattr(found, name)) for name in NUMBERS]
    words = one.words if breaches(found) else ""
    return [
        *(group(one) for group in GROUPS.values()),
        *numbers,
        found.is_visible,
        list(found.wrong),
        list(found.alarms[:6]),
        words,
        found.failure,
        *(_number(getattr(found, name)) for name in LATER),
    ]


def _number(value: float) -> float | str | None:
    if math.isnan(value):
        return None
    return "inf" if math.isinf(value) else float(f"{value:.6g}")


def shown_of(row: Sequence[Any]) -> tuple[Shown, Outcome]:
    """Return a case of a row of the results."""
    names = dict(zip(GROUPS, row, strict=False))
    numbers: dict[str, Any] = {
        name: float("nan" if value is None else value) for name, value in zip(NUMBERS, row[len(GROUPS) :], strict=False)
    }
    visible, wrong, alarms, words, failure, *others = row[len(GROUPS) + len(NUMBERS) :]
    numbers |= {name: float(value or 0.0) for name, value in zip(LATER, others, strict=False)}
    found = Outcome(**numbers, is_visible=visible, wrong=tuple(wrong), alarms=tuple(alarms), failure=failure)
    return Shown(names, words), found


def add(path: Path, heading: Mapping[str, Any], ran: Sequence[Ran]) -> None:
    """Add the results of a campaign to those at a `path`, or take the place of those of its commit and seed."""
    others = json.loads(path.read_text(encoding="utf-8")) if path.exists() else []
    key = {name: heading[name] for name in ("commit", "seed")}
    how = " ".join(f"--{name} {heading[name]:.10g}" for name in ("seed", "branches", "after"))
    command = f"python -m tests.campaigns.fault_matrix --cases {len(ran)} {how}"
    rows = [row_of(*one) for one in ran]
    columns = [*GROUPS, *NUMBERS, "shows", "blamed", "alarms", "case", "failure", *LATER]
    new = {**key, "command": command, "columns": columns}
    kept_ones = [one for one in others if {name: one[name] for name in key} != key]
    lines = [
        json.dumps(one | {"rows": 0}).replace(
            '"rows": 0', '"rows": [\n' + ",\n".join(map(json.dumps, one["rows"])) + "]"
        )
        for one in [*kept_ones, new | {"rows": rows}]
    ]
    path.write_text("[\n" + ",\n".join(lines) + "\n]\n", encoding="utf-8")


def page(campaigns: Sequence[Mapping[str, Any]]) -> str:
    """Return the page as Markdown; the newest commit in full, those before by their bars."""
    newest = [one for one in campaigns if one["commit"] == campaigns[-1]["commit"]]
    shown = [shown_of(row) for one in newest for row in one["rows"]]
    lines = [HEAD, "## Bars", ""]
    lines += _table(
        ["commit", "seed", "cases", *(f"{bar.name} ({100 * bar.share:g} %)" for bar in BARS)], map(_bars, campaigns)
    )
    lines += ["", *(f"`{one['command']}`\n" for one in newest), *_set_apart([found for _, found in shown])]
    for group in GROUPS:
        values = sorted({one.groups[group] for one, _ in shown})
        rows = [[value, *cells_of([case for case in shown if case[0].groups[group] == value])] for value in values]
        lines += [f"## By {group}", "", *_table([group, *COLUMNS], rows), ""]
    lines += ["## The worst", ""]
    for one, found in worst(shown):
        lines += [f"- {one.words}: **{'; '.join(breaches(found))}**. {', '.join(found.alarms) or 'No alarm'}"]
    return "\n".join([*lines, ""])


def _set_apart(found: Sequence[Outcome]) -> list[str]:
    """Return how many cases are held against a run without the fault, and how many drums ran past the brake."""
    unit, ways = BARS[2], [one.past_brake for one in found if one.past_brake > MARGIN]
    as_stopped = sum(one.unit > LARGEST_UNIT and unit.holds(one) for one in found)
    words = [f"Load motion above {LARGEST_UNIT:g}, held against the run without the fault: {as_stopped} cases.\n"]
    if ways:
        furthest = f"more than {MARGIN:g} m, the furthest {max(ways):.1f} m"
        words.append(f"Past the brake: {len(ways)} of {len(found)} drums ran {furthest}.\n")
    return words


def _bars(campaign: Mapping[str, Any]) -> list[str]:
    shown = [shown_of(row) for row in campaign["rows"]]
    shares = [
        f"{good} of {asked}, {100.0 * good / asked:.1f} %" if asked else "-"
        for good, asked in (kept(bar, shown) for bar in BARS)
    ]
    return [campaign["commit"][:10], str(campaign["seed"]), str(len(shown)), *shares]


def _table(head: Sequence[str], rows: Any) -> list[str]:
    return [f"|{'|'.join(row)}|" for row in [head, ["---"] * len(head), *rows]]


if __name__ == "__main__":
    sys.stdout.write(page(json.loads(RESULTS.read_text(encoding="utf-8"))))
