"""What a campaign gave as a pandas table: one row for each case, all that is needed to repeat it among them."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import pandas
from heave_bags.analyse import kpi_set
from heave_bags.record.provenance import git_commit, versions
from heave_bringup.errors import CommandError
from heave_bringup.scenarios import named_files

from heave_studies.campaign.plan import Campaign
from heave_studies.campaign.runs import CaseResult, Task
from heave_studies.tables.case_table import CASE, FILES, SCENARIO
from heave_studies.tables.kept_files import KeptFile

SEED, NOMINAL = "seed", "nominal"
FAILURE, LOST, REASON, MET, MISSED, SHARE = "failure", "lost", "reason", "met", "missed", "compensating_share"
BASELINE_UNKNOWN, BREACHES = "baseline_unknown", "breaches"
OUTCOME = (FAILURE, LOST, REASON, MET, MISSED, BREACHES, SHARE, BASELINE_UNKNOWN)
"""Columns with what became of a case, before its figures of merit."""

BASELINE_EFFICIENCY = "baseline_efficiency"

NO_FILES: Mapping[str, KeptFile] = MappingProxyType({})


def check_any_ran(frame: pandas.DataFrame) -> None:
    """Raise CommandError where no case of a `frame` ran."""
    failures = frame[FAILURE]
    if not len(failures) or (failures == "").any():
        return
    words = str(failures.iloc[0])
    is_foreign = "deserializ" in words.lower() or "No module named" in words
    hint = ": the workers need this suite, in the same version" if is_foreign else ""
    raise CommandError(f"none of {len(failures)} cases ran{hint}; the first: {words}")


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
    frame = pandas.DataFrame(rows, columns=[CASE, SEED, NOMINAL, *settings, *OUTCOME, *keys, SCENARIO, FILES])
    _fill_in_baselines(frame, tasks)
    for place in settings:
        frame[place] = _of_one_type(frame[place])
    return frame.astype(dict.fromkeys(keys, float))


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
    known = {CASE, SEED, NOMINAL, SCENARIO, FILES, *OUTCOME, *kpi_set.DEFINITION_OF}
    return [name for name in frame.columns if name not in known]


def provenance(campaign: Campaign, mark: Mapping[str, str]) -> dict[str, str]:
    """Return the header of a table's file.

    Parameters
    ----------
    campaign : that was run
    mark : its identity
    """
    found = {name: version for name, version in versions().items() if version}
    return {
        "campaign": str(campaign.path),
        "scenario": campaign.scenario,
        **mark,
        "commit": git_commit(),
        **{f"version.{name}": version for name, version in found.items()},
    }


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
        **result.kpis,
        SCENARIO: task.text,
        FILES: json.dumps(read) if read else "",
    }


def _of_one_type(column: pandas.Series) -> pandas.Series:
    """Return a column that a file can hold: words where its values are of several types."""
    types = {type(value) for value in column.dropna()} if column.dtype == object else set()
    return column.map(str, na_action="ignore") if len(types - {int, float}) > 0 and len(types) > 1 else column
