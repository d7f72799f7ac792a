"""Scenarios by name or file: found, merged with the user's wishes, and checked before anything starts."""

from __future__ import annotations

import difflib
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from heave_node.catalogue import with_entries
from heave_node.criteria import WANTED, Criterion
from heave_node.extras import extra_parts
from heave_node.files.given_files import whole_file
from heave_node.parameters import Given, ParameterError, describe, flatten, unknown_parameter
from heave_node.run_parameters import NodeParameters, RunParameters, build_node_parameters
from heave_node.scenario import WILDCARD, Sections, parse_sections, read_sections
from heave_node.system_parameters import SYSTEM, owned_names, system_names
from winch_controller_node.core.supervision.modes import Mode
from winch_controller_node.node_parameters import load_chosen_parts

from heave_bringup.nodes import MASTER, NODE_BY_NAME, NODES
from heave_bringup.settings import Setting, meant, near_places, parse_setting

SCENARIO_FOLDER = "scenarios"
STORED = "scenario.yaml"
"""File in the folder of a run: its scenario, all active values."""
SCENARIOS_OF_EXTRAS = "heave.scenarios"
"""Group of entry points: packages with a folder of scenarios of their own."""
NAMES_OF_FILES = ("rao_file", "spectrum_file", "recording_file")
"""Endings of the names of parameters that name a file which a run reads."""
LAW = "law"
"""Parameter of the controller that may name a law by its file and class."""
_LAW_FILE = re.compile(r"(.+\.py)(:\w+)")
QOS_OVERRIDES = "qos_overrides."
"""Parameters of ROS itself in a node's section: the node checks them when it makes its topics."""

_CASE = re.compile(r".+\.parquet:\d{1,9}")
"""A case in the table of a campaign, which is no scenario."""
_RUN_NAMES = frozenset(info.name for info in describe(RunParameters))

Values = dict[str, dict[str, Given]]
"""Values of a file, by node (or `/**`) and dotted name, in the order of its sections."""


@dataclass(frozen=True)
class Scenario:
    """A checked scenario."""

    name: str  # of the file
    path: Path  # of the file
    run: RunParameters  # parameters that all nodes share
    parameters: Mapping[str, Any]  # parameter set of each node, by node name
    wanted: tuple[Criterion, ...] = ()  # criteria that a run should meet
    # what a node's section changes of it, `qos_overrides.`, by node and dotted name
    quality_of_service: Mapping[str, Mapping[str, object]] = field(default_factory=dict)
    changed: tuple[str, ...] = ()  # places of the parameters that were changed on top of the file

    @property
    def moves_winch(self) -> bool:
        """Whether a control law drives the winch; under law off it is held by its brake."""
        return bool(self.parameters["winch_controller"].law != Mode.OFF.value)


def shipped_scenarios() -> dict[str, Path]:
    """Return the scenarios that come with the suite and with the extras that are installed, by name."""
    packages = ["heave_bringup", *(entry.value for entry in extra_parts(SCENARIOS_OF_EXTRAS).values())]
    homes = [
        home for package in packages if (found := find_spec(package)) for home in found.submodule_search_locations or ()
    ]
    folders = [Path(home) / SCENARIO_FOLDER for home in homes]
    return dict(sorted((path.stem, path) for folder in folders for path in folder.rglob("*.yaml")))


def description_of(path: Path) -> str:
    """Return the first comment line of the scenario file `path`: what it is, in one line."""
    first = path.read_text(encoding="utf-8").split("\n", 1)[0]
    return first.lstrip("# ").strip() if first.startswith("#") else ""


def find_scenario(name: str) -> Path:
    """Return the file of the shipped scenario `name`, or the file `name`; raise ParameterError where neither is."""
    shipped = shipped_scenarios()
    if name in shipped:
        return shipped[name]
    path = Path(name)
    if path.is_file():
        return path
    if _CASE.fullmatch(name):
        raise ParameterError(f"{name}: is a case of a table; `heave study --case {name}` writes its scenario")
    if path.is_dir():
        of_run = next((place / STORED for place in (path, path.parent) if (place / STORED).is_file()), None)
        hint = f"the scenario of a run is its file {of_run}" if of_run else "give a file, such as that of a run"
        raise ParameterError(f"{name}: this is a folder; {hint}")
    if path.suffix in (".yaml", ".yml") or path.parent != Path():
        raise ParameterError(f"{name}: no such file")
    beside = path.with_name(f"{name}.yaml")
    near = [str(beside)] if beside.is_file() else difflib.get_close_matches(name, shipped, n=1)
    hint = f"did you mean {near[0]}?" if near else f"shipped are: {', '.join(shipped)}"
    raise ParameterError(f"{name}: no such scenario; {hint}")


def load_scenario(name: str, *, settings: Iterable[Setting | str] = (), needs_files: bool = True) -> Scenario:
    """Find, merge and check a scenario.

    Parameters
    ----------
    name : shipped name or file
    settings : changes on top of the file; a string is read like the value of `--set`
    needs_files : files that it names must be there; False: it is only looked at

    Files that the scenario names are relative to its own folder.

    Raises ParameterError, in one line, for whatever is wrong. A wrong value is reported with its file and section, or
    with the option that gave it.
    """
    path = find_scenario(name)
    return _of_sections(read_sections(path), path, settings, needs_files=needs_files)


def named_files(scenario: Scenario) -> list[str]:
    """Return the files that a `scenario` names, each once."""
    values = [of for node in scenario.parameters.values() for of in flatten(node).items()]
    return list(dict.fromkeys(str(value) for name, value in values if name.endswith(NAMES_OF_FILES) and value))


def write_scenario(path: Path, text: str, *, needs_files: bool = True) -> None:
    """Write the `text` of a scenario to the file `path` if it is right, whole; else what was at its place stays as it
    was.

    With `needs_files` the files that it names must be there. Raises ParameterError, in one line, where the scenario is
    wrong or the file cannot be written.
    """
    words = path.with_name(f"{path.name} (not written)")  # in errors
    _of_sections(parse_sections(text.encode(), str(words)), words, (), needs_files=needs_files)
    try:
        with whole_file(path) as unfinished:
            unfinished.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ParameterError(f"{path}: cannot be written: {error.strerror}") from error


def _of_sections(sections: Sections, path: Path, settings: Iterable[Setting | str], *, needs_files: bool) -> Scenario:
    """Return the scenario of a file's `sections` with the changes on top of them."""
    changes = [parse_setting(setting) if isinstance(setting, str) else setting for setting in settings]
    in_file = _by_node(sections, path)
    if needs_files:
        folder = path.resolve().parent
        in_file = {node: {name: _found(one, folder) for name, one in of.items()} for node, of in in_file.items()}
        changes = [replace(one, value=_found(Given(one.value, one.name, one.source)).value) for one in changes]
    checked = _checked(path.stem, path, in_file, changes)
    if needs_files:  # it is going to run: a scenario that is only looked at, in a bag of others, loads no code
        load_chosen_parts(checked.parameters["winch_controller"])
    return checked


def sections_for(model: Path, folder: Path) -> Sections:
    """Return the sections of the scenario in a file, `model`, fit for a file in another `folder`: files that it names
    are still found.

    Raises ParameterError as `read_sections` does.
    """
    sections = read_sections(model)
    for values in sections.values():
        for name, value in values.items():
            if name.endswith(NAMES_OF_FILES) and isinstance(value, str) and (model.parent / value).is_file():
                values[name] = Path(os.path.relpath((model.parent / value).resolve(), folder.resolve())).as_posix()
    return sections


def _found(given: Given, folder: Path | None = None) -> Given:
    """Return a given value; of one that names a file its full path: in a `folder`, else where the command is given.

    Raises ParameterError for a file that is in neither place.
    """
    law = _LAW_FILE.fullmatch(str(given.value)) if given.name == LAW else None
    if law is None and not (given.name.endswith(NAMES_OF_FILES) and isinstance(given.value, str) and given.value):
        return given
    file, rest = (law[1], law[2]) if law else (str(given.value), "")
    places = [Path(file)] if folder is None else [folder / file, Path(file)]
    path = next((place for place in places if place.is_file() or place.is_dir()), None)
    if path is None:
        raise ParameterError(f"{given.where}: {given.name} = {given.value!r}: no such file")
    return replace(given, value=f"{path.resolve()}{rest}")


def make_scenario(values: Mapping[str, Mapping[str, object]]) -> Scenario:
    """Check a scenario that is in no file, for tests and studies: its `values` by node (or `/**`) and dotted name."""
    given = {
        node: {name: Given(value, name, node) for name, value in of_node.items()} for node, of_node in values.items()
    }
    return _checked("values", Path("values"), given, ())


def check_lengths(option: str, lengths: Iterable[float]) -> None:
    """Refuse deployed `lengths` [m] that a scenario could not have; raises ParameterError for the first, naming the
    `option` of the command line.
    """
    parameters = describe(NODE_BY_NAME["winch_controller"].parameters_type())
    (allowed,) = (info for info in parameters if info.name == "length")
    for length in lengths:
        allowed.check(length, where=option)


def _checked(name: str, path: Path, in_file: Values, settings: Iterable[Setting | str]) -> Scenario:
    """Return the scenario of a file's values and the changes on top of them."""
    given = [parse_setting(setting) if isinstance(setting, str) else setting for setting in settings]
    changes = [one for change in given for one in _of_catalogue(change)]
    in_file = {**in_file, WILDCARD: with_entries(in_file.get(WILDCARD, {}))}
    shared = _given(WILDCARD, in_file, changes)
    _check_shared_names(shared)
    _check_shared_choices(shared)
    _refuse_overruled(changes, in_file)
    _check_replaced(changes)
    built: dict[str, NodeParameters] = {}
    quality_of_service: dict[str, dict[str, object]] = {}
    for node in NODES:
        own = _given(node.name, in_file, changes)
        of_ros = {name: own.pop(name).value for name in list(own) if name.startswith(QOS_OVERRIDES)}
        quality_of_service |= {node.name: of_ros} if of_ros else {}
        _check_own_names(own)
        _check_owners(node.name, own)
        where = _where(path, node.name, changes)
        built[node.name] = build_node_parameters(node.name, node.parameters_type(), {**shared, **own}, where=where)
    of_all = built[MASTER]
    own_sets = {node: of.own for node, of in built.items()}
    places = tuple(dict.fromkeys(change.place for change in changes))
    return Scenario(name, path, of_all.run, own_sets, of_all.wanted, quality_of_service, changed=places)


def _of_catalogue(change: Setting) -> list[Setting]:
    """Return what a change sets: one that names an entry of the catalogue sets all values of the entry."""
    if change.target != WILDCARD:
        return [change]
    values = with_entries({change.name: Given(change.value, change.name, change.source)})
    return [replace(change, name=name, value=value.value) for name, value in values.items()]


def _by_node(sections: Sections, path: Path) -> Values:
    """Return a file's `sections` by node; refuse those for no node of the suite, and two for one."""
    values: Values = {}
    for section, given in sections.items():
        node = WILDCARD if section == WILDCARD else _node_of(section, path)
        of_node = values.setdefault(node, {})
        repeated = of_node.keys() & given.keys()
        if repeated:
            raise ParameterError(f"{path}: {section}: {min(repeated)} appears twice, in two sections for {node}")
        of_node.update({name: Given(value, name, f"{path}: {section}") for name, value in given.items()})
    return values


def _node_of(section: str, path: Path) -> str:
    """Return the node that a section is for: `/cable_sim`, or `/**/cable_sim` in any namespace."""
    name = section.removeprefix(WILDCARD).strip("/")
    if name in NODE_BY_NAME:
        return name
    near = difflib.get_close_matches(name.rpartition("/")[2], NODE_BY_NAME, n=1)
    hint = f"did you mean {WILDCARD}/{near[0]}?" if near else f"known: {', '.join(NODE_BY_NAME)}"
    raise ParameterError(f"{path}: no such node: {name}; {hint}")


def _given(target: str, in_file: Values, changes: Sequence[Setting]) -> dict[str, Given]:
    """Return what is given to a node alone, or to all of them (`/**`): the file's values, and the changes on top."""
    changed = {
        change.name: Given(change.value, change.name, change.source) for change in changes if change.target == target
    }
    return {**in_file.get(target, {}), **changed}


def _check_shared_names(given: Mapping[str, Given]) -> None:
    """Refuse a name under `/**` that belongs to neither the run, the system nor a criterion."""
    known = set(_RUN_NAMES)
    for node in NODE_BY_NAME:
        known |= owned_names(node, _names_of(node)).keys()
    for name, value in given.items():
        if name not in known and not name.startswith(WANTED):
            _refuse_misplaced(WILDCARD, value)
            raise unknown_parameter(value, known)


def _check_shared_choices(given: Mapping[str, Given]) -> None:
    """Refuse a shared choice that only some of its nodes know, such as a measured spectrum, and name those."""
    known = {node: system_names(node, _names_of(node)) for node in NODE_BY_NAME}
    for name, value in given.items():
        own = [(node, names[name]) for node, names in known.items() if name in names]
        refused = {node: words for node, mine in own if (words := _unfit(node, replace(value, name=mine, reader=node)))}
        if refused and len(refused) < len(own):
            fit = [f"{node}.{mine}" for node, mine in own if node not in refused]
            raise ParameterError(f"{next(iter(refused.values()))}; {meant(fit)}")


def _check_own_names(given: Mapping[str, Given]) -> None:
    """Refuse in a node's own section what all nodes share: the nodes of one run must agree on it."""
    for name, value in given.items():
        if name in _RUN_NAMES or name.startswith((SYSTEM, WANTED)):
            raise ParameterError(f"{value.where}: all nodes share {name}: set it under {WILDCARD}")


def _check_owners(node: str, given: Mapping[str, Given]) -> None:
    """Refuse what is `given` to a `node` and is elsewhere, a parameter or a choice, and say where."""
    known = set(_names_of(node))
    for name, value in given.items():
        if name not in known:
            _refuse_misplaced(node, value)
            continue
        refused = _unfit(node, value)
        owners = [other for other in NODE_BY_NAME if refused and not _unfit(other, value)]
        if owners:
            raise ParameterError(f"{refused}; {meant([f'{owner}.{name}' for owner in owners])}")


def _refuse_misplaced(target: str, given: Given) -> None:
    """Refuse what a `target` does not know and another place does; a name that nobody knows is left to others."""
    near = near_places(target, given.name)
    if near:
        raise ParameterError(f"{given.where}: there is no parameter {given.name}; {meant(near)}")


def _unfit(node: str, given: Given) -> str:
    """Return in words that a `node` has no such parameter, or no such choice of it, as is `given`; else empty."""
    infos = {info.name: info for info in describe(NODE_BY_NAME[node].parameters_type())}
    if given.name not in infos:
        return f"{given.where}: there is no parameter {given.name}"
    if not infos[given.name].choices:
        return ""
    try:
        infos[given.name].check_given(given)
    except ParameterError as error:
        return str(error)
    return ""


def _refuse_overruled(changes: Sequence[Setting], in_file: Values) -> None:
    """Refuse a change for all nodes that the file takes back for one of them: half of it would be lost silently."""
    for change in (change for change in changes if change.target == WILDCARD):
        for node in NODE_BY_NAME:
            own = system_names(node, _names_of(node)).get(change.name, change.name)
            standing = in_file.get(node, {}).get(own)
            if standing is not None and _given(node, in_file, changes)[own] is standing:
                raise ParameterError(
                    f"{change.source}: {standing.where}: {own} = {standing.value!r} overrides this; "
                    f"set {node}.{own} as well"
                )


def _check_replaced(changes: Sequence[Setting]) -> None:
    """Refuse a value that is not allowed where a later change replaces it, so that no node is given it."""
    last = {change.place: change for change in changes}
    for change in (change for change in changes if change is not last[change.place]):
        for node in NODES:
            infos = {info.name: info for info in (*describe(RunParameters), *describe(node.parameters_type()))}
            own = system_names(node.name, infos).get(change.name, change.name)
            if own in infos and change.target in (WILDCARD, node.name):
                infos[own].check_given(Given(change.value, change.name, change.source))


def _names_of(node: str) -> list[str]:
    return [info.name for info in describe(NODE_BY_NAME[node].parameters_type())]


def _where(path: Path, node: str, changes: Sequence[Setting]) -> str:
    """Name the file, the node and the changes that concern it: the contradiction may be in any of them."""
    sources = dict.fromkeys(change.source for change in changes if change.target in (WILDCARD, node))
    return f"{path}: {node}" + (f" with {', '.join(sources)}" if sources else "")
