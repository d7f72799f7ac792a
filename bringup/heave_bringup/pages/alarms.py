"""Every alarm of every node, from the tables that the nodes raise them from: `docs/alarms.md`.

The page is written by `python -m heave_bringup.pages.alarms > docs/alarms.md`; a test holds the two together.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Mapping

from cable_sim_node.alarms import ALARMS as PLANT
from heave_bags.record.alarms import ALARMS as RECORDER
from heave_node.extras import extra_parts
from heave_node.interface.alarm import NODE_ALARMS, AlarmRow, AlarmTable
from wave_vessel_node.alarms import ALARMS as VESSEL
from winch_controller_node.core.estimation.sense_design import BACK_TIME
from winch_controller_node.core.supervision.modes import WAIT
from winch_controller_node.core.supervision.supervision_design import BLIND_LIMIT
from winch_controller_node.interface.alarms import ALARMS as CONTROLLER
from winch_controller_node.node_parameters import MOTION_SOURCES
from winch_controller_node.parameters.laws import GuardParameters, ModeParameters

TABLES: dict[str, AlarmTable] = {
    "Controller and adviser": CONTROLLER,
    "In front of the controller": AlarmTable(
        {code: row for part in extra_parts(MOTION_SOURCES).values() for code, row in part.load().alarms.items()}
    ),
    "Cable, unit and virtual winch": PLANT,
    "Sea and vessel": VESSEL,
    "Recorder": RECORDER,
    "Every node": NODE_ALARMS,
}
"""The table of each package, under its heading."""

LOST = "*lost*"
"""What stands for severity and consequence of a lost sensor, which one table has."""
PLACES = {
    "mru": "motion sensor of the ship",
    "encoder": "count of the drum",
    "depth": "pressure sensor on the load",
    "load_cell": "hook load, at the boom tip",
    "velocity": "DVL on the load",
    "imu": "IMU on the load",
}
"""What each sensor is."""
OF_LOSS = {
    f"{part.upper()}_{kind}"
    for part in PLACES
    for kind in ("STALE", "LATE", "ABSENT", "NOT_A_NUMBER", "BAD_STAMP", "OUT_OF_ORDER", "FROZEN", "SPIKES", "JUMPS")
}
"""Codes by which a sensor is lost, and of which the file has one row for all sensors."""

GUARD, TIMES = GuardParameters(), ModeParameters()
EXAMPLE = str(CONTROLLER.alarm("MRU_STALE", age=0.31, limit=0.15))

RETURNS = (
    ("reason", "does it come back", "what you do"),
    ("---",) * 3,
    (
        'a sensor is lost: "mru frozen"',
        f"automatically: after {BACK_TIME:g} s of good readings while the gain still falls; after `modes.resume_time` "
        f"({TIMES.resume_time:g} s) of good readings once the winch has stopped, unless `modes.resume` is off",
        "restore the sensor",
    ),
    (
        '"encoder frozen"',
        "automatically, after the same times, once the count changes, or on request",
        "check that the drum turns; restart the encoder, then request compensation",
    ),
    (
        "harm: `WORSE_THAN_OFF`, `LITTLE_GAIN`, `UNIT_HEAVE_HIGH`, `UNIT_SWING_HIGH`, `DRUM_SPEED_OFF`",
        "automatically: once the load has settled, with the gain predicted to leave the least motion. Each failed "
        f"attempt lowers the gain; no attempt is made if more than {100.0 * GUARD.harm_ratio:.0f} % "
        "(`guard.harm_ratio`) of the winch-locked motion would remain",
        "nothing at first; if it fails again, follow the alarm",
    ),
    (
        "`DEPTH_MRU_DISAGREE`",
        "automatically: once the two agree, as above",
        "check sign and scale of both",
    ),
    (
        "`COMMANDS_CUT`, `COMMANDS_TOO_LATE`",
        "automatically: once commands arrive in time again and the load has settled",
        "check the link, the network and the CPU load of the computer",
    ),
    (
        "winch fault: command timeout",
        f"automatically: {WAIT:g} s after the winch accepts commands again, up to three times within a few waves",
        "check the link and the CPU load; after `COMMAND_TIMEOUTS` request compensation",
    ),
    (
        "any other winch fault, emergency stop of the winch",
        "no",
        "clear it at the winch, then request a mode",
    ),
    (
        "`WINCH_OR_ENCODER_REVERSED`, `WINCH_OR_ENCODER_SCALE`, `DRIVE_AT_FAULT`",
        "no",
        "check signs and scales, then request compensation",
    ),
    ("a sensor is lost in constant tension", "no", "restore it, then request a mode"),
)
"""Whether compensation that has ended comes back, by the reason for which it ended."""


def _lines(rows: Iterable[tuple[str, ...]]) -> str:
    """Return the `rows` of a table as Markdown."""
    return "\n".join(f"|{'|'.join(cells)}|" for cells in rows)


def _loss_table() -> str:
    """Return the severity and consequence of each sensor's loss, as Markdown."""
    rows = [("sensor", "what it is", "severity if *lost*", "consequence"), ("---",) * 4]
    for part, place in PLACES.items():
        row = CONTROLLER[f"{part.upper()}_STALE"]
        rows.append((part.upper(), place, row.severity.word, row.consequence.replace("{loop}", "*loop*")))
    return _lines(rows)


HEAD = f"""# Alarms

Look up an alarm by its code. Generated by `python -m heave_bringup.pages.alarms`.

```text
{EXAMPLE}
```

| severity | response | level of the status on `/diagnostics` |
|---|---|---|
| critical | at once: people, load, rope or winch are in danger | error |
| high | at once: compensation ends or cannot be relied on, or the lift exceeds its plan | error |
| medium | within minutes: compensation is degraded, or one more fault would end it | warning |
| low | before the next lift | warning |
| event | none: log entry only | ok |

Severities are priorities as in IEC 62682 and ISA-18.2. Codes are stable; wording may improve. On `/diagnostics`, status
`alarms` of the controller is at most a warning; status `sensor NAME` is an error while that sensor is lost.

Values are in italics. *loop* is what the controller does at that moment: *Compensation continues*, *Compensation is
fading out; the depth sensor damps the load*, *Winch is stopping*, *No compensation: emergency stop*.

Names with a dot are [parameters](parameters.md) of `winch_controller`. Identified faults are explained in [my winch
differs from its data sheet](guide/howto/wrong_winch.md).

{_loss_table()}

## Does compensation come back?

`COMPENSATION_LOST` gives the reason. The gain falls to 0 over `modes.fade_out_time` ({TIMES.fade_out_time:g} s), then
the winch stops and the brake engages. If only the MRU is lost and a depth sensor is available, the depth sensor damps
the load near its mean position for up to {BLIND_LIMIT / 60.0:g} minutes before the stop (not on a short stiff cable).

{_lines(RETURNS)}

Compensation then restarts after `modes.settling_time` ({TIMES.settling_time:g} s) of good readings, and the gain rises
over `modes.fade_in_time` ({TIMES.fade_in_time:g} s). In mode `standby`, the reason shown is what prevents it.
"""

COLUMNS = ("code", "severity", "what is wrong", "consequence", "action")


def page() -> str:
    """Return the page as Markdown: a table for each package."""
    parts = [HEAD]
    for title, table in TABLES.items():
        lines = [COLUMNS, ("---",) * len(COLUMNS), *map(_cells, _grouped(table.values()))]
        parts.append(f"## {title}\n\n{_lines(lines)}\n")
    return "\n".join(parts)


def _grouped(rows: Iterable[AlarmRow]) -> list[list[AlarmRow]]:
    """Return the `rows` with those that say the same of several parts as one, in the order of the first of each."""
    groups: dict[tuple[str, str, str], list[AlarmRow]] = {}
    for row in rows:
        groups.setdefault((row.code.removeprefix(row.part.upper()), row.state, _action(row)), []).append(row)
    return list(groups.values())


def _action(row: AlarmRow) -> str:
    """Return what a person does; in the name of a parameter a sensor is *sensor*."""
    return row.action.replace(f"sensors.{row.part}.", "sensors.*sensor*.")


def _italic(found: re.Match[str]) -> str:
    return f"*{found[1].replace('_', ' ')}*"


def _by_part(cells: Mapping[str, str]) -> str:
    """Return the `cells` of parts as one: that of the first, and in which parts it differs."""
    common = next(iter(cells.values()))
    others: dict[str, list[str]] = {}
    for part, cell in cells.items():
        if cell != common:
            others.setdefault(cell, []).append(part.upper())
    return "; ".join([common, *(f"{', '.join(parts)}: {cell}" for cell, parts in others.items())])


def _cells(rows: list[AlarmRow]) -> tuple[str, ...]:
    first = rows[0]
    severity = _by_part({row.part: row.severity.word for row in rows})
    consequence = _by_part({row.part: row.consequence for row in rows})
    if any(row.code in OF_LOSS for row in rows):
        severity, consequence = (cell if len(rows) == 1 else LOST for cell in (severity, consequence))
    words = (re.sub(r"\{(\w+)[^}]*\}", _italic, text) for text in (first.state, consequence, _action(first)))
    return (", ".join(f"`{row.code}`" for row in rows), severity, *words)


if __name__ == "__main__":
    sys.stdout.write(page())
