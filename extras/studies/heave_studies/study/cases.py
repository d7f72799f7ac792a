"""A study of cases: one loop each, or a screening, in this process or another, and the table of them."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import groupby
from pathlib import Path

import numpy as np
import pandas
from heave_bringup.scenarios import named_files
from heave_node.errors import one_line
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError

from heave_studies.batch.lifts import LiftBatch
from heave_studies.study import sampling
from heave_studies.study.case_file import digest_of
from heave_studies.study.cost import LIFTS, LOOP, START, Meter
from heave_studies.study.engine import SETTLED
from heave_studies.study.plan import Case, Study, unlinked
from heave_studies.study.runs import Task, judge, make_tasks, result_of, run_task
from heave_studies.study.table import FLAG, SCREENED, SILENT, case_frame
from heave_studies.study.workers import FAILURE, Job, Plain


@dataclass
class Cases:
    """The cases of a study, as the engine takes them (`heave_studies.study.engine.Kind`)."""

    study: Study  # what is run
    is_local: bool = False  # cases run anywhere
    _tasks: list[Task] = field(default_factory=list)  # so far, in the order of their numbers

    def __post_init__(self) -> None:
        if self.study.search is not None:
            sampling.CMA()
            if self.study.draws is None or self.study.draws.count < sampling.LEAST_POPULATION:
                raise ParameterError(f"{self.study.path}: draw.count must be at least {sampling.LEAST_POPULATION}")
        self._first = make_tasks(self.study, list(self.study.cases()))

    @property
    def name(self) -> str:
        """What its table and page are called."""
        return self.study.title or self.study.path.stem

    @cached_property
    def size(self) -> int:
        """Number of cases, at most."""
        if self.study.search is not None:
            return self.study.search.runs
        refinement = self.study.refinement
        return len(self._first) if refinement is None else refinement.size([task.case for task in self._first])

    @property
    def is_open(self) -> bool:
        """Whether there may be fewer: a refinement ends when it is done."""
        return self.study.refinement is not None

    @property
    def identity(self) -> str:
        """What identifies the results: every value of every case, and the files that they read."""
        of = self.study
        digest = hashlib.sha256(repr((of.search, of.draws, of.refinement, of.has_adviser, of.has_screening)).encode())
        for task in self._first:
            digest.update(task.values.encode())
        for path in sorted({path for task in self._first if not task.alike for path in named_files(task.scenario)}):
            digest.update(digest_of(Path(path)).encode())
        return digest.hexdigest()

    def rounds(self, results: Mapping[int, Plain]) -> Iterator[list[Job]]:
        """Yield the jobs; those of a refinement or a search round by round, each when the last is in `results`."""
        self._tasks = list(self._first)
        if self.study.search is None:
            new = self._tasks
            while new:
                if self.study.has_screening:
                    yield list(screening_jobs(new))
                known = screened_results(results)
                yield [_job(task) for task in new if task.case.number not in known]
                new = self._refined(results)
                self._tasks = [*self._tasks, *new]
            return
        draws, wanted = self.study.draws, self.study.search
        assert draws is not None
        last: list[Task] = []

        def values() -> Array:
            return np.array([_figure(results[task.case.number], wanted.figure) for task in last])

        for points in sampling.generations(draws, wanted.runs, values):
            if last:
                made = [unlinked(draws.at(point)) for point in points]
                cases = [Case(len(self._tasks) + n, self.study.seeds[0], one) for n, one in enumerate(made, 1)]
                last = make_tasks(self.study, cases)
                self._tasks += last
            else:
                last = self._tasks
            yield [_job(task) for task in last]

    def _refined(self, results: Mapping[int, Plain]) -> list[Task]:
        """Return the further cases that the `results` so far ask for."""
        if self.study.refinement is None:
            return []
        cases = [task.case for task in self._tasks]
        asked = self.study.refinement.more(cases, self.frame(results))
        return make_tasks(self.study, [Case(len(cases) + n, *more) for n, more in enumerate(asked, 1)])

    def frame(self, results: Mapping[int, Plain]) -> pandas.DataFrame:
        """Return a row for each case, from their `results`."""
        known = screened_results(results)
        found = [result_of(task.case, known[task.case.number]) for task in self._tasks]
        return case_frame(self._tasks, found)


def _job(task: Task) -> Job:
    return Job(task.case.number, task.case.label, partial(_run, task))


def _run(task: Task) -> Plain:
    return run_task(task).to_plain()


def _figure(result: Plain, name: str) -> float:
    """Return the figure of a `result` that a search makes large; one that is not known is the least of all."""
    if result.get(FAILURE):
        return -1.0
    value = float(result["minute"][0]) if name == SILENT else float(result["kpis"][name])
    return value if math.isfinite(value) else -1.0


def screening_jobs(tasks: Sequence[Task]) -> Iterator[Job]:
    """Yield a job for the `tasks` of each combination, its number that of the first one, below 0."""
    for _, of_one in groupby(tasks, key=lambda task: (task.alike or task).case.number):
        same = list(of_one)
        first = same[0].case
        more = f" and {len(same) - 1} more {'seed' if len(same) == 2 else 'seeds'}" if len(same) > 1 else ""
        yield Job(-first.number, f"screened, {first.label}{more}", partial(screen, same))


def screen(tasks: Sequence[Task]) -> Plain:
    """Return what the cases of `tasks`, which differ by their seeds alone, come to where a screening covers them.

    What each came to, or why it belongs into the full loop, is there by number.
    """
    together = Meter()
    try:
        with together.of(START):
            batch = LiftBatch(tasks[0].scenario)
        with together.of(LOOP):
            flown = batch.fly([task.scenario.run.seed for task in tasks])
    except Exception as error:  # what cannot be screened may run in full, and says there what is wrong
        return {LIFTS: {str(task.case.number): {FLAG: one_line(error)} for task in tasks}, SETTLED: 0}
    lifts = {
        str(task.case.number): {FLAG: lift.flag}
        if lift.flag
        else {**judge(task, lift.record, lift.strain, together.of_one(len(tasks))).to_plain(), "is_screened": True}
        for task, lift in zip(tasks, flown, strict=True)
    }
    return {LIFTS: lifts, SETTLED: sum(FAILURE in one for one in lifts.values())}


def screened_results(results: Mapping[int, Plain]) -> dict[int, Plain]:
    """Return the results by case that stand among the `results` of a study with their screenings."""
    lifts = {int(n): one for number, of in results.items() if number < 0 for n, one in of.get(LIFTS, {}).items()}
    return {number: one for number, one in lifts.items() if FAILURE in one} | {
        number: {**one, FLAG: lifts.get(number, {}).get(FLAG, "")} for number, one in results.items() if number > 0
    }


def screening_words(frame: pandas.DataFrame) -> str:
    """Return how many cases of a `frame` were screened, and why the others were not; "" where none was to be."""
    if SCREENED not in frame or not (frame[SCREENED].any() or (frame[FLAG] != "").any()):
        return ""
    number = int(frame[SCREENED].sum())
    why = frame.loc[~frame[SCREENED], FLAG].value_counts()
    reasons = ", ".join(f"{words} ({count})" for words, count in why.head(6).items())
    rest = f"; in the full loop: {reasons}" if len(why) else ""
    how = "the plant under a fixed law, without adviser, modes, gates"
    return f"{number} of {len(frame)} cases were screened: {how}{rest}"
