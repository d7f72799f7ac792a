"""Parameter sets on a ROS node: read what was given, refuse what is wrong, describe everything."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node

from heave_node.parameters import ParameterInfo, build_parameters, describe
from heave_node.run_parameters import RunParameters


def read_parameters(node: Node, parameters_type: type[Any]) -> tuple[RunParameters, Any]:
    """Return the run's and the node's own parameter sets, and declare every parameter with its descriptor.

    The node must have been made with `automatically_declare_parameters_from_overrides`. Raises ParameterError for an
    unknown name, a wrong type
    or a value out of range.
    """
    given = {
        name: _plain(parameter.value)
        for name, parameter in node.get_parameters_by_prefix("").items()
        if name not in ("use_sim_time", "start_type_description_service") and not name.startswith("qos_overrides.")
    }
    run_infos, own_infos = describe(RunParameters), describe(parameters_type)
    of_run = {info.name for info in run_infos}
    where = _where(node.get_name())
    run = build_parameters(RunParameters, {n: v for n, v in given.items() if n in of_run}, where=where)
    own = build_parameters(parameters_type, {n: v for n, v in given.items() if n not in of_run}, where=where)
    for info in [*run_infos, *own_infos]:
        descriptor = _descriptor(info)
        if info.name in given:
            node.set_descriptor(info.name, descriptor)
        else:
            node.declare_parameter(info.name, _ros_value(info), descriptor)
    return run, own


def _descriptor(info: ParameterInfo) -> ParameterDescriptor:
    """Say in ROS's words what a parameter is, so that `ros2 param describe` shows unit, range and meaning."""
    descriptor = ParameterDescriptor(
        name=info.name,
        description=info.description,
        additional_constraints=info.allowed(),
        read_only=True,
        dynamic_typing=True,
    )
    if info.minimum is None or info.maximum is None or info.is_array:
        return descriptor
    if info.type is float:
        descriptor.floating_point_range = [FloatingPointRange(from_value=info.minimum, to_value=info.maximum)]
    elif info.type is int:
        descriptor.integer_range = [IntegerRange(from_value=int(info.minimum), to_value=int(info.maximum), step=1)]
    return descriptor


def _ros_value(info: ParameterInfo) -> Any:
    return list(info.default) if isinstance(info.default, tuple) else info.default


def _plain(value: Any) -> object:
    """Return a parameter value of rclpy as plain Python (its arrays are array.array)."""
    return list(value) if hasattr(value, "__iter__") and not isinstance(value, str) else value


def _where(name: str) -> str:
    """Name the scenario file, where one is on the command line, and the node."""
    files = [sys.argv[i + 1] for i, argument in enumerate(sys.argv[:-1]) if argument == "--params-file"]
    return ": ".join([*(str(Path(file)) for file in files[-1:]), name])
