"""A study from its plan to its table: jobs that have a result already are not run again."""

from __future__ import annotations

import hashlib
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

import pandas
from heave_bags.record.provenance import git_commit, versions
from heave_bringup.progress import ProgressLine, time_to_go

from heave_studies.study.case_file import check_can_write, read_cases, write_cases
from heave_studies.study.cost import write_cost
from heave_studies.study.journal import Journal, refuse_other
from heave_studies.study.kept_files import KeptFile
from heave_studies.study.workers import FAILURE, Job, Plain, Run, workers

TABLE, CSV, PAGE, PDF, JOURNAL = "table.parquet", "table.csv", "page.html", "page.pdf", "journal.jsonl"
"""What a study leaves in its folder; the journal goes when the table is there."""


class Kind(Protocol):
    """A kind of study: its jobs, and the table of what they give."""

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def identity(self) -> str:
        """What identifies its results: all that they follow from, but the version of the program."""

    @property
    def size(self) -> int:
        """Number of jobs, at most."""

    @property
    def is_local(self) -> bool:
        """Whether its jobs run one after the other, in the process of the command."""

    @property
    def files(self) -> Mapping[str, KeptFile]:
        """Files that its jobs read, by path: the table keeps them."""

    def rounds(self, results: Mapping[int, Plain]) -> Iterator[list[Job]]:
        """Yield its jobs; those of a later round may depend on the `results`, by number, of the rounds before."""

    def frame(self, results: Mapping[int, Plain]) -> pandas.DataFrame:
        """Return the table of the `results`."""


def run_study(
    kind: Kind, folder: Path | None = None, *, processes: int | None = None, dask: str | None = None
) -> tuple[pandas.DataFrame, dict[str, str]]:
    """Run the jobs of a study, showing progress with the time to go; return its table, and where that comes from.

    Parameters
    ----------
    kind : what is run; it has been checked
    folder : that takes the table. Results are kept in it as they come: a study that was ended goes on where it was, and
        gives the same file; one that is complete is read. None: nothing is kept
    processes : number of worker processes; None takes one per processor, 1 runs all in this one
    dask : address of a scheduler whose workers run the jobs

    Raises ParameterError where the folder holds another study.
    """
    mark = {"digest": hashlib.sha256((git_commit() + kind.identity).encode()).hexdigest()}
    about = {"study": kind.name, **mark, "commit": git_commit()}
    about |= {f"version.{name}": version for name, version in versions().items() if version}
    if kind.is_local:
        processes, dask = 1, None
    if folder is None:
        with workers(processes, dask) as run:
            return _completed(kind, run, None, {}), about
    table = folder / TABLE
    if table.exists():
        frame, about = read_cases(table)
        refuse_other(table, about, mark)
        return frame, about
    folder.mkdir(parents=True, exist_ok=True)
    check_can_write(table)
    with Journal(folder / JOURNAL, mark) as journal:
        results = dict(journal.results)
        with _saying_what_is_kept(journal, results), workers(processes, dask) as run:
            frame = _completed(kind, run, journal, results)
        write_cost(results, folder)
        write_cases(frame, table, about, kind.files.values())
        journal.remove()
    return read_cases(table)


def _completed(kind: Kind, run: Run, journal: Journal | None, results: dict[int, Plain]) -> pandas.DataFrame:
    """Return the table of a study, when all its jobs are among the `results`, each put there at once."""
    started, before = time.monotonic(), len(results)
    done = 0
    with ProgressLine() as progress:
        known = f", {before} of them known already" if before else ""
        progress.show(f"{kind.size} cases of {kind.name}{known}", 0.0)
        for jobs in kind.rounds(results):
            for job, result in run([job for job in jobs if job.number not in results]):
                results[job.number] = result
                done += 1
                if journal is not None:
                    journal.keep(job.number, result)
                share = len(results) / max(kind.size, len(results))
                rest = time_to_go(time.monotonic() - started, done / max(kind.size - before, done))
                failure = f" failed: {result[FAILURE]}" if result.get(FAILURE) else ""
                progress.show(f"case {len(results)} of {kind.size}, {rest}: {job.label}{failure}", share)
    return kind.frame(results)


@contextmanager
def _saying_what_is_kept(journal: Journal, results: Mapping[int, Plain]) -> Iterator[None]:
    """Where the study ends before its table is written, say that the cases which were run are not lost."""
    try:
        yield
    except BaseException:
        if results:
            sys.stderr.write(
                f"heave: {len(results)} cases are kept in {journal.path}: the same command goes on there\n"
            )
        raise
