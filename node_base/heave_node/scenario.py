"""Scenario files: ordinary ROS 2 parameter files, read and checked without ROS."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from heave_node.parameters import ParameterError

WILDCARD = "/**"
PARAMETERS_KEY = "ros__parameters"

NodeValues = dict[str, dict[str, object]]
"""Parameter values by node name and dotted parameter name; WILDCARD holds those of every node."""


class _RosLoader(yaml.SafeLoader):
    """Reads numbers as the parameter reader of ROS 2 does: 1e-5 is one, though YAML 1.1 wants a point in it."""


_RosLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"), list("-+.0123456789")
)


def parse_yaml(text: str) -> Any:
    """Return the value of a YAML text, numbers as ROS 2 reads them; raises yaml.YAMLError."""
    return yaml.load(text, Loader=_RosLoader)


def read_scenario(path: Path) -> NodeValues:
    """Read the scenario file `path`.

    Raises ParameterError, naming the file, where it is missing, is not YAML, or has not the form of a ROS 2 parameter
    file.
    """
    try:
        content = parse_yaml(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ParameterError(f"{path}: cannot be read: {error.strerror}") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        first_line = " ".join(str(error).split())
        raise ParameterError(f"{path}: is not YAML: {first_line}") from error
    if not isinstance(content, Mapping):
        raise ParameterError(f"{path}: must be a mapping of node names to {PARAMETERS_KEY}")
    values: NodeValues = {}
    for node, section in content.items():
        if not isinstance(section, Mapping) or set(section) != {PARAMETERS_KEY}:
            raise ParameterError(f"{path}: {node}: must hold {PARAMETERS_KEY} and nothing else")
        name = WILDCARD if node == WILDCARD else str(node).strip("/")
        values[name] = dict(flatten_names(section[PARAMETERS_KEY] or {}, f"{path}: {node}"))
    return values


def flatten_names(section: Mapping[str, Any], where: str, prefix: str = "") -> dict[str, object]:
    """Turn nested mappings into dotted names: {"unit": {"mass": 1}} becomes {"unit.mass": 1}."""
    if not isinstance(section, Mapping):
        raise ParameterError(f"{where}: {PARAMETERS_KEY} must be a mapping of names to values, not {section!r}")
    values: dict[str, object] = {}
    for name, value in section.items():
        if isinstance(value, Mapping):
            values |= flatten_names(value, where, f"{prefix}{name}.")
        else:
            values[f"{prefix}{name}"] = value
    return values


def values_of_node(values: NodeValues, node: str) -> dict[str, object]:
    """Return what a scenario says of one node: the values of all nodes, and its own on top."""
    return {**values.get(WILDCARD, {}), **values.get(node, {})}


def write_scenario(values: NodeValues, path: Path) -> None:
    """Write a scenario that `read_scenario`, `ros2 run --params-file` and `ros2 launch` read."""
    content = {
        node: {PARAMETERS_KEY: {name: _plain(value) for name, value in section.items()}}
        for node, section in values.items()
    }
    path.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")


def _plain(value: object) -> object:
    return list(value) if isinstance(value, tuple) else value
