"""Scenarios by name or file: found, merged with the user's wishes, and checked before anything starts."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import yaml
from heave_node.parameters import ParameterError, build_parameters, describe
from heave_node.run_parameters import RunParameters
from heave_node.scenario import WILDCARD, NodeValues, parse_yaml, read_scenario, values_of_node

from heave_bringup.run.node_table import NODE_BY_NAME, NODES

SCENARIO_FOLDER = "scenarios"


@dataclass(frozen=True)
class Scenario:
    """A checked scenario: the values it gives, and every node's parameter set made of them."""

    name: str
    path: Path
    values: NodeValues
    run: RunParameters
    parameters: Mapping[str, Any]
    """Parameter set of each node, by node name."""


def shipped_scenarios() -> dict[str, Path]:
    """Return the scenarios that come with the suite, by name."""
    folder = Path(str(resources.files("heave_bringup"))) / SCENARIO_FOLDER
    return {path.stem: path for path in sorted(folder.glob("*.yaml"))}


def description_of(path: Path) -> str:
    """Return the first comment line of a scenario file: what it is, in one line."""
    first = path.read_text(encoding="utf-8").split("\n", 1)[0]
    return first.lstrip("# ").strip() if first.startswith("#") else ""


def find_scenario(name: str) -> Path:
    """Return the file of a shipped scenario or the file itself; raise ParameterError where there is neither."""
    shipped = shipped_scenarios()
    if name in shipped:
        return shipped[name]
    path = Path(name)
    if path.is_file():
        return path
    if path.suffix in (".yaml", ".yml") or path.parent != Path():
        raise ParameterError(f"{name}: no such file")
    near = difflib.get_close_matches(name, shipped, n=1)
    hint = f"did you mean {near[0]}?" if near else f"shipped are: {', '.join(shipped)}"
    raise ParameterError(f"{name}: no such scenario; {hint}")


def load_scenario(
    name: str,
    *,
    settings: Iterable[str] = (),
    common: Mapping[str, object] | None = None,
    source: str = "command line",
) -> Scenario:
    """Find, merge and check a scenario.

    Parameters
    ----------
    name : shipped name or file
    settings : "NODE.PARAM=VALUE" texts, values in YAML, on top of the file; NODE may be `all`
    common : values for every node, on top of everything (from the command's own options)
    source : where settings and common come from, to be named where they, and not the file, are wrong

    Raises ParameterError, in one line, for whatever is wrong.
    """
    path = find_scenario(name)
    in_file = read_scenario(path)
    _refuse_unknown_nodes(in_file, path)
    values = {node: dict(section) for node, section in in_file.items()}
    for setting in settings:
        apply_setting(values, setting)
    values.setdefault(WILDCARD, {}).update(common or {})
    try:
        return _checked(path, values, str(path))
    except ParameterError:
        _checked(path, in_file, str(path))  # a fault of the file is told as such
        return _checked(path, values, f"{source} (on top of {path})")


def check_lengths(option: str, lengths: Iterable[float]) -> None:
    """Refuse deployed lengths [m] given by an option that a scenario could not have; raises ParameterError."""
    parameters = describe(NODE_BY_NAME["winch_controller"].parameters_type())
    (allowed,) = (info for info in parameters if info.name == "length")
    for length in lengths:
        allowed.check(length, where=option)


def _checked(path: Path, values: NodeValues, source: str) -> Scenario:
    """Return the scenario of these values; `source` opens the message of the ParameterError for what is wrong."""
    of_run = {info.name for info in describe(RunParameters)}
    run = build_parameters(RunParameters, values.get(WILDCARD, {}), where=f"{source}: {WILDCARD}")
    parameters: dict[str, Any] = {}
    for node in NODES:
        where = f"{source}: {node.name}"
        given = values_of_node(values, node.name)
        run_values = {key: value for key, value in given.items() if key in of_run}
        build_parameters(RunParameters, run_values, where=where)
        own = {key: value for key, value in given.items() if key not in of_run}
        parameters[node.name] = build_parameters(node.parameters_type(), own, where=where)
    return Scenario(path.stem, path, values, run, parameters)


def apply_setting(values: NodeValues, setting: str) -> None:
    """Put a "NODE.PARAM=VALUE" text into the values of a scenario; raises ParameterError for what is none."""
    target, separator, text = setting.partition("=")
    node, dot, parameter = target.partition(".")
    if not separator or not dot or not parameter:
        raise ParameterError(f"--set {setting}: must be NODE.PARAM=VALUE, for example wave_vessel.peak_period=9")
    if node == "all":
        node = WILDCARD
    elif node not in NODE_BY_NAME:
        raise ParameterError(f"--set {setting}: there is no node {node}; known: all, {', '.join(NODE_BY_NAME)}")
    try:
        values.setdefault(node, {})[parameter] = parse_yaml(text)
    except yaml.YAMLError as error:
        raise ParameterError(f"--set {setting}: {text!r} is not a YAML value") from error


def _refuse_unknown_nodes(values: NodeValues, path: Path) -> None:
    for node in values:
        if node != WILDCARD and node not in NODE_BY_NAME:
            near = difflib.get_close_matches(node, NODE_BY_NAME, n=1)
            hint = f"did you mean {near[0]}?" if near else f"known: {', '.join(NODE_BY_NAME)}"
            raise ParameterError(f"{path}: there is no node {node}; {hint}")
