"""What an answer to a study is, and the answers that there are."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from typing import Protocol, cast

import pandas
from heave_bags.report.figure import Figure
from heave_bringup.output import Part
from heave_node.parameters import ParameterError

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
