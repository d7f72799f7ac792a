"""Every alarm of every node, from the tables that the nodes raise them from: `docs/alarms.md`.

The page is written by `python -m heave_bringup.pages.alarms > docs/alarms.md`; a test holds the two together.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

from cable_sim_node.alarms import ALARMS as PLANT
from heave_bags.record.session import ALARMS as RECORDER
from heave_node.extras import extra_parts
from heave_node.interface.alarm import NODE_ALARMS, AlarmRow, AlarmTable, Severity
from wave_vessel_node.alarms import ALARMS as VESSEL
from winch_controller_node.core.estimation.sense_design import BACK_TIME
from winch_controller_node.core.supervision.modes import WAIT
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
VALUES = {
    "modes": ModeParameters(),
    "harm_percent": 100.0 * GuardParameters().harm_ratio,
    "back_time": BACK_TIME,
    "wait": WAIT,
    "example": str(CONTROLLER.alarm("SENSOR_LOST, MRU: stale", age=0.31, limit=0.15)),
}
"""What the head of the page may name in braces."""
HEAD = Path(__file__).with_name("alarms_head.md")
"""The page up to its tables of alarms."""


def _lines(rows: Iterable[tuple[str, ...]]) -> str:
    """Return the `rows` of a table as Markdown."""
    return "\n".join(f"|{'|'.join(cells)}|" for cells in rows)


def _loss_table() -> str:
    """Return the severity and consequence of each sensor's loss, as Markdown."""
    rows = [("sensor", "what it is", "severity if *lost*", "consequence"), ("---",) * 4]
    for part, place in PLACES.items():
        row = _lost(part)
        rows.append((part.upper(), place, row.severity.word, row.consequence.replace("{loop}", "*loop*")))
    return _lines(rows)


COLUMNS = ("code", "severity", "what is wrong", "consequence", "action")
ENTRIES = "Log entries"
ENTRY_HEADS = {"code": "code", "what is wrong": "what is logged", "consequence": "consequence", "action": "check"}
"""Headings of the entries of the log, by those of COLUMNS that they have."""


def page() -> str:
    """Return the page as Markdown: the alarms of each package, then the entries of the log of all."""
    parts = [HEAD.read_text(encoding="utf-8").format(**VALUES, loss_table=_loss_table())]
    for title, table in TABLES.items():
        parts.append(
            _section(
                title,
                dict(zip(COLUMNS, COLUMNS, strict=True)),
                [row for row in table.values() if row.severity > Severity.EVENT],
            )
        )
    entries = [row for table in TABLES.values() for row in table.values() if row.severity == Severity.EVENT]
    parts.append(_section(ENTRIES, ENTRY_HEADS, entries))
    return "\n".join(parts)


def _section(title: str, heads: Mapping[str, str], rows: Iterable[AlarmRow]) -> str:
    """Return a `title` and the table of its `rows`, with the columns of `heads`, each with its heading."""
    table = [COLUMNS, *map(_cells, _grouped(rows))]
    shown = [COLUMNS.index(name) for name in heads]
    chosen = [tuple(row[at] for at in shown) for row in map(_beside, table, table[1:])]
    return f"## {title}\n\n{_lines([tuple(heads.values()), ('---',) * len(heads), *chosen])}\n"


def _beside(above: tuple[str, ...], row: tuple[str, ...]) -> tuple[str, ...]:
    """Return a `row` that refers to the row `above` of the same code where consequence or action are the same."""
    same = above[0].partition(",")[0] == row[0].partition(",")[0]
    cells = zip(above[3:], row[3:], strict=True)
    return (*row[:3], *("as above" if same and new == old and " " in new else new for old, new in cells))


def _lost(part: str) -> AlarmRow:
    """Return a row that has severity and consequence of the loss of a sensor, a `part`."""
    return CONTROLLER[f"SENSOR_LOST, {part.upper()}: stale"]


def _grouped(rows: Iterable[AlarmRow]) -> list[list[AlarmRow]]:
    """Return the `rows` with those that say the same of several parts as one, in the order of the first of each."""
    groups: dict[tuple[str, str, str, str], list[AlarmRow]] = {}
    for row in rows:
        groups.setdefault((_kind(row), row.reason, row.state, _action(row)), []).append(row)
    return list(groups.values())


def _kind(row: AlarmRow) -> str:
    """Return the code without the part."""
    return row.code.partition(", ")[0]


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
    if _kind(first) == "SENSOR_LOST" and len({row.severity for row in rows}) > 1:
        lost = [(_lost(row.part).severity, _lost(row.part).consequence) for row in rows]
        severity = LOST if lost == [(row.severity, row.consequence) for row in rows] else severity
        consequence = LOST if severity == LOST else consequence
    words = (re.sub(r"\{(\w+)[^}]*\}", _italic, text) for text in (first.state, consequence, _action(first)))
    parts = [row.part.upper() for row in rows if row.code != _kind(row)]
    parts = ["any sensor"] if len(parts) == len(PLACES) and _kind(first).startswith("SENSOR_") else parts
    return (", ".join([f"`{_kind(first)}`", *parts]), severity, *words)


if __name__ == "__main__":
    sys.stdout.write(page())
