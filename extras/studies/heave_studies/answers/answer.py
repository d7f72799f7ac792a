"""What an answer to a study is, the answers that there are, and the criteria that a study of seas is judged by."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Protocol, cast

import pandas
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bags.analyse.verdict import required_words
from heave_bags.report.figure import Figure
from heave_bags.report.parts import table
from heave_bringup.output import Part
from heave_bringup.run.criteria import refuse_unknown
from heave_bringup.scenarios import Scenario, load_scenario
from heave_node.criteria import Criterion
from heave_node.parameters import ParameterError

from heave_studies.operability.limits import HEIGHT, PERIOD
from heave_studies.study.plan import Study

ANSWERS = {
    "cases": "every case, a summary with confidence intervals, and which parameters matter",
    "limits": "the largest sea in which the criteria are met, and the waiting time for it",
    "sizing": "what a larger winch is worth, and what it costs",
    "extremes": "the largest motion and tension expected in a number of hours",
}
"""Answers by name, each a module of this folder, with what it says."""
DEFAULT = "cases"

Ask = Mapping[str, object]
"""What is asked: the values of an answer's own keys."""


@dataclass(frozen=True)
class Found:
    """An answer."""

    parts: Sequence[Part]  # text and tables for people
    data: Mapping[str, object]  # for machines
    body: Sequence[str] = ()  # HTML of the page, with the places of the figures
    figures: Sequence[Figure] = ()  # in the order of their places
    footer: str = ""  # of the page
    failures: Sequence[str] = ()  # why the verdict is FAILED, in words
    judged: int = 0  # cases that the answer stands on


class Answer(Protocol):
    """A module of this folder."""

    @property
    def KEYS(self) -> Mapping[str, object]:
        """What may be asked, with what holds where it is not."""

    def prepare(self, study: Study, ask: Ask, /) -> Study:
        """Return the `study` that the answer needs; raise ParameterError for what is wrong with it, or with `ask`."""

    def answer(self, study: Study, frame: pandas.DataFrame, ask: Ask, /) -> Found:
        """Return the answer that the table of a `study`, its `frame`, gives to what is asked: `ask`."""


@dataclass(frozen=True)
class Asked:
    """An answer that is asked of a study."""

    study: Study  # prepared for it
    module: Answer  # that gives it
    ask: Ask = field(default_factory=dict)  # every one of its keys

    def of(self, frame: pandas.DataFrame) -> Found:
        """Return the answer that the table of the study, its `frame`, gives."""
        return self.module.answer(self.study, frame, self.ask)


def answer_of(name: str) -> Answer:
    """Return the module of the answer of a `name`, one of ANSWERS."""
    return cast(Answer, import_module(f"heave_studies.answers.{name}"))


def own_keys(known: Ask, given: Ask, where: str) -> dict[str, object]:
    """Return every key that an answer has, as it is `given` or `known`; raise ParameterError for another one.

    Parameters
    ----------
    known : the answer's keys, with what holds where they are not given
    given : by the user
    where : opens the message: the file
    """
    for key in given:
        if key not in known:
            near = difflib.get_close_matches(key, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"known: {', '.join(known)}"
            raise ParameterError(f"{where}: ask: there is no {key}; {hint}")
    return {**known, **given}


def asked_of(study: Study) -> Asked:
    """Return the answer that a `study` asks for, with the study prepared; raise ParameterError for what is none."""
    given = dict(study.ask)
    name = str(given.pop("answer", DEFAULT))
    if name not in ANSWERS:
        raise ParameterError(f"{study.path}: ask: answer = {name}: must be one of {', '.join(ANSWERS)}")
    module = answer_of(name)
    ask = own_keys(module.KEYS, given, str(study.path))
    return Asked(module.prepare(study, ask), module, ask)


def check_seas(study: Study, without: Sequence[str] = ()) -> None:
    """Refuse a study whose seas are no grid, or that has no criteria but for `without`, before a case is run."""
    for place in (HEIGHT, PERIOD):
        values = [float(str(one)) for one in next((link[place] for link in study.vary if place in link), ())]
        if len(values) < 2 or values != sorted(set(values)) or not values[0] > 0.0:
            raise ParameterError(
                f"{study.path}: vary: {place}: needs at least two values above 0 that rise, not {values}"
            )
    criteria_of(study, without)


def first_scenario(study: Study) -> Scenario:
    """Return the scenario of the first case of a `study`."""
    first = next(iter(study.cases()))
    return load_scenario(study.scenario_of(first), settings=study.settings_of(first))


def criteria_of(study: Study, without: Sequence[str] = ()) -> list[Criterion]:
    """Return the criteria of a `study`, its scenario's own but for those on figures `without` which it does not name.

    Raises ParameterError where there are none.
    """
    wanted = first_scenario(study).wanted
    for one in wanted:
        refuse_unknown(one, f"{study.path}: wanted")
    found = [one for one in wanted if one.kpi not in without or one.kpi in study.wanted]
    if not found:
        raise ParameterError("no criteria: give the study some (wanted), or --require, as in 'unit_sigma_m<0.05'")
    return found


def criteria_table(criteria: Sequence[Criterion]) -> str:
    """Return the `criteria` of a study as HTML, under a heading."""
    rows = [[DEFINITION_OF[criterion.kpi].title, required_words(criterion)] for criterion in criteria]
    return f"<h2>Criteria</h2>{table(['figure of merit', 'required'], rows or [['none', '-']], texts=2)}"


def criteria_of_cases(study: Study) -> str:
    """Return the criteria that the cases of a `study` are judged by as HTML: those of each scenario that they have."""
    firsts = {study.scenario_of(case): case for case in study.cases()}
    found = {name: load_scenario(name, settings=study.settings_of(case)).wanted for name, case in firsts.items()}
    if len({repr(one) for one in found.values()}) == 1:
        return criteria_table(next(iter(found.values())))
    rows = [
        [Path(name).stem, DEFINITION_OF[one.kpi].title, required_words(one)] for name in found for one in found[name]
    ]
    return f"<h2>Criteria</h2>{table(['scenario', 'figure of merit', 'required'], rows, texts=3)}"


def as_path(value: object) -> Path | None:
    """Return the file that a `value` of `--ask` names; None where it names none."""
    return None if value is None else Path(str(value))
