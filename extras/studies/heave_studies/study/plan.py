"""A study as it is stated: one scenario or several, the cases to be run, and what is asked of them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Protocol

import pandas
from heave_bringup.scenarios import Scenario, load_scenario
from heave_bringup.settings import Setting, make_setting
from heave_node.parameters import ParameterError
from heave_node.scenario import WILDCARD

from heave_studies.study.phases import DEPTH, PHASE, Phase
from heave_studies.study.sampling import Draws

LINK = ","
"""Between the places of parameters that take one value together: `virtual_winch.delay, winch_controller.delay`."""

BASE = "base"
"""Place at which cases differ in their scenario itself."""

Link = Mapping[str, tuple[object, ...]]
"""Parameters that move together: the values of each by place, all of one number."""


@dataclass(frozen=True)
class Case:
    """One run of a study."""

    number: int  # counted from 1
    seed: int  # of the run
    # values by place (`system.sea.peak_period`) by which it differs from the other cases
    settings: Mapping[str, object]
    is_nominal: bool = False  # the scenario itself, without the changes that every other case has

    @property
    def label(self) -> str:
        """Say in short what the case is."""
        if self.is_nominal:
            return f"seed={self.seed} nominal"
        differences = dict.fromkeys(
            f"{name.split('.', 1)[-1]}={_short(value)}" for name, value in self.settings.items()
        )
        return f"seed={self.seed} {' '.join(differences)}".strip()


More = tuple[int, Mapping[str, object]]
"""A further case: its seed, and its settings by place."""


class Refinement(Protocol):
    """What further cases the table so far asks for."""

    def size(self, cases: Sequence[Case], /) -> int:
        """Return the number of cases, at most, of which the first `cases` are some."""

    def more(self, cases: Sequence[Case], frame: pandas.DataFrame, /) -> list[More]:
        """Return further cases by the `frame` of all `cases` so far, in their order; empty: it is enough."""

    def words(self, frame: pandas.DataFrame, /) -> str:
        """Return what came of it by the `frame` of all cases, in a line."""


@dataclass(frozen=True)
class Search:
    """A search for the worst case in the space of the draws, which are its first generation."""

    figure: str  # that is made large
    runs: int = 480  # cases at most
    at_most: float = math.inf  # verdict FAILED where the figure exceeds it, SI


@dataclass(frozen=True)
class Study:
    """A study, read and checked."""

    path: Path  # of its file
    scenario: str  # shipped name or file
    title: str = ""  # for people
    duration: float | None = None  # simulated time of a case [s]; None takes the scenario's
    seeds: tuple[int, ...] = (1,)  # of every combination and draw
    # changes of the scenario in every case but nominal ones, by place (`system.sea.peak_period`)
    common: Mapping[str, object] = field(default_factory=dict)
    # criteria of every case, nominal ones too, by figure of merit; they replace the scenario's of that name
    wanted: Mapping[str, str] = field(default_factory=dict)
    vary: tuple[Link, ...] = ()  # of each entry the parameters move together; every combination of entries is a case
    phases: tuple[Phase, ...] = ()  # of a lift: each, in each of its pieces, is combined with the rest
    draws: Draws | None = None  # random cases; None: there are none
    has_nominal: bool = False  # whether the scenario itself runs before the draws
    has_adviser: bool = True  # whether the adviser takes part
    has_screening: bool = False  # whether cases that a screening covers are screened, see `heave_studies.batch`
    search: Search | None = None  # for the worst case; None: cases are as stated
    refinement: Refinement | None = None  # adds cases round by round; None: cases are as stated
    ask: Mapping[str, object] = field(default_factory=dict)  # what is made of the cases: `answer`, and its own keys
    duration_source: str = ""  # option that set the duration in the place of the file

    def settings_of(self, case: Case) -> list[Setting]:
        """Return a case as changes of the scenario; raises ParameterError for an unknown parameter."""
        phase, wanted = self.phase_of(case), self.wanted
        settings = [*self._common(case), Setting(WILDCARD, "seed", case.seed, f"{self.path}: seeds")]
        if phase is not None:
            where, wanted = f"{self.path}: {phase.name}", {**wanted, **phase.wanted}
            try:
                own = phase.settings(float(str(case.settings[DEPTH])), self._base)
            except ParameterError as error:
                raise ParameterError(f"{self.path}: {error}") from error
            settings += [make_setting(place, value, where) for place, value in own.items()]
        differing = {} if case.is_nominal else {**case.settings}
        for place in (BASE, PHASE, DEPTH):
            differing.pop(place, None)
        settings += [self._setting(place, value) for place, value in differing.items()]
        for kpi, bound in wanted.items():
            settings.append(make_setting(f"wanted.{kpi}", bound, f"{self.path}: wanted"))
        return settings

    def _common(self, case: Case | None = None) -> list[Setting]:
        """Return the changes of every case, but a nominal one."""
        changes = {} if case is not None and case.is_nominal else unlinked(self.common)
        settings = [self._setting(place, value) for place, value in changes.items()]
        if self.duration is not None:
            source = self.duration_source or f"{self.path}: duration"
            settings.append(Setting(WILDCARD, "duration", self.duration, source))
        return settings

    def _setting(self, place: str, value: object) -> Setting:
        """Return a change of a parameter, whose source names its node alone: an error in it names the parameter."""
        made = make_setting(place, value, f"{self.path}: {place}")
        node = place.removesuffix(made.name).rstrip(".")
        return replace(made, source=f"{self.path}: {node}" if node else str(self.path))

    @cached_property
    def _base(self) -> Scenario:
        """The scenario with the changes of every case."""
        return load_scenario(self.scenario, settings=self._common())

    def phase_of(self, case: Case) -> Phase | None:
        """Return the phase of a lift that a `case` is of; None: there are none."""
        return next((one for one in self.phases if one.name == case.settings.get(PHASE)), None)

    def scenario_of(self, case: Case) -> str:
        """Return the scenario of a `case`, a shipped name or a file."""
        return str(case.settings.get(BASE, self.scenario))

    def cases(self) -> Iterator[Case]:
        """Yield every case: nominal ones, then seeds within draws within combinations."""
        number = 0
        for seed in self.seeds if self.has_nominal else ():
            number += 1
            yield Case(number, seed, {}, is_nominal=True)
        drawn = [unlinked(one) for one in self.draws.values()] if self.draws else [{}]
        pieces = [{PHASE: one.name, DEPTH: depth} for one in self.phases for depth in one.depths(self._base)]
        for combination in itertools.product(pieces or [{}], *(_steps(link) for link in self.vary)):
            chosen = {place: value for step in combination for place, value in step.items()}
            for draw in drawn:
                for seed in self.seeds:
                    number += 1
                    yield Case(number, seed, {**chosen, **draw})

    def shortened(self, *, duration: float | None, draws: int | None, seeds: int | None = None) -> Study:
        """Return the study with another duration, only its first draws, or another number of seeds.

        Parameters
        ----------
        duration : of a case [s]; None leaves what the file says
        draws : number of draws; None leaves what the file says
        seeds : number of seeds, counted from 1; None leaves what the file says
        """
        fewer = self.draws
        if fewer is not None and draws is not None:
            fewer = replace(fewer, first=min(draws, fewer.count))
        return replace(
            self,
            duration=self.duration if duration is None else duration,
            duration_source="" if duration is None else f"--duration {duration:g}",
            draws=fewer,
            seeds=self.seeds if seeds is None else tuple(range(1, seeds + 1)),
        )


def unlinked(values: Mapping[str, object]) -> dict[str, object]:
    """Return the `values` with one place to a name: linked names (`a.x, b.x`) take their value each."""
    return {place.strip(): value for name, value in values.items() for place in name.split(LINK)}


def _steps(link: Link) -> list[dict[str, object]]:
    """Return the values of linked parameters, one mapping for each step that they take together."""
    steps = zip(*link.values(), strict=True)
    return [unlinked(dict(zip(link, values, strict=True))) for values in steps]


def _short(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
