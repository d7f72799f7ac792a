"""What the cases of a study gave as a pandas table: a row for each case, with all that repeats it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pandas
from heave_bags.analyse import kpi_set

from heave_studies.study.case_file import CASE, SCENARIO
from heave_studies.study.runs import CaseResult, Task
from heave_studies.study.workers import FAILURE

SEED, NOMINAL = "seed", "nominal"
LOST, REASON, MET, MISSED, SHARE = "lost", "reason", "met", "missed", "compensating_share"
BREACHES = "breaches"
SCREENED, FLAG = "screened", "flag"
OUTCOME = (FAILURE, LOST, REASON, MET, MISSED, BREACHES, SHARE, SCREENED, FLAG)
"""Columns with what became of a case, before its figures of merit."""

SILENT, SILENT_START = "silent_minute", "silent_minute_start_s"
"""Columns with the worst minute that no alarm announced: s(z) / s(z_off) over it [-], and when it begins [s]."""


def case_frame(tasks: Sequence[Task], results: Sequence[CaseResult]) -> pandas.DataFrame:
    """Return a row for each case: number, seed, settings by place, outcome, figures of merit, the whole scenario.

    Parameters
    ----------
    tasks, results : of the cases, in their order
    """
    rows = [_row(task, result) for task, result in zip(tasks, results, strict=True)]
    settings = dict.fromkeys(place for result in results for place in result.case.settings)
    keys = [definition.key for definition in kpi_set.KPI_DEFINITIONS]
    frame = pandas.DataFrame(
        rows, columns=[CASE, SEED, NOMINAL, *settings, *OUTCOME, SILENT, SILENT_START, *keys, SCENARIO]
    )
    for place in settings:
        frame[place] = _of_one_type(frame[place])
    return frame.astype(dict.fromkeys((SILENT, SILENT_START, *keys), float))


def settings_of(frame: pandas.DataFrame) -> list[str]:
    """Return the columns of a `frame` in which its cases differ: places of parameters."""
    known = {CASE, SEED, NOMINAL, SCENARIO, *OUTCOME, SILENT, SILENT_START, *kpi_set.DEFINITION_OF}
    return [name for name in frame.columns if name not in known]


def alike(frame: pandas.DataFrame, *but_for: str) -> list[list[int]]:
    """Return the rows of a `frame` that have the same settings `but_for` some columns, nominal ones left out."""
    columns = [name for name in (SEED, *settings_of(frame)) if name not in but_for]
    groups: dict[tuple[str, ...], list[int]] = {}
    for place, row in enumerate(frame[[NOMINAL, *columns]].to_dict("records")):
        if not row[NOMINAL]:
            groups.setdefault(tuple(str(row[name]) for name in columns), []).append(place)
    return list(groups.values())


def _row(task: Task, result: CaseResult) -> dict[str, object]:
    case = result.case
    share = None if math.isnan(result.compensating) else result.compensating
    return {
        CASE: case.number,
        SEED: case.seed,
        NOMINAL: case.is_nominal,
        **case.settings,
        FAILURE: result.failure,
        LOST: result.is_lost,
        REASON: result.reason,
        MET: not result.failure and not result.missed,
        MISSED: "; ".join(result.missed),
        BREACHES: "; ".join(result.breaches),
        SHARE: share,
        SCREENED: result.is_screened,
        FLAG: result.flag,
        SILENT: result.minute.ratio,
        SILENT_START: result.minute.start,
        **result.kpis,
        SCENARIO: task.text,
    }


def _of_one_type(column: pandas.Series) -> pandas.Series:
    """Return a column that a file can hold: words where its values are of several types."""
    types = {type(value) for value in column.dropna()} if column.dtype == object else set()
    return column.map(str, na_action="ignore") if len(types - {int, float}) > 0 and len(types) > 1 else column
