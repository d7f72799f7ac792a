"""Parameter sets on a ROS node: read what was given, refuse what is wrong, describe everything."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node

from heave_node.criteria import WANTED
from heave_node.parameters import Given, ParameterError, ParameterInfo, describe, flatten
from heave_node.run_parameters import NodeParameters, RunParameters, build_node_parameters
from heave_node.scenario import WILDCARD, Sections, holds_for, read_sections, sections_of_node
from heave_node.system_parameters import SYSTEM

_OF_ROS = ("use_sim_time", "start_type_description_service")


def read_parameters(node: Node, parameters_type: type[Any]) -> tuple[RunParameters, Any]:
    """Return the run's and the node's own parameter sets, and declare every parameter with its descriptor.

    Shared names (`system.`) are put in the place of the node's own and, like the criteria of the run (`wanted.`), are
    no parameters of the node afterwards.

    Parameters
    ----------
    node : made with `automatically_declare_parameters_from_overrides`
    parameters_type : its own parameter set

    Raises
    ------
    ParameterError
        For an unknown name, a wrong type, a value out of range, and for a parameter file that has nothing for this
        node.
    """
    given_files = [Path(sys.argv[i + 1]) for i, word in enumerate(sys.argv[:-1]) if word == "--params-file"]
    files = [(path, read_sections(path)) for path in given_files]
    for path, sections in files:
        check_concerned(path, sections, node.get_fully_qualified_name())
    given = _given(node, files)
    name = getattr(node, "name", node.get_name())  # renamed on the command line, it is still the same node
    where = ": ".join([*(str(path) for path, _ in files[-1:]), node.get_name()])
    built = build_node_parameters(name, parameters_type, given, where=where)
    for given_name in given:
        if given_name.startswith((SYSTEM, WANTED)):
            node.undeclare_parameter(given_name)
    _declare(node, built, [*describe(RunParameters), *describe(parameters_type)], given)
    return built.run, built.own


def check_concerned(path: Path, sections: Sections, node: str) -> None:
    """Refuse a parameter file that has nothing for a node, or that means it and misses it by its namespace.

    Parameters
    ----------
    path : of the file
    sections : what the file holds
    node : fully qualified name, for example `/ship/cable_sim`

    Raises ParameterError; without it the node would run with its defaults, and nobody would notice.
    """
    holding = [section for section in sections if holds_for(section, node)]
    name = node.rpartition("/")[2]
    missed = [section for section in sections if section.rpartition("/")[2] == name and section not in holding]
    if missed and all(section == WILDCARD for section in holding):
        raise ParameterError(
            f"{path}: {missed[0]}: does not apply to node {node}; write {WILDCARD}/{name}, which applies in any "
            "namespace"
        )
    if not holding:
        raise ParameterError(f"{path}: has no parameters for node {node}; its sections are {', '.join(sections)}")


def _given(node: Node, files: Sequence[tuple[Path, Sections]]) -> dict[str, Given]:
    """Return what the node was given, each value with the file and section that it comes from."""
    origins: dict[str, str] = {}
    for path, sections in files:
        held = sections_of_node(sections, node.get_fully_qualified_name())
        origins |= {name: f"{path}: {section}" for name, section in held.items()}
    return {
        name: Given(plain_value(parameter.value), name, origins.get(name, f"{node.get_name()}: command line"))
        for name, parameter in node.get_parameters_by_prefix("").items()
        if name not in _OF_ROS and not name.startswith("qos_overrides.")
    }


def _declare(node: Node, built: NodeParameters, infos: Iterable[ParameterInfo], given: Iterable[str]) -> None:
    """Declare what was not given by its own name with the active value, and describe everything."""
    values = {**flatten(built.run), **flatten(built.own)}
    given = set(given)
    for info in infos:
        if info.name in given:
            node.set_descriptor(info.name, _descriptor(info))
        else:
            value = values[info.name]
            node.declare_parameter(info.name, list(value) if isinstance(value, tuple) else value, _descriptor(info))


def _descriptor(info: ParameterInfo) -> ParameterDescriptor:
    """Describe a parameter to ROS, so that `ros2 param describe` shows unit, range and meaning."""
    descriptor = ParameterDescriptor(
        name=info.name,
        description=info.description,
        additional_constraints=info.allowed(),
        read_only=not info.is_live,
        dynamic_typing=True,
    )
    if info.minimum is None or info.maximum is None or info.is_array:
        return descriptor
    if info.type is float:
        descriptor.floating_point_range = [FloatingPointRange(from_value=info.minimum, to_value=info.maximum)]
    elif info.type is int:
        descriptor.integer_range = [IntegerRange(from_value=int(info.minimum), to_value=int(info.maximum), step=1)]
    return descriptor


def plain_value(value: Any) -> object:
    """Return a parameter value of rclpy as plain Python (its arrays are array.array)."""
    return list(value) if hasattr(value, "__iter__") and not isinstance(value, str) else value


def launch_parameters(given: Mapping[str, str]) -> list[str | dict[str, bool]]:
    """Return the parameter files and values of a node in a launch of the arguments `given`, the later the stronger."""
    files = [given["scenario"], given["params_file"]]
    autostart = given["autostart"]
    return [*filter(None, files), *([{"autostart": autostart == "true"}] if autostart else [])]
