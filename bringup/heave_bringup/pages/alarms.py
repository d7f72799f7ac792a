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
from heave_node.interface.alarm import AlarmRow, AlarmTable
from heave_node.interface.node_alarms import NODE_ALARMS
from wave_vessel_node.alarms import ALARMS as VESSEL
from winch_controller_node.core.estimation.loop_estimation import BACK_TIME
from winch_controller_node.core.supervision.command_timeouts import MOST, PERIOD, WAIT
from winch_controller_node.core.supervision.guard_hold import CAUSE_TIME, HOLD_GROWTH, KNOWN_HOLD
from winch_controller_node.core.supervision.supervisor import BLIND_LIMIT
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

GUARD, TIMES = GuardParameters(), ModeParameters()
EXAMPLE = str(CONTROLLER.alarm("MRU_STALE", age=0.31, limit=0.15))

RETURNS = (
    ("reason", "comes back", "what you do"),
    ("---",) * 3,
    (
        'a sensor is lost: "mru frozen"',
        f"automatically: {BACK_TIME:g} s after its readings are good while authority still falls; `modes.resume_time` "
        f"({TIMES.resume_time:g} s) after that once the winch has stopped, unless `modes.resume` is off",
        "restore the sensor",
    ),
    (
        '"encoder frozen"',
        "automatically, after the same times, once its reading changes. While the drum rests it may stay the same",
        "check that the drum turns; restart the encoder, then request compensation",
    ),
    (
        "harm: `WORSE_THAN_OFF`, `LITTLE_GAIN`, `UNIT_HEAVE_HIGH`, `UNIT_SWING_HIGH`, `DRUM_SPEED_OFF`",
        f"automatically: after `guard.hold_time` ({GUARD.hold_time:g} s), {HOLD_GROWTH:g} times longer after each "
        f"failed attempt, up to {GUARD.hold_time_limit:g} s; {KNOWN_HOLD:g} s where the cause was identified within "
        f"{CAUSE_TIME:g} s; not while the sea demands more than {GUARD.demand_ratio:g} times the winch's limits",
        "nothing for a first attempt, then as the alarm says",
    ),
    (
        "`DEPTH_MRU_DISAGREE`",
        "automatically: after the same times, counted from when the two agree",
        "check sign and scale of both",
    ),
    (
        "`COMMANDS_CUT`, `COMMANDS_TOO_LATE`",
        f"automatically: {KNOWN_HOLD:g} s after commands are in time",
        "check the link, the network and the CPU load of the computer",
    ),
    (
        "winch fault: command timeout",
        f"automatically: {WAIT:g} s after the winch takes commands, at most {MOST} times within {PERIOD:g} s",
        "the same; after `COMMAND_TIMEOUTS` request compensation",
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
    return "\n".join(f"| {' | '.join(cells)} |" for cells in rows)


HEAD = f"""# Alarms

Look an alarm up by its code: what is wrong, what follows, what to do. This page is written by
`python -m heave_bringup.pages.alarms` from the tables that the nodes raise their alarms from.

An alarm is one line: code, severity, what is wrong with value and limit, what follows, what to do.

```text
{EXAMPLE}
```

| severity | act | level of the status on `/diagnostics` |
|---|---|---|
| critical | at once: people, unit, cable or winch are in danger | error |
| high | at once: compensation ends or cannot be relied on, or the lift is beyond what was planned | error |
| medium | within minutes: compensation does less than it could, or a further fault would end it | warning |
| low | before the next lift | warning |
| event | nothing to do: an entry of the log | ok |

Severities are priorities as in IEC 62682 and ISA-18.2. Codes are stable; words may improve. The controller reports its
alarms in part `alarms` of its diagnostics, a warning whatever their severity; its parts `sensor NAME` are an error
while that sensor is lost. Bags, reports, `heave run`, `heave operate` and `heave panel` show code and severity.

Values stand in italics. *loop* is what the controller does when it raises the alarm: *Compensation continues*,
*Compensation is fading out; the depth sensor damps the load*, *Winch is stopping*, *No compensation: emergency stop*.

MRU is the motion sensor on the ship, ENCODER that of the drum; DEPTH,
VELOCITY and IMU are on the subsea unit, LOAD_CELL is at the boom tip. *measurement* is the quantity that a sensor
measures: `mru_heave`, `mru_heave_rate`, `unit_heave` (by the depth sensor), `unit_velocity`, `unit_acceleration`.
Names with a dot are [parameters](parameters.md) of `winch_controller`. What to do about a fault that is identified
stands in the guide, "My winch differs from its data sheet".

## Does compensation come back?

`COMPENSATION_LOST` gives the reason. Authority falls to zero over `modes.fade_out_time`
({TIMES.fade_out_time:g} s). What then holds the unit:

- The MRU is lost or excluded, and the depth sensor reads: the depth sensor damps the unit and holds it near its mean
  until the MRU is good or the operator requests rest, for at most {BLIND_LIMIT / 60.0:g} minutes; then the winch stops.
- The MRU is lost or excluded, and there is no depth sensor, or the cable is short and stiff: the winch stops and the
  brake goes on.
- Any other reason: the winch stops and the brake goes on.

After that:

{_lines(RETURNS)}

Once the winch has stopped, compensation begins again after `modes.settling_time` ({TIMES.settling_time:g} s) of good
readings, and when nothing else stands in its way: the reason of mode `standby` names what does. Authority rises over
`modes.fade_in_time` ({TIMES.fade_in_time:g} s).
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
    words = (re.sub(r"\{(\w+)[^}]*\}", _italic, text) for text in (first.state, consequence, _action(first)))
    return (", ".join(f"`{row.code}`" for row in rows), severity, *words)


if __name__ == "__main__":
    sys.stdout.write(page())
