"""A campaign from its plan to its table: cases that have a result already are not run again."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path

import pandas
from heave_bags.record.provenance import git_commit
from heave_bringup.progress import ProgressLine, time_to_go
from heave_bringup.scenarios import named_files

from heave_studies.campaign.executors import run_tasks
from heave_studies.campaign.journal import Journal, digest_of, journal_path, mark_of, refuse_other
from heave_studies.campaign.plan import Campaign
from heave_studies.campaign.runs import CaseResult, Task, make_tasks
from heave_studies.campaign.table import case_frame, provenance
from heave_studies.tables.case_table import check_can_write, read_cases, write_cases
from heave_studies.tables.kept_files import keep_files


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
    has_baseline : each case is run under the baseline law as well; one that was begun with it, or without it, must go
        on so

    Raises ParameterError for a wrong parameter, and where the file is another campaign's.
    """
    tasks = make_tasks(campaign, list(campaign.cases()), has_baseline=has_baseline)
    files = keep_files({path for task in tasks for path in named_files(task.scenario)})
    digests = [file.digest for file in files.values()]
    mark = mark_of(digest_of(tasks, git_commit(), digests), has_baseline=has_baseline)
    if output is not None and output.exists():
        frame, about = read_cases(output)
        refuse_other(output, about, mark)
        return frame
    if output is not None:
        check_can_write(output)
    journal = None if output is None else Journal(journal_path(output), mark)
    found = {task.case.number: journal.result_of(task.case) for task in tasks} if journal else {}
    results = {number: result for number, result in found.items() if result is not None}
    todo = [task for task in tasks if task.case.number not in results]
    with _saying_what_is_kept(journal, results):
        with closing(run_tasks(todo, processes, dask)) as coming:  # at once, not when it is collected
            _run(todo, results, journal, coming, campaign.scenario)
        frame = case_frame(tasks, [results[task.case.number] for task in tasks], files)
        if output is not None and journal is not None:
            write_cases(frame, output, provenance(campaign, mark), files.values())
            journal.remove()
    return frame


@contextmanager
def _saying_what_is_kept(journal: Journal | None, results: Mapping[int, CaseResult]) -> Iterator[None]:
    """Where the study ends before its table is written, say that the cases which were run are not lost."""
    try:
        yield
    except BaseException:
        if journal is not None and results:
            sys.stderr.write(
                f"heave: {len(results)} cases are kept in {journal.path}: the same command goes on there\n"
            )
        raise


def _run(
    todo: Sequence[Task],
    results: dict[int, CaseResult],
    journal: Journal | None,
    coming: Iterable[CaseResult],
    scenario: str,
) -> None:
    """Put what is `coming` of the cases `todo` into the `results`, each at once."""
    before, started = len(results), time.monotonic()
    cases = before + len(todo)
    is_twice = any(task.has_baseline and not task.is_baseline for task in todo)
    beside = " and its baseline" if is_twice else ""
    with ProgressLine() as progress:
        progress.show(_beginning(cases, before, scenario, is_twice=is_twice), before / cases)
        for result in coming:
            results[result.case.number] = result
            if journal is not None:
                journal.add(result)
            rest = time_to_go(time.monotonic() - started, (len(results) - before) / len(todo))
            progress.show(f"case {len(results)} of {cases}{beside}, {rest}: {_short(result)}", len(results) / cases)


def _beginning(cases: int, before: int, scenario: str, *, is_twice: bool) -> str:
    known = f", {before} of them known already" if before else ""
    twice = ", each also under the industrial baseline (skip: --no-baseline)" if is_twice else ""
    return f"{cases} cases of {scenario}{known}{twice}"


def _short(result: CaseResult) -> str:
    outcome = f" failed: {result.failure}" if result.failure else " lost" if result.is_lost else ""
    return f"{result.case.label}{outcome}"
