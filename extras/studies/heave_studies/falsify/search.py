"""The search: differential evolution over the unit cube of a campaign's draws, by a budget of time, kept as it comes.

Storn, R. and Price, K. (1997), Differential evolution, Journal of Global Optimization 11, 341-359, as scipy has it. A
seed fixes which points are asked for, and every answer is in the journal: a search that was ended asks for the same
points again, is answered from there, and goes on where it was.
"""

from __future__ import annotations

import hashlib
import math
import os
import time
from collections.abc import Callable, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from heave_node.interface.alarm import Severity
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError
from scipy.optimize import differential_evolution

from heave_studies.campaign.journal import KeptResults
from heave_studies.campaign.plan import Campaign, Case, unlinked
from heave_studies.campaign.runs import Task, make_tasks
from heave_studies.campaign.sampling import Draws
from heave_studies.falsify.objective import Minute, worst_minute
from heave_studies.workers.pool import worker_pool

GENERATIONS = 100_000
"""The budget of time ends a search, not a number of generations."""
LOOK = 0.5
"""Wall time between two looks at the budget [s]."""
LEAST_POPULATION = 5
"""Points that differential evolution needs at least."""


class _OverError(Exception):
    """The budget of time is spent."""


@dataclass(frozen=True)
class Found:
    """A case that was run."""

    number: int  # in the order in which it was asked for first, from 1
    values: Mapping[str, object]  # by place
    minute: Minute  # its worst


class Search:
    """Looks for the worst case of a campaign's space.

    Parameters
    ----------
    campaign : with draws; their number is that of the population
    severity : from which on an alarm announces
    journal : file that keeps the answers
    mark : identifies the search

    Attributes
    ----------
    seconds : wall time of a generation, by the cases that were run and not known before [s]; NaN: none was

    Raises ParameterError for a space that is none, or the journal of another search.
    """

    def __init__(self, campaign: Campaign, severity: Severity, journal: Path, mark: Mapping[str, str]) -> None:
        if campaign.draws is None:
            raise ParameterError(f"{campaign.path}: has nothing to search: give draw with uniform, log_uniform, choose")
        if campaign.draws.count < LEAST_POPULATION:
            raise ParameterError(f"{campaign.path}: draw.count must be at least {LEAST_POPULATION}")
        self.campaign, self.draws, self.severity = campaign, campaign.draws, severity
        self._kept = KeptResults(journal, mark)
        self._cases: dict[str, Found] = {}
        self._new = 0
        self.seconds = math.nan

    @property
    def generations(self) -> str:
        """Cases so far, in words with the generations that they are."""
        whole = self.asked // self.draws.count
        done = f"{whole} generation{'s' if whole > 1 else ''}" if whole else "less than one generation"
        return f"{self.asked} case{'s' if self.asked > 1 else ''}, {done} of {self.draws.count}"

    @property
    def found(self) -> list[Found]:
        """Cases so far, the worst first."""
        return sorted(self._cases.values(), key=lambda one: (-one.minute.ratio, one.number))

    @property
    def asked(self) -> int:
        """Number of different points so far."""
        return len(self._cases)

    def task(self, found: Found) -> Task:
        """Return the case that was `found`, ready to run."""
        (task,) = make_tasks(self.campaign, [self._case(found.number, found.values)])
        return task

    def run(self, budget: float, processes: int | None, show: Callable[[int, float, float], None]) -> bool:
        """Search until the budget is spent; return whether the search has ended by itself before.

        Parameters
        ----------
        budget : wall time [s]
        processes : number of worker processes; None: one per processor
        show : called with the number of cases, the worst ratio so far, and the share of the budget that is spent
        """
        begun = time.monotonic()

        def spent() -> float:
            return (time.monotonic() - begun) / budget

        try:
            with self._kept, worker_pool(processes or os.cpu_count() or 1) as pool:
                self._evolve(lambda asked: self._answers(asked, pool, spent, show))
        except _OverError:  # which has ended the workers in the midst of their cases
            return False
        finally:
            self.seconds = (time.monotonic() - begun) / self._new * self.draws.count if self._new else math.nan
        return True

    def _evolve(self, answers: Callable[[Array], list[float]]) -> None:
        """Let differential evolution ask for points of the unit cube, shape (n, dimensions), until it is over."""
        points = self.draws.points()
        differential_evolution(
            lambda _: 0.0,
            [(0.0, 1.0)] * points.shape[1],
            init=points,
            maxiter=GENERATIONS,
            tol=0.0,
            polish=False,
            updating="deferred",
            workers=lambda _, asked: answers(np.array(list(asked))),
            seed=self.draws.seed,
        )

    def _answers(
        self,
        points: Array,
        pool: ProcessPoolExecutor,
        spent: Callable[[], float],
        show: Callable[[int, float, float], None],
    ) -> list[float]:
        """Return what differential evolution makes small: the ratios of the points, negative."""
        keys = [key_of(point) for point in points]
        new = {key: point for key, point in zip(keys, points, strict=True) if key not in self._cases}
        waiting: dict[Future[Minute], tuple[str, Found]] = {}
        for number, (key, point) in enumerate(new.items(), len(self._cases) + 1):
            found = Found(number, unlinked(self.draws.at(point)), Minute(0.0))
            known = self._kept.results.get(key)
            if known is not None:
                self._cases[key] = replace(found, minute=_minute_of(known))
            else:
                waiting[pool.submit(worst_minute, self.task(found), self.severity)] = (key, found)
        while waiting:
            for done in wait(waiting, LOOK, return_when=FIRST_COMPLETED).done:
                key, found = waiting.pop(done)
                self._cases[key] = replace(found, minute=done.result())
                self._kept.keep({"number": key, **_plain(done.result())})
                self._new += 1
            show(self.asked, max((one.minute.ratio for one in self._cases.values()), default=0.0), min(spent(), 1.0))
            if waiting and spent() >= 1.0:
                raise _OverError
        return [-self._cases[key].minute.ratio for key in keys]

    def _case(self, number: int, values: Mapping[str, object]) -> Case:
        return Case(number, self.campaign.seeds[0], values)


def key_of(point: Array) -> str:
    """Return what identifies a `point` of the unit cube, shape (dimensions,), to the last bit."""
    return hashlib.sha256(np.asarray(point, dtype=np.float64).tobytes()).hexdigest()[:24]


def _plain(minute: Minute) -> dict[str, object]:
    return {name: None if value != value else value for name, value in asdict(minute).items()}  # noqa: PLR0124 - NaN


def _minute_of(kept: Mapping[str, Any]) -> Minute:
    def value(name: str) -> Any:
        one = kept[name]
        return math.nan if one is None else tuple(one) if isinstance(one, list) else one

    return Minute(**{field.name: value(field.name) for field in fields(Minute)})


def over_scenario(campaign: Campaign, scenario: str) -> Campaign:
    """Return a campaign's space over another `scenario`; changes that belong to its own are kept."""
    return replace(campaign, scenario=scenario)


def population(campaign: Campaign, count: int | None) -> Campaign:
    """Return the campaign with a population of another `count`; None leaves what the file says."""
    draws: Draws | None = campaign.draws
    return campaign if count is None or draws is None else replace(campaign, draws=replace(draws, count=count))
