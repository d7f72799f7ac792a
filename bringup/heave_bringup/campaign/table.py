"""What a campaign gave as a pandas table: one row for each case, all that is needed to repeat it among them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pandas
from heave_bags.analyse import kpi_set
from heave_bags.record.provenance import git_commit, versions

from heave_bringup.campaign.plan import Campaign
from heave_bringup.campaign.runs import CaseResult, Task
from heave_bringup.tables.baseline_law import BASELINE_LAW
from heave_bringup.tables.case_table import CASE, SCENARIO

SEED, NOMINAL = "seed", "nominal"
FAILURE, LOST, REASON, MET, MISSED, SHARE = "failure", "lost", "reason", "met", "missed", "compensating_share"
OUTCOME = (FAILURE, LOST, REASON, MET, MISSED, SHARE)
"""Columns with what became of a case, before its figures of merit."""

LAW = "winch_controller.law"
"""Place of the law."""


def case_frame(tasks: Sequence[Task], results: Sequence[CaseResult]) -> pandas.DataFrame:
    """Return a row for each case: number, seed, settings by place, outcome, figures of merit, the whole scenario.

    Parameters
    ----------
    tasks, results : of the cases, in their order
    """
    rows = [_row(task, result) for task, result in zip(tasks, results, strict=True)]
    settings = dict.fromkeys(place for result in results for place in result.case.settings)
    keys = [definition.key for definition in kpi_set.KPI_DEFINITIONS]
    frame = pandas.DataFrame(rows, columns=[CASE, SEED, NOMINAL, *settings, *OUTCOME, *keys, SCENARIO])
    _fill_in_baselines(frame, list(settings))
    for place in settings:
        frame[place] = _of_one_type(frame[place])
    return frame.astype(dict.fromkeys(keys, float))


def _fill_in_baselines(frame: pandas.DataFrame, settings: Sequence[str]) -> None:
    """Fill in the efficiency of the baseline law where a case differs from another one by its law only."""
    if LAW not in settings:
        return
    others = [SEED, NOMINAL, *(place for place in settings if place != LAW)]
    alike = frame[others].map(str).agg("|".join, axis=1)
    is_baseline = frame[LAW] == BASELINE_LAW
    found = dict(zip(alike[is_baseline], frame.loc[is_baseline, "unit_efficiency"], strict=True))
    frame["baseline_efficiency"] = frame["baseline_efficiency"].astype(float).fillna(alike.map(found).astype(float))


def settings_of(frame: pandas.DataFrame) -> list[str]:
    """Return the columns of a `frame` in which its cases differ: places of parameters."""
    known = {CASE, SEED, NOMINAL, SCENARIO, *OUTCOME, *kpi_set.DEFINITION_OF}
    return [name for name in frame.columns if name not in known]


def provenance(campaign: Campaign, digest: str) -> dict[str, str]:
    """Return what the file of a table says of itself.

    Parameters
    ----------
    campaign : that was run
    digest : of all its values
    """
    found = {name: version for name, version in versions().items() if version}
    return {
        "campaign": str(campaign.path),
        "scenario": campaign.scenario,
        "digest": digest,
        "commit": git_commit(),
        **{f"version.{name}": version for name, version in found.items()},
    }


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
        SHARE: share,
        **result.kpis,
        SCENARIO: task.text,
    }


def _of_one_type(column: pandas.Series) -> pandas.Series:
    """Return a column that a file can hold: words where its values are of several types."""
    types = {type(value) for value in column.dropna()} if column.dtype == object else set()
    return column.map(str, na_action="ignore") if len(types - {int, float}) > 0 and len(types) > 1 else column
