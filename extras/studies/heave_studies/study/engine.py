"""A study from its plan to its table: jobs that have a result already, in its journal, are not run again."""

from __future__ import annotations

import hashlib
import json
import sys
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

import pandas
from heave_bags.record.provenance import git_commit, versions
from heave_bringup.progress import ProgressLine, time_to_go
from heave_node.parameters import ParameterError

from heave_studies.study.case_file import check_can_write, read_cases, write_cases
from heave_studies.study.cost import write_cost
from heave_studies.study.workers import FAILURE, Job, Plain, Run, workers

TABLE, CSV, PAGE, PDF, JOURNAL = "table.parquet", "table.csv", "page.html", "page.pdf", "journal.jsonl"
"""What a study leaves in its folder; the journal goes when the table is there."""


SETTLED = "settled"
"""Key of the number of cases that a job settled, where it is not one."""


class Kind(Protocol):
    """A kind of study: its jobs, and the table of what they give."""

    @property
    def name(self) -> str:
        """What its table and page are called."""

    @property
    def identity(self) -> str:
        """What identifies its results: all that they follow from, but the version of the program."""

    @property
    def size(self) -> int:
        """Number of cases, at most: each job settles one, or as many as its result says (SETTLED)."""

    @property
    def is_open(self) -> bool:
        """Whether its jobs may be fewer: how many depends on what they give."""

    @property
    def is_local(self) -> bool:
        """Whether its jobs run one after the other, in the process of the command."""

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
        write_cases(frame, table, about)
        journal.remove()
    return read_cases(table)


def _completed(kind: Kind, run: Run, journal: Journal | None, results: dict[int, Plain]) -> pandas.DataFrame:
    """Return the table of a study, when all its jobs are among the `results`, each put there at once."""
    started, before = time.monotonic(), _settled(results.values())
    done = before
    size = f"at most {kind.size}" if kind.is_open else f"{kind.size}"
    with ProgressLine() as progress:
        known = f", {before} of them known already" if before else ""
        progress.show(f"{size} cases of {kind.name}{known}", 0.0)
        for jobs in kind.rounds(results):
            for job, result in run([job for job in jobs if job.number not in results]):
                results[job.number] = result
                done += _settled([result])
                if journal is not None:
                    journal.keep(job.number, result)
                new = done - before
                rest = f", {time_to_go(time.monotonic() - started, new / max(kind.size - before, new))}" if new else ""
                failure = f" failed: {result[FAILURE]}" if result.get(FAILURE) else ""
                progress.show(f"{done} of {size} cases{rest}: {job.label}{failure}", done / max(kind.size, done, 1))
    return kind.frame(results)


def _settled(results: Iterable[Plain]) -> int:
    """Return how many cases the `results` of jobs settle."""
    return sum(int(result.get(SETTLED, 1)) for result in results)


@contextmanager
def _saying_what_is_kept(journal: Journal, results: Mapping[int, Plain]) -> Iterator[None]:
    """Where the study ends before its table is written, say that the cases which were run are not lost."""
    try:
        yield
    except BaseException:
        if results:
            kept = _settled(results.values())
            cases = "1 case is" if kept == 1 else f"{kept} cases are"
            sys.stderr.write(f"heave: {cases} kept in {journal.path}: the same command goes on there\n")
        raise


def refuse_other(path: Path, found: Mapping[str, str], wanted: Mapping[str, str]) -> None:
    """Raise ParameterError where the results at `path` are not of the study that is to be run.

    Parameters
    ----------
    path : of the file
    found, wanted : its header, and what that should be
    """
    if any(found.get(name) != value for name, value in wanted.items()):
        raise ParameterError(
            f"{path}: holds results of another study, or of another version of the program: remove it to start "
            "again, or name another folder (--output)"
        )


class Journal:
    """Keeps results as lines of JSON, each written at once; a context manager.

    Parameters
    ----------
    path : of the file
    mark : of its study

    Attributes
    ----------
    results : found in the file, by number

    Raises ParameterError for a file of another study.
    """

    def __init__(self, path: Path, mark: Mapping[str, str]) -> None:
        self.path = path
        self.results: dict[int, Plain] = {}
        kept = self._read(mark) if path.exists() else []
        self._file = path.open("w", encoding="utf-8")
        for line in (json.dumps(mark), *kept):
            self._file.write(line + "\n")
        self._file.flush()

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def _read(self, mark: Mapping[str, str]) -> list[str]:
        """Return the whole lines of results; the last one may have been cut off by what ended the study."""
        head, *lines = self.path.read_text(encoding="utf-8").split("\n")
        try:
            found = dict(json.loads(head))
        except (ValueError, TypeError):
            found = {}
        refuse_other(self.path, found, mark)
        for line in lines[:-1]:
            number, result = json.loads(line)
            self.results[number] = result
        return lines[:-1]

    def keep(self, number: int, result: Plain) -> None:
        """Keep the `result` of the job of a `number`: after this it is on the disk."""
        self._file.write(json.dumps([number, result]) + "\n")
        self._file.flush()

    def remove(self) -> None:
        """Remove the file: the table holds everything."""
        self._file.close()
        self.path.unlink()
