"""Every alarm of every node, from the tables that the nodes raise them from: `docs/alarms.md`.

The page is written by `python -m heave_bringup.pages.alarms > docs/alarms.md`; a test holds the two together.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable

from cable_sim_node.alarms import ALARMS as PLANT
from heave_bags.record.alarms import ALARMS as RECORDER
from heave_node.interface.alarm import AlarmRow, AlarmTable, Severity
from heave_node.interface.node_alarms import NODE_ALARMS
from wave_vessel_node.alarms import ALARMS as VESSEL
from winch_controller_node.interface.alarms import ALARMS as CONTROLLER

TABLES: dict[str, AlarmTable] = {
    "Controller and adviser": CONTROLLER,
    "Cable, unit and virtual winch": PLANT,
    "Sea and vessel": VESSEL,
    "Recorder": RECORDER,
    "Every node": NODE_ALARMS,
}
"""The table of each package, under its heading."""

HEAD = """# Alarms

Look an alarm up by its code. This page is written by `python -m heave_bringup.pages.alarms` from the tables that the
nodes raise their alarms from.

An alarm is one line: code, severity, what is wrong with value and limit, what follows, what to do.

```text
MRU_STALE (high): no data for 0.31 s, limit 0.15 s. Compensation fades out. Check power, cable, driver, clock.
```

| severity | act | level of the status on `/diagnostics` |
|---|---|---|
| critical | at once: people, unit, cable or winch are in danger | error |
| high | at once: compensation ends or is less than requested | error |
| medium | within minutes: something is missing that a further fault would need | warning |
| low | before the next lift | warning |
| event | nothing to do: an entry of the log | ok |

Severities are priorities as in IEC 62682 and ISA-18.2. Codes are stable; words may improve. The controller reports its
alarms in part `alarms` of its diagnostics, a warning whatever their severity; its parts `sensor NAME` are an error
while that sensor is lost. Bags, reports, `heave run`, `heave operate` and `heave panel` show code and severity. Values
stand in italics below. MRU is the motion sensor on the ship, ENCODER that of the drum; DEPTH, VELOCITY and IMU are on
the subsea unit, LOAD_CELL is at the boom tip. What to do about a fault that is identified stands in
the guide, "My winch differs from its data sheet".
"""

COLUMNS = ("code", "severity", "what is wrong", "consequence", "action")


def page() -> str:
    """Return the page as Markdown: a table for each package."""
    parts = [HEAD]
    for title, table in TABLES.items():
        lines = [COLUMNS, ("---",) * len(COLUMNS), *map(_cells, _grouped(table.values()))]
        parts.append(f"## {title}\n\n" + "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n")
    return "\n".join(parts)


def _grouped(rows: Iterable[AlarmRow]) -> list[list[AlarmRow]]:
    """Return the `rows` with those that differ in their part alone as one, in the order of the first of each."""
    groups: dict[tuple[Severity, str, str, str, str], list[AlarmRow]] = {}
    for row in rows:
        kind = row.code.removeprefix(row.part.upper())
        groups.setdefault((row.severity, kind, row.state, row.consequence, row.action), []).append(row)
    return list(groups.values())


def _cells(rows: list[AlarmRow]) -> tuple[str, ...]:
    first = rows[0]
    words = (re.sub(r"\{(\w+)[^}]*\}", r"*\1*", text) for text in (first.state, first.consequence, first.action))
    return (", ".join(f"`{row.code}`" for row in rows), first.severity.word, *words)


if __name__ == "__main__":
    sys.stdout.write(page())
