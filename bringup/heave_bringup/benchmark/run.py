"""Runs entrants on cases: the same seeds for all, in worker processes."""

from __future__ import annotations

import functools
import os
from collections.abc import Generator, Sequence
from concurrent.futures import as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from pathlib import Path

from heave_node.parameters import ParameterError

from heave_bringup.benchmark.case import Case, definition_of, digest
from heave_bringup.benchmark.entrants.table import Named
from heave_bringup.benchmark.interface import Command, Controller, Measurement
from heave_bringup.benchmark.outcome import figures_of
from heave_bringup.benchmark.published_cases import published_cases
from heave_bringup.benchmark.suite_cases import suite_cases
from heave_bringup.errors import CommandError
from heave_bringup.workers.pool import worker_pool


@functools.cache
def all_cases(records: Path | None) -> dict[str, Case]:
    """Return every case by name, in order; `records` is the folder of the published records."""
    return {case.name: case for case in (*suite_cases(), *published_cases(records))}


@dataclass(frozen=True)
class Task:
    """One run: entrant, case, seed, and what the user changed.

    Attributes
    ----------
    entrant, case : by name
    seed : one of the case's
    duration : of the run at most [s]; None: the case's own
    records : folder of the published records; None: there is none
    """

    entrant: Named
    case: str
    seed: int
    duration: float | None
    records: Path | None

    def case_of(self) -> Case:
        """Return the case as it is run."""
        case = all_cases(self.records)[self.case]
        return case if self.duration is None else case.shortened(self.duration)


@dataclass(frozen=True)
class Result:
    """What a run came to.

    Attributes
    ----------
    task : the run
    figures : of the run; empty where it failed
    failure : why it failed, in one line
    problem : digest of what defines the run, the entrant apart
    is_reference : the entrant was given the future
    """

    task: Task
    figures: dict[str, float] = field(default_factory=dict)
    failure: str = ""
    problem: str = ""
    is_reference: bool = False


def check(tasks: Sequence[Task]) -> None:
    """Load every entrant of `tasks`, and make each case once; raises ParameterError for the first that cannot be."""
    for entrant in {task.entrant.name: task.entrant for task in tasks}.values():
        entrant.load()
    for task in {(task.case): task for task in tasks}.values():
        try:
            case = task.case_of()
        except ValueError as error:
            raise ParameterError(f"--duration: {error}") from error
        case.make(task.seed, case.duration)


def run_all(tasks: Sequence[Task], processes: int | None) -> Generator[Result, None, None]:
    """Run `tasks` in this many `processes` (None: one per processor) and yield the results as they come.

    Raises CommandError where a process is killed.
    """
    workers = min(len(tasks), processes or os.cpu_count() or 1)
    if workers <= 1:
        yield from map(run_one, tasks)
        return
    try:
        with worker_pool(workers) as pool:
            pending = [pool.submit(run_one, task) for task in tasks]
            for finished in as_completed(pending):
                yield finished.result()
    except BrokenProcessPool as error:
        raise CommandError(
            "a process ended without a result: it was killed, or out of memory (--processes 1)"
        ) from error


class _Checked:
    """An entrant whose commands are checked: what is no Command is refused in words that name the mistake.

    Parameters
    ----------
    controller : the entrant
    """

    def __init__(self, controller: Controller) -> None:
        if not callable(getattr(controller, "step", None)):
            raise TypeError(f"{type(controller).__name__} has no method step(measurement)")
        self._controller = controller

    def step(self, measurement: Measurement) -> Command:
        """See `Controller.step`."""
        command = self._controller.step(measurement)
        if not isinstance(command, Command):
            raise TypeError(f"step must return a Command; it returned {type(command).__name__}")
        return command


def run_one(task: Task) -> Result:
    """Run one task; what the entrant does wrong is its result, not ours."""
    case = task.case_of()
    problem = case.make(task.seed, case.duration)
    definition = digest(definition_of(case, problem))
    entrant = task.entrant.load()
    is_reference = bool(getattr(entrant, "needs_preview", False))
    try:
        controller = entrant(problem.facts_with_preview() if is_reference else problem.facts)
        outcome = problem.world.run(_Checked(controller))
        figures = figures_of(outcome, case.start, case.end)
    except Exception as error:  # an entrant may do anything; the others' results are kept
        words = " ".join(str(error).split())
        return Result(task, failure=f"{type(error).__name__}: {words}"[:200], problem=definition)
    return Result(task, figures, problem=definition, is_reference=is_reference)
