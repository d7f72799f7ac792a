"""What an answer to a study is, the answers that there are, and the criteria that a study of seas is judged by."""

from __future__ import annotations

import difflib
import html
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Protocol, cast

import pandas
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bags.analyse.run_words import lift_facts
from heave_bags.analyse.verdict import required_words
from heave_bags.report.figure import Figure
from heave_bags.report.parts import notice, table
from heave_bags.report.report import place_figure
from heave_bringup.commands.models.loads import strengths_in
from heave_bringup.output import Part, make_table
from heave_bringup.run.criteria import refuse_unknown
from heave_bringup.scenarios import Scenario, load_scenario
from heave_node.criteria import Criterion
from heave_node.parameters import ParameterError, flatten
from heave_node.sheet import Column, Sheet

from heave_studies.operability.limits import HEIGHT, PERIOD
from heave_studies.study.plan import Case, Study

ANSWERS = {
    "cases": "every case, a summary with confidence intervals, and which parameters matter",
    "limits": "the largest sea in which the criteria are met",
    "lift": "the same for each phase of a lift, compared with a forecast",
    "sizing": "what a larger winch is worth, and what an hour asks of it",
    "extremes": "the largest motion and tension expected in a number of hours",
}
"""Answers by name, each a module of this folder, with what it says."""
DEFAULT = "cases"

Ask = Mapping[str, object]
"""What is asked: the values of an answer's own keys."""


@dataclass(frozen=True)
class Section:
    """A part of an answer: title, words, what must be seen, a table, figures; in a terminal without the figures."""

    title: str = ""  # above it
    head: Sequence[str] = ()  # of the table; empty: there is none
    rows: Sequence[Sequence[str]] = ()  # cells of the table
    texts: int = 1  # first columns of the table that hold text
    last_is_text: bool = False  # the last column does
    words: Sequence[str] = ()  # above the table, a line each
    notices: Sequence[str] = ()  # a line each, that must be seen
    figures: Sequence[Figure] = ()  # below the table
    in_terminal: bool = True  # a terminal shows it too

    @property
    def parts(self) -> list[Part]:
        """It in a terminal."""
        if not self.in_terminal:
            return []
        lines = [self.title, *self.words, *(f"caution: {words}" for words in self.notices)]
        texts = [*self.head[: self.texts], *(self.head[-1:] if self.last_is_text else [])]
        shown = [make_table(self.head, self.rows, texts=texts)] if self.head else []
        return [*(["\n".join(filter(None, lines))] if any(lines) else []), *shown]

    def html(self, drawn: list[Figure]) -> str:
        """Return it on a page, whose figures so far are those that are `drawn`: its own are added."""
        parts = [f"<h2>{html.escape(self.title)}</h2>"] if self.title else []
        parts += [f'<p class="caption">{html.escape(words)}</p>' for words in self.words]
        parts += [notice(words) for words in self.notices]
        parts += [table(self.head, self.rows, texts=self.texts, last_is_text=self.last_is_text)] if self.head else []
        return "\n".join([*parts, *(place_figure(figure, drawn) for figure in self.figures)])


@dataclass(frozen=True)
class Page:
    """A part of an answer that only a page shows."""

    html: str  # of it


@dataclass(frozen=True)
class Found:
    """An answer."""

    sections: Sequence[Section | Page | Part]  # for people: of the page and a terminal, of the page, of a terminal
    data: Mapping[str, object]  # for machines
    footer: str = ""  # of the page
    failures: Sequence[str] = ()  # why the verdict is FAILED, in words
    judged: int = 0  # cases that the answer stands on
    worst: int | None = None  # the case worth a run over ROS, the last that is named in a terminal

    @property
    def parts(self) -> list[Part]:
        """What a terminal shows."""
        found: list[Part] = []
        for one in self.sections:
            found += one.parts if isinstance(one, Section) else [] if isinstance(one, Page) else [one]
        return found

    def page(self) -> tuple[list[str], list[Figure]]:
        """Return the HTML of the page, with the places of its figures, and these."""
        drawn: list[Figure] = []
        body = [
            one.html(drawn) if isinstance(one, Section) else one.html
            for one in self.sections
            if isinstance(one, Section | Page)
        ]
        return body, drawn


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


def number_in(ask: Ask, key: str) -> float:
    """Return the value of a `key` among what is asked, `ask`, as a number; raise ParameterError for anything else."""
    try:
        return float(str(ask[key]))
    except ValueError as error:
        raise ParameterError(f"ask: {key} = {ask[key]}: must be a number") from error


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
    return _loaded(study, next(iter(study.cases())))


Criteria = Mapping[str, Sequence[Criterion]]
"""Criteria by phase of a lift, or by scenario; "": of all cases."""


def criteria_of(study: Study, without: Sequence[str] = ()) -> Criteria:
    """Return the criteria of a `study`, its scenario's own but for those on figures `without` which it does not name.

    In a phase of a lift those of study and phase hold alone. The safety factors of parts whose strength is stated are
    among them.

    Raises ParameterError where there are none.
    """
    firsts = {"" if one is None else one.name: case for case in study.cases() for one in [study.phase_of(case)]}
    found = {}
    for name, case in firsts.items():
        scenario, phase = _loaded(study, case), study.phase_of(case)
        for one in scenario.wanted:
            refuse_unknown(one, f"{study.path}: wanted")
        stated = {*study.wanted, *(phase.wanted if phase else ())}
        own = [one for one in scenario.wanted if one.kpi in stated or not (phase or one.kpi in without)]
        if not own:
            where = f"{name}: " if name else ""
            raise ParameterError(
                f"{study.path}: {where}no criteria: give the study some (wanted), or --require, as in "
                "'unit_sigma_m<0.05'"
            )
        found[name] = with_strengths(own, scenario)
    return found


def with_strengths(criteria: Sequence[Criterion], scenario: Scenario) -> list[Criterion]:
    """Return `criteria` with the safety factor that each part of a `scenario` is to have, where its strength is stated.

    Any run with less fails, so that a criterion of the scenario that allows less gives way.
    """
    factors = {one.key: Criterion(one.key, ">=", one.required) for one in strengths_in(scenario)}
    kept = [one for one in criteria if one.kpi not in factors or one.bound > factors[one.kpi].bound]
    return [*kept, *(one for key, one in factors.items() if key not in {own.kpi for own in kept})]


def criteria_of_cases(study: Study) -> Criteria:
    """Return the criteria that the cases of a `study` are judged by, of each scenario that they have."""
    firsts = {Path(study.scenario_of(case)).stem: case for case in study.cases()}
    loaded = {name: _loaded(study, case) for name, case in firsts.items()}
    return {name: with_strengths(one.wanted, one) for name, one in loaded.items()}


CRITERIA = Sheet(
    Column("figure of merit", lambda one: DEFINITION_OF[one.kpi].title), Column("required", required_words)
)


def criteria_section(criteria: Criteria) -> Section:
    """Return the table of `criteria`; those that all have in common once."""
    groups = list(criteria.items())[:1] if len(set(map(repr, criteria.values()))) == 1 else list(criteria.items())
    head, rows = CRITERIA.headings, [cells for _, of in groups for cells in CRITERIA.cells(of)]
    if len(groups) > 1:
        head = ["of", *head]
        rows = [[name, *cells] for name, of in groups for cells in CRITERIA.cells(of)]
    return Section("Criteria", head, rows or [["none", *"-" * (len(head) - 1)]], texts=len(head))


def lift_of(study: Study) -> dict[str, str]:
    """Return what the cases of a `study` are of, as far as they have it in common, and what differs: name -> words."""
    cases = list(study.cases())
    ends = [
        lift_facts({node: flatten(given) for node, given in _loaded(study, case).parameters.items()})
        for case in (cases[0], cases[-1])
    ]
    run = first_scenario(study).run
    varied = {place: values for link in study.vary for place, values in link.items()}
    words = [f"{place} {', '.join(_value(one) for one in values)}" for place, values in varied.items()]
    seeds = ", ".join(map(str, study.seeds[:MOST_SEEDS])) + (", ..." if len(study.seeds) > MOST_SEEDS else "")
    found = {
        "scenario": ", ".join(dict.fromkeys(study.scenario_of(case) for case in cases)),
        **{name: text for name, text in ends[0].items() if ends[1].get(name) == text},
        "set": ", ".join(f"{place} {_value(value)}" for place, value in study.common.items()),
        "varied": "; ".join(words),
        "drawn": "" if study.draws is None else f"{study.draws.count} draws of {', '.join(study.draws.names)}",
        "runs": f"{run.duration:g} s each, figures from {run.transient:g} s on; seeds {seeds}",
    }
    return {name: text for name, text in found.items() if text}


MOST_SEEDS = 10
"""Seeds that are listed."""


def _loaded(study: Study, case: Case) -> Scenario:
    return load_scenario(study.scenario_of(case), settings=study.settings_of(case))


def _value(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def as_path(value: object) -> Path | None:
    """Return the file that a `value` of `--ask` names; None where it names none."""
    return None if value is None else Path(str(value))
