"""A campaign from its plan to its table: cases that have a result already are not run again."""

from __future__ import annotations

import time
from pathlib import Path

import pandas
from heave_bags.record.provenance import git_commit
from heave_node.parameters import ParameterError

from heave_bringup.campaign.executors import run_tasks
from heave_bringup.campaign.journal import Journal, digest_of, journal_path
from heave_bringup.campaign.plan import Campaign
from heave_bringup.campaign.runs import CaseResult, make_tasks
from heave_bringup.campaign.table import case_frame, provenance
from heave_bringup.progress import ProgressLine, time_to_go
from heave_bringup.tables.case_table import read_cases, write_cases


def run_study(
    campaign: Campaign,
    *,
    output: Path | None = None,
    processes: int | None = None,
    dask: str | None = None,
    has_baseline: bool = False,
) -> pandas.DataFrame:
    """Run the cases of a campaign, showing progress with the time to go; return their table.

    Parameters
    ----------
    campaign : whose parameters are checked before the first case runs
    output : Parquet file of the table. Results are kept beside it as they come: a study that was ended goes on where
        it was, and gives the same file; one that is complete is read.
    processes : number of worker processes; None takes one per processor
    dask : address of a scheduler whose workers run the cases
    has_baseline : each case is run under the baseline law as well

    Raises ParameterError for a wrong parameter, and where the file is another campaign's.
    """
    tasks = make_tasks(campaign, list(campaign.cases()), has_baseline=has_baseline)
    digest = digest_of(tasks, git_commit())
    if output is not None and output.exists():
        frame, about = read_cases(output)
        if about.get("digest") == digest:
            return frame
        raise ParameterError(
            f"{output}: holds the cases of another campaign, or of another version of the program: remove it, or name "
            "another table"
        )
    journal = None if output is None else Journal(journal_path(output), digest)
    found = {task.case.number: journal.result_of(task.case) for task in tasks} if journal else {}
    results = {number: result for number, result in found.items() if result is not None}
    todo = [task for task in tasks if task.case.number not in results]
    before, started = len(results), time.monotonic()
    with ProgressLine() as progress:
        progress.show(_beginning(len(tasks), before, campaign.scenario), before / len(tasks))
        for result in run_tasks(todo, processes, dask):
            results[result.case.number] = result
            if journal is not None:
                journal.add(result)
            done = len(results) - before
            rest = time_to_go(time.monotonic() - started, done / len(todo))
            words = f"case {len(results)} of {len(tasks)}, {rest}: {_short(result)}"
            progress.show(words, len(results) / len(tasks))
    frame = case_frame(tasks, [results[task.case.number] for task in tasks])
    if output is not None and journal is not None:
        write_cases(frame, output, provenance(campaign, digest))
        journal.remove()
    return frame


def _beginning(cases: int, before: int, scenario: str) -> str:
    known = f", {before} of them known already" if before else ""
    return f"{cases} cases of {scenario}{known}"


def _short(result: CaseResult) -> str:
    outcome = f" failed: {result.failure}" if result.failure else " lost" if result.is_lost else ""
    return f"{result.case.label}{outcome}"
