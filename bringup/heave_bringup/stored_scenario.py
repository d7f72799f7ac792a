"""A scenario as a run stores it: every active value, each said once, and fit to be run again."""

from __future__ import annotations

from typing import Any

from heave_bags.analyse.reading.stored import ALL_NODES, NodeParameters
from heave_node.criteria import WANTED
from heave_node.parameters import ParameterError, Value, describe, flatten
from heave_node.scenario import CHANGED, WILDCARD, Sections
from heave_node.system_parameters import owned_names, system_names

from heave_bringup.nodes import NODES
from heave_bringup.scenarios import Scenario, description_of


def stored_sections(scenario: Scenario) -> Sections:
    """Return all values of a scenario as sections of a parameter file.

    `/**` holds the run, the system and what is wanted; a node's section holds its own parameters, and of the shared
    ones those in which it differs from the system.

    Raises ParameterError for an empty list where the default is not empty: a ROS 2 parameter file cannot hold one.
    """
    own = {node.name: _read(scenario.parameters[node.name]) for node in NODES}
    system: dict[str, Value] = {}
    for node, values in own.items():
        system |= {name: values[mine] for name, mine in owned_names(node, values).items()}
    for node, values in own.items():
        for name, mine in system_names(node, values).items():
            if values[mine] == system[name]:
                del values[mine]
    shared: dict[str, object] = {**flatten(scenario.run), **dict(sorted(system.items()))}
    shared |= {f"{WANTED}{criterion.kpi}": criterion.text for criterion in scenario.wanted}
    _refuse_lost_lists(scenario)
    sections: Sections = {WILDCARD: shared}
    for node, values in own.items():
        of_node = {**values, **scenario.quality_of_service.get(node, {})}
        sections |= {f"{WILDCARD}/{node}": of_node} if of_node else {}
    return sections


def _read(parameters: Any) -> dict[str, Value]:
    """Return the values of a node's `parameters`, without groups that nothing reads: those of drives not chosen."""
    idle = tuple(f"{name}." for name in getattr(parameters, "idle_groups", ()))
    return {name: value for name, value in flatten(parameters).items() if not name.startswith(idle)}


def parameters_of(scenario: Scenario) -> NodeParameters:
    """Return the parameters of a scenario as a bag would carry them."""
    nodes = {node: flatten(parameters) for node, parameters in scenario.parameters.items()}
    return {**nodes, ALL_NODES: flatten(scenario.run)}


def stored_title(scenario: Scenario) -> str:
    """Return the comment at the top of a stored scenario: what it is, and what was changed in it for the run."""
    title = f"{description_of(scenario.path) or scenario.name}\nAll values active in one run, including defaults."
    return title + (f"\n{CHANGED}: {', '.join(scenario.changed)}" if scenario.changed else "")


def _refuse_lost_lists(scenario: Scenario) -> None:
    sets: dict[str, Any] = {WILDCARD: scenario.run, **scenario.parameters}
    for node, parameters in sets.items():
        values = flatten(parameters)
        for info in describe(type(parameters)):
            if values[info.name] == () and info.default != ():
                raise ParameterError(
                    f"{scenario.path}: {node}: {info.name} = [] is not possible: ROS 2 has no empty lists in parameter "
                    f"files; its default is {list(info.default)}"  # type: ignore[arg-type]
                )
