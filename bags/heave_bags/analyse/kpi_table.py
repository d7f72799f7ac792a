"""Figures of merit (KPIs) as people see them: which of them, and as a text table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

from heave_node.run_parameters import LOCKSTEP

from heave_bags.analyse.kpi_set import CHANGES, DEFINITION_OF, KPI_DEFINITIONS, LANDING
from heave_bags.analyse.kpis.definition import KpiDefinition
from heave_bags.analyse.kpis.sources import SOURCES, source_of

OF_WALL_TIME = ("loop_age_p50_s", "loop_age_p99_s", "loop_age_max_s", "missed_deadlines")
"""Figures of how a run keeps up with the wall clock."""
COUNT_OF_EVENTS = {LANDING: "landings", CHANGES: "mode_changes"}
"""Figures that count the events of a group; people see the group only where there are any."""


def shown(columns: Sequence[Mapping[str, float]]) -> list[KpiDefinition]:
    """Return the figures that people see of the KPIs of one or several runs, `columns`, in order.

    Left out is what no run has a value of, what counts events that there were none of, and what is seldom, where it
    is 0 in all runs.
    """

    def has_events(group: str) -> bool:
        count = COUNT_OF_EVENTS.get(group)
        return count is None or any(column.get(count, 0.0) > 0.0 for column in columns)

    def is_reported(definition: KpiDefinition, column: Mapping[str, float]) -> bool:
        value = column.get(definition.key, math.nan)
        return math.isfinite(value) and not (definition.is_seldom and value == 0.0)

    return [
        definition
        for definition in KPI_DEFINITIONS
        if has_events(definition.group) and any(is_reported(definition, column) for column in columns)
    ]


def as_seen(values: Mapping[str, float], pacing: str) -> dict[str, float]:
    """Return the KPIs of a run as people see them: in lockstep without those of wall time, which has no effect there.

    Parameters
    ----------
    values : KPIs by key
    pacing : of the run, as its bag says; "": unknown
    """
    left_out = OF_WALL_TIME if pacing == LOCKSTEP else ()
    return {key: math.nan if key in left_out else value for key, value in values.items()}


def table(
    columns: Mapping[str, Mapping[str, float]],
    sources: Mapping[str, Mapping[str, str]] = MappingProxyType({}),
    *,
    keys: Sequence[str] | None = None,
    notes: Mapping[str, str] = MappingProxyType({}),
) -> str:
    """Return KPIs as a text table; rows without any value are left out.

    Parameters
    ----------
    columns : KPIs of one or several runs, by name
    sources : where the motions of each run come from; a figure that is not made from the truth says so
    keys : of the figures in the table, in order; None: of all
    notes : on figures, by key
    """
    rows = [("", "", *columns)]
    for definition in shown(list(columns.values())) if keys is None else [DEFINITION_OF[key] for key in keys]:
        cells = [definition.text(values.get(definition.key, math.nan)) for values in columns.values()]
        marks = {source_of(definition.key, of_run) for of_run in sources.values()} - {"", SOURCES[-1]}
        beside = [definition.unit, ", ".join(sorted(marks)), notes.get(definition.key, "")]
        rows.append((definition.title, "  ".join(text for text in beside if text), *cells))
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    lines = [
        f"{row[0]:<{widths[0]}}  "
        + "  ".join(f"{c:>{w}}" for c, w in zip(row[2:], widths[2:], strict=True))
        + f"  {row[1]}"
        for row in rows
    ]
    return "\n".join(line.rstrip() for line in lines)
