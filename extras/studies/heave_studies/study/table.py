"""What the cases of a study gave as a pandas table: a row for each case, with all that repeats it."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import pandas
from heave_bags.analyse import kpi_set
from heave_bringup.scenarios import named_files

from heave_studies.study.case_file import CASE, FILES, SCENARIO, KeptFile
from heave_studies.study.runs import CaseResult, Task
from heave_studies.study.workers import FAILURE

SEED, NOMINAL = "seed", "nominal"
LOST, REASON, MET, MISSED, SHARE = "lost", "reason", "met", "missed", "compensating_share"
BASELINE_UNKNOWN, BREACHES = "baseline_unknown", "breaches"
SCREENED, FLAG = "screened", "flag"
OUTCOME = (FAILURE, LOST, REASON, MET, MISSED, BREACHES, SHARE, BASELINE_UNKNOWN, SCREENED, FLAG)
"""Columns with what became of a case, before its figures of merit."""

SILENT, SILENT_START = "silent_minute", "silent_minute_start_s"
"""Columns with the worst minute that no alarm announced: s(z) / s(z_off) over it [-], and when it begins [s]."""

BASELINE_EFFICIENCY = "baseline_efficiency"

NO_FILES: Mapping[str, KeptFile] = MappingProxyType({})


def case_frame(
    tasks: Sequence[Task], results: Sequence[CaseResult], files: Mapping[str, KeptFile] = NO_FILES
) -> pandas.DataFrame:
    """Return a row for each case: number, seed, settings by place, outcome, figures of merit, the whole scenario.

    Parameters
    ----------
    tasks, results : of the cases, in their order
    files : that they read, by path
    """
    rows = [_row(task, result, files) for task, result in zip(tasks, results, strict=True)]
    settings = dict.fromkeys(place for result in results for place in result.case.settings)
    keys = [definition.key for definition in kpi_set.KPI_DEFINITIONS]
    frame = pandas.DataFrame(
        rows, columns=[CASE, SEED, NOMINAL, *settings, *OUTCOME, SILENT, SILENT_START, *keys, SCENARIO, FILES]
    )
    _fill_in_baselines(frame, tasks)
    for place in settings:
        frame[place] = _of_one_type(frame[place])
    return frame.astype(dict.fromkeys((SILENT, SILENT_START, *keys), float))


def _fill_in_baselines(frame: pandas.DataFrame, tasks: Sequence[Task]) -> None:
    """Fill in the efficiency of the baseline law, or why it failed, where a case differs from another by its law only.

    Parameters
    ----------
    frame : a row for each case
    tasks : of the cases, in their order
    """
    row_of = {task.but_for_law: row for row, task in zip(frame.index, tasks, strict=True) if task.is_baseline}
    for row, task in zip(frame.index, tasks, strict=True):
        same_sea = row_of.get(task.but_for_law)
        if same_sea is not None:
            frame.loc[row, BASELINE_EFFICIENCY] = frame.loc[same_sea, "unit_efficiency"]
            frame.loc[row, BASELINE_UNKNOWN] = frame.loc[same_sea, FAILURE]


def settings_of(frame: pandas.DataFrame) -> list[str]:
    """Return the columns of a `frame` in which its cases differ: places of parameters."""
    known = {CASE, SEED, NOMINAL, SCENARIO, FILES, *OUTCOME, SILENT, SILENT_START, *kpi_set.DEFINITION_OF}
    return [name for name in frame.columns if name not in known]


def alike(frame: pandas.DataFrame, *but_for: str) -> list[list[int]]:
    """Return the rows of a `frame` that have the same settings `but_for` some columns, nominal ones left out."""
    columns = [name for name in (SEED, *settings_of(frame)) if name not in but_for]
    groups: dict[tuple[str, ...], list[int]] = {}
    for place, row in enumerate(frame[[NOMINAL, *columns]].to_dict("records")):
        if not row[NOMINAL]:
            groups.setdefault(tuple(str(row[name]) for name in columns), []).append(place)
    return list(groups.values())


def _row(task: Task, result: CaseResult, files: Mapping[str, KeptFile]) -> dict[str, object]:
    case = result.case
    read = {path: files[path].digest for path in named_files(task.scenario) if path in files}
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
        BASELINE_UNKNOWN: result.baseline_unknown,
        SCREENED: result.is_screened,
        FLAG: result.flag,
        SILENT: result.minute.ratio,
        SILENT_START: result.minute.start,
        **result.kpis,
        SCENARIO: task.text,
        FILES: json.dumps(read) if read else "",
    }


def _of_one_type(column: pandas.Series) -> pandas.Series:
    """Return a column that a file can hold: words where its values are of several types."""
    types = {type(value) for value in column.dropna()} if column.dtype == object else set()
    return column.map(str, na_action="ignore") if len(types - {int, float}) > 0 and len(types) > 1 else column
