"""The page of hazards, `docs/hazards.md`: `python -m heave_bringup.pages.hazards > docs/hazards.md`."""

from __future__ import annotations

import sys

from heave_node.interface.fault_kinds import FAULTS, faults_of
from winch_controller_node.core.supervision.modes import TABLE, Event

from heave_bringup.pages.hazard_table import HAZARDS, Hazard

DEVICES = ("winch", "encoder", "mru", "sensor")
"""Kinds of device that have faults; `sensor`: depth, load cell and the others on unit and cable."""


HEAD = """# Hazards

What can go wrong with a heave compensator, how the suite detects it, what it does, how soon, and what remains. This
page is written by `python -m heave_bringup.pages.hazards` from the tables of faults, alarms and modes, and names the
tests that show each row.

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
        ("residual risk", one.residual),
        ("test", ", ".join(f"`{test}`" for test in one.tests)),
    ]
    lines = [f"| {name} | {words.replace('|', '/')} |" for name, words in rows]
    return "\n".join([f"## {number}. {one.name}", "", "| | |", "| --- | --- |", *lines, ""])


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
