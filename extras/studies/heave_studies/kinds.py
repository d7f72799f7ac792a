"""Kinds of studies by what their file holds: cases of a scenario, steps of an acceptance test, draws."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from types import ModuleType

import pandas
from heave_bringup.replacements import EXTERNAL, parse_replacements
from heave_bringup.scenarios import description_of
from heave_bringup.settings import parse_setting
from heave_devices.adapt.shipped import find_map
from heave_node.files.bounded_yaml import parse_yaml
from heave_node.files.given_files import as_mapping, read_given, shipped_files
from heave_node.parameters import ParameterError

from heave_studies.accept.procedure import read_head
from heave_studies.accept.study import Acceptance, Parts
from heave_studies.answers import acceptance, promise
from heave_studies.answers.answer import ANSWERS, Found, answer_of, asked_of, lift_of, own_keys
from heave_studies.promise.study import read_promise
from heave_studies.study.cases import Cases
from heave_studies.study.engine import Kind
from heave_studies.study.study_file import FOLDER, asked_values, find_study, read_study, study_of, with_options

OF_FILES: Mapping[str, tuple[str, ModuleType]] = {
    "steps": ("an acceptance test of simulated or real parts", acceptance),
    "promise": ("whether the load is never worse than with the winch locked, over random draws", promise),
}
"""Kinds by a key of their file, with what they ask, and the module that answers."""


@dataclass(frozen=True)
class Options:
    """What a user asks for."""

    study: str  # shipped name or file; with `vary` also a scenario
    scenario: str | None = None  # in the place of the study's
    settings: Sequence[str] = ()  # PLACE=VALUE each
    vary: Sequence[str] = ()  # PLACE=VALUE,VALUE,... each
    require: Sequence[str] = ()  # KPI<VALUE each
    ask: Sequence[str] = ()  # KEY=VALUE each
    seeds: int | None = None  # number of them, in the place of the file's
    draws: int | None = None  # only the first of them
    duration: float | None = None  # of a case, in the place of the file's [s]
    folder: Path | None = None  # of what the study leaves; None: one by its name
    is_full: bool = False  # every case runs in the full loop

    @property
    def own_folder(self) -> Path:
        """The folder by the names of study and scenario."""
        return Path("studies") / "-".join(Path(name).stem for name in (self.study, self.scenario) if name)

    def refuse(self, *names: str) -> None:
        """Raise ParameterError for options (`names`) that a kind of study does not take."""
        for name in names:
            if getattr(self, name):
                option = "--set" if name == "settings" else name if name == "scenario" else f"--{name}"
                raise ParameterError(f"{option}: is not for {self.study}: write it into its file")


@dataclass(frozen=True)
class Opened:
    """A study that is ready to run."""

    kind: Kind  # what the engine runs
    answer: Callable[[pandas.DataFrame], Found]  # to its table
    folder: Path  # of what it leaves
    facts: Mapping[str, str] = field(default_factory=dict)  # what identifies it beside the engine's, by name
    lead: str = ""  # what it asks, in a line
    lift: Mapping[str, str] = field(default_factory=dict)  # what was run, in words by name


def open_study(options: Options) -> Opened:
    """Return the study that `options` ask for; raise ParameterError, in one line, for what is wrong with it."""
    name = options.study
    if name not in shipped_files(FOLDER) and options.vary and options.scenario is None and not is_study(Path(name)):
        return _cases(options, None)
    path = find_study(name)
    keys = _keys_of(path)
    if "promise" in keys:
        return _promise(options, path)
    return _acceptance(options, path) if "steps" in keys else _cases(options, path)


def is_study(path: Path) -> bool:
    """Return whether there is a file at a `path` that states a study."""
    if not path.is_file():
        return False
    keys = _keys_of(path)
    return "scenario" in keys or "promise" in keys


def _keys_of(path: Path) -> Mapping[str, object]:
    """Return the content of the file at `path`; raise ParameterError, in one line, for one that is no mapping."""
    try:
        return as_mapping(parse_yaml(read_given(path)), str(path))
    except (OSError, ValueError) as error:
        words = " ".join(str(error).split())
        raise error if isinstance(error, ParameterError) else ParameterError(f"{path}: {words}") from error


def _cases(options: Options, path: Path | None) -> Opened:
    study = study_of(options.study) if path is None else read_study(path)
    study = with_options(
        study, settings=options.settings, vary=options.vary, require=options.require, ask=options.ask
    ).shortened(duration=options.duration, draws=options.draws, seeds=options.seeds)
    study = replace(
        study,
        scenario=options.scenario or study.scenario,
        has_screening=study.has_screening and not options.is_full,
    )
    asked = asked_of(study)
    lead = f"Scenario {study.scenario}" if path is None else description_of(path)
    folder = options.folder or options.own_folder
    return Opened(Cases(asked.study), asked.of, folder, lead=lead, lift=lift_of(study))


def _promise(options: Options, path: Path) -> Opened:
    options.refuse("scenario", "settings", "vary", "require", "seeds", "duration")
    ask = own_keys(promise.KEYS, asked_values(options.ask), str(path))
    kind = read_promise(path, ask, options.draws)
    own = options.own_folder
    folder = options.folder or own.with_name(f"{own.name}-{kind.seed}")
    return Opened(kind, partial(promise.answer, kind), folder, {"seed": str(kind.seed)}, description_of(path))


def _acceptance(options: Options, path: Path) -> Opened:
    options.refuse("vary", "require", "seeds", "draws", "duration")
    for text in options.settings:
        parse_setting(text)
    ask = own_keys(acceptance.KEYS, asked_values(options.ask), str(path))
    parts = _parts(ask)
    folder = options.folder or options.own_folder
    if parts.are_real and options.folder is None:  # it does not do the same twice
        numbered = (folder.with_name(f"{folder.name}-{number:03d}") for number in itertools.count(1))
        folder = next(one for one in numbered if not one.exists())
    only = [str(one) for one in _listed(ask["step"])]
    kind = Acceptance(read_head(path), parts, options.settings, options.scenario or "", only, folder)
    return Opened(kind, partial(acceptance.answer, kind), folder, kind.facts)


def _parts(ask: Mapping[str, object]) -> Parts:
    """Return what is tested."""
    external = parse_replacements([str(one) for one in _listed(ask["replace"])], "ask: replace", [EXTERNAL]).external
    winch = find_map(str(ask["winch"])) if ask["winch"] else None
    return Parts(winch, external, is_on_network=bool(ask["network"]))


def _listed(given: object) -> list[object]:
    return given if isinstance(given, list) else [given] if given else []


def asked_table() -> list[list[str]]:
    """Return a row for each answer: its name, what it says, what may be asked of it."""
    rows = [[name, words, " ".join(answer_of(name).KEYS)] for name, words in ANSWERS.items()]
    return rows + [[f"file with {key}", words, " ".join(module.KEYS)] for key, (words, module) in OF_FILES.items()]
