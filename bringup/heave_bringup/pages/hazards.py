"""The page of hazards, `docs/hazards.md`: `python -m heave_bringup.pages.hazards > docs/hazards.md`."""

from __future__ import annotations

import json
import math
import statistics
import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

from heave_node.interface.fault_kinds import FAULTS, faults_of
from winch_controller_node.core.supervision.modes import TABLE, Event

from heave_bringup.pages.hazard_table import HAZARDS, Hazard

DEVICES = ("winch", "encoder", "mru", "sensor")
"""Kinds of device that have faults; `sensor`: depth, load cell and the others on unit and cable."""


MATRIX = Path(__file__).parents[3] / "docs" / "fault_matrix.json"
"""Results of the matrix of faults, of which its page is made as well: `docs/fault_matrix.md`."""

SENSORS = ("depth", "load_cell")
"""Devices of the matrix that are of the kind `sensor`."""


HEAD = """# Hazards

What can go wrong with a heave compensator, how the suite detects it, what it does, how soon, and what remains. This
page is written by `python -m heave_bringup.pages.hazards` from the tables of faults, alarms and modes, and names the
tests that show each row. Measured times are those of the [matrix of faults](fault_matrix.md): median, largest.

Words are those of ISO 12100 (hazardous event, protective measure, residual risk) and IEC 61508 (detection, reaction,
safe state). **No conformity is claimed**: the controller is no safety function, and has no performance level (ISO
13849) or safety integrity level. What protects people is the ship's own: brakes, emergency stop, limits of the crane.
Begin a risk assessment of your own with this page.

The safe state is the drum at rest, braked. With a load in the splash zone or on the bottom it may not be safe: say so
in the plan of the lift.
"""


def page() -> str:
    """Return the page as Markdown."""
    return "\n".join([HEAD, *(_section(number, one) for number, one in enumerate(HAZARDS, 1)), _coverage()])


def _section(number: int, one: Hazard) -> str:
    kinds = [f"{device}: `{kind}`, {FAULTS[kind].of(device)}" for device, kinds in one.causes.items() for kind in kinds]
    modes = [
        f"{event.value}: {', '.join(sources)} to {target}"
        for event in one.events
        for target, sources in _changes(event).items()
    ]
    rows = [
        ("cause", "; ".join([*kinds, *([one.others] if one.others else [])]) or "see detection"),
        ("detection", ", ".join(f"`{code}`" for code in one.alarms)),
        ("reaction", "; ".join([one.reaction, *modes])),
        ("time", one.time),
        *([("measured", measured)] if (measured := _measured(one)) else []),
        ("residual risk", one.residual),
        ("test", ", ".join(f"`{test}`" for test in one.tests)),
    ]
    lines = [f"| {name} | {words.replace('|', '/')} |" for name, words in rows]
    return "\n".join([f"## {number}. {one.name}", "", "| | |", "| --- | --- |", *lines, ""])


def _measured(one: Hazard) -> str:
    """Return how soon the faults that cause a hazard were named, and the drum came to rest; empty: none was run."""
    sensors = tuple(name for name in SENSORS if any(code.startswith(name.upper()) for code in one.alarms))
    devices = {device: sensors if device == "sensor" else (device,) for device in one.causes}
    faults = {f"{name} {kind}" for device, kinds in one.causes.items() for name in devices[device] for kind in kinds}
    shown = [case for case in _cases() if case["fault"] in faults and case["shows"]]
    if not shown:
        return ""
    named, rest = ([float(case[name]) for case in shown] for name in ("named", "rest"))
    never, moving = (sum(map(math.isinf, values)) for values in (named, rest))
    cases = f"{len(shown)} case" + ("s" if len(shown) > 1 else "")
    not_named, goes_on = f", in {never} not" if never else "", f", in {moving} it moves on" if moving else ""
    return f"{cases}; named after {_times(named)}{not_named}; drum at rest after {_times(rest)}{goes_on}"


def _times(values: Sequence[float]) -> str:
    finite = [value for value in values if math.isfinite(value)]
    return f"{statistics.median(finite):.2g} s, {max(finite):.2g} s" if finite else "-"


@cache
def _cases() -> list[dict[str, Any]]:
    """Return the cases of the matrix, of the newest commit in it, by its columns."""
    campaigns = json.loads(MATRIX.read_text(encoding="utf-8"))
    newest = [one for one in campaigns if one["commit"] == campaigns[-1]["commit"]]
    return [dict(zip(one["columns"], row, strict=True)) for one in newest for row in one["rows"]]


def _changes(event: Event) -> dict[str, list[str]]:
    """Return the modes that an event changes, by the mode that it changes them to."""
    found: dict[str, list[str]] = {}
    for row in TABLE:
        if row.event is event:
            of = found.setdefault(row.target.value, [])
            of += [mode.value for mode in row.sources if mode is not row.target and mode.value not in of]
    return {target: sources for target, sources in found.items() if sources}


def _coverage() -> str:
    """Return which hazards each fault of each kind of device is a cause of."""
    lines = [
        "## Every fault",
        "",
        "| fault | winch | encoder | MRU | other sensors |",
        "| --- | --- | --- | --- | --- |",
    ]
    for kind in FAULTS:
        if kind == "clear":
            continue
        cells = [
            ", ".join(map(str, hazards_of(device, kind))) if kind in faults_of(device) else "" for device in DEVICES
        ]
        lines.append(f"| `{kind}` | {' | '.join(cells)} |")
    return "\n".join(
        [*lines, "", "Numbers are those of the hazards above; an empty cell: the device cannot have it.", ""]
    )


def hazards_of(device: str, kind: str) -> list[int]:
    """Return the numbers of the hazards that a `kind` of fault of a kind of `device` causes."""
    return [number for number, one in enumerate(HAZARDS, 1) if kind in one.causes.get(device, ())]


if __name__ == "__main__":
    sys.stdout.write(page())
