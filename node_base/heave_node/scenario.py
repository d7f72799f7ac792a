"""Scenario files: ordinary ROS 2 parameter files, read, matched to nodes and written without ROS.

Sections are named as ROS 2 names them: `/**` holds for every node, `/**/cable_sim` for the node `cable_sim` in any
namespace, `/cable_sim` (or `cable_sim`) for the one without a namespace. Where two sections hold for a node and both
have a name, the later section wins, as in ROS 2.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from heave_node.bare_words import read_bare
from heave_node.catalogue import with_entries
from heave_node.files.bounded_yaml import DUMPER, EXPONENT, YamlError, parse_yaml
from heave_node.files.file_kinds import PARAMETERS_KEY, refuse_other_kind
from heave_node.files.given_files import whole_file
from heave_node.parameters import Given, ParameterError
from heave_node.system_parameters import SYSTEM, own_name

WILDCARD = "/**"
CHANGED = "changed"
"""Begins the comment of a stored scenario that names the parameters that were changed for the run."""
MOST_VALUES = 20_000
"""Names and values of a file: all parameters of all nodes are two thousand."""
MOST_SECTIONS = 500
"""Sections of a file: each is matched with every node; a run has one for each of its nodes, and ten of them."""

Sections = dict[str, dict[str, object]]
"""Parameter values by section and dotted parameter name, in the order of the file."""


class _RosDumper(DUMPER):  # type: ignore[misc]  # one of two
    """Writes numbers and strings so that ROS 2 reads them as such, short lists on one line, and no aliases."""

    def ignore_aliases(self, data: object) -> bool:  # noqa: ARG002
        """Write every value in full: ROS 2 reads no aliases."""
        return True


def _represent_text(dumper: _RosDumper, text: str) -> yaml.ScalarNode:
    """Write a text in quotes that bare is read as something else: nan is a number to ROS 2, and y is true."""
    style = None if isinstance(read_bare(text), str) else "'"
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)


_RosDumper.add_representer(str, _represent_text)
_RosDumper.add_implicit_resolver("tag:yaml.org,2002:float", EXPONENT, list("-+.0123456789"))
_RosDumper.add_representer(
    list, lambda dumper, data: dumper.represent_sequence("tag:yaml.org,2002:seq", data, flow_style=True)
)


def read_sections(path: Path) -> Sections:
    """Read the parameter file at `path`.

    Raises ParameterError, naming the file, where it is missing, is not YAML, has not the form of a ROS 2 parameter
    file, or has a section without a parameter.
    """
    try:
        return parse_sections(path.read_bytes(), str(path))
    except OSError as error:
        raise ParameterError(f"{path}: cannot be read: {error.strerror}") from error


def parse_sections(content: bytes, where: str) -> Sections:
    """Return the sections of a parameter file's content.

    Parameters
    ----------
    content : UTF-8 text
    where : opens error messages: the file

    Raises ParameterError as `read_sections` does.
    """
    try:
        nodes = parse_yaml(content, most_values=MOST_VALUES)
    except YamlError as error:
        raise ParameterError(f"{where}: {error}") from error
    if not isinstance(nodes, Mapping):
        raise ParameterError(f"{where}: must be a mapping of node names to {PARAMETERS_KEY}")
    refuse_other_kind(nodes, (PARAMETERS_KEY,), where)
    sections: Sections = {}
    _collect(nodes, "", where, sections)
    if len(sections) > MOST_SECTIONS:
        raise ParameterError(f"{where}: has {len(sections)} sections, {MOST_SECTIONS} are allowed")
    if not sections:
        raise ParameterError(f"{where}: has no parameters")
    return sections


def _collect(content: Mapping[str, Any], namespace: str, where: str, sections: Sections) -> None:
    """Put the sections of a file into `sections`; a mapping of mappings is a namespace of nodes, as for ROS 2."""
    for key, section in content.items():
        name = f"{namespace}/{str(key).strip('/')}"
        if _is_namespace(section):
            _collect(section, name, where, sections)
            continue
        if not isinstance(section, Mapping) or set(section) != {PARAMETERS_KEY}:
            raise ParameterError(f"{where}: {key}: must contain only {PARAMETERS_KEY}{_beside(section)}")
        values = flatten_names(section[PARAMETERS_KEY] or {}, f"{where}: {key}")
        if not values:
            raise ParameterError(f"{where}: {key}: has no parameters")
        repeated = sections.setdefault(name, {}).keys() & values.keys()
        if repeated:
            raise ParameterError(f"{where}: {key}: {min(repeated)} appears twice, in two sections with this name")
        sections[name] |= values


def _beside(section: object) -> str:
    """Return what to do about names that stand beside the parameters of a node, in place of below them."""
    if not isinstance(section, Mapping) or PARAMETERS_KEY not in section:
        return "; `heave new` writes a file of this form"
    return f"; indent {sorted(str(name) for name in section if name != PARAMETERS_KEY)[0]} below it"


def _is_namespace(section: object) -> bool:
    if not isinstance(section, Mapping) or PARAMETERS_KEY in section:
        return False
    return bool(section) and all(isinstance(part, Mapping) for part in section.values())


def flatten_names(section: Mapping[str, Any], where: str, prefix: str = "") -> dict[str, object]:
    """Turn nested mappings into dotted names: {"unit": {"mass": 1}} becomes {"unit.mass": 1}.

    Parameters
    ----------
    section : nested mappings
    where : opens the error message for what is not a mapping
    prefix : put before every name
    """
    if not isinstance(section, Mapping):
        raise ParameterError(f"{where}: {PARAMETERS_KEY} must be a mapping of names to values, not {section!r}")
    values: dict[str, object] = {}
    for name, value in section.items():
        if isinstance(value, Mapping):
            values |= flatten_names(value, where, f"{prefix}{name}.")
        else:
            values[f"{prefix}{name}"] = value
    return values


def nest_names(values: Mapping[str, object]) -> dict[str, Any]:
    """Turn the dotted names of `values` into nested mappings; the inverse of `flatten_names`.

    Below a name that has a value itself (`cable: wire`, `cable.normal_drag: 1.6`) names stay dotted.
    """
    nested: dict[str, Any] = {}
    for name, value in values.items():
        parts = name.split(".")
        depth = next((n for n in range(1, len(parts)) if ".".join(parts[:n]) in values), len(parts)) - 1
        place = nested
        for group in parts[:depth]:
            place = place.setdefault(group, {})
        place[".".join(parts[depth:])] = list(value) if isinstance(value, tuple) else value
    return nested


def holds_for(section: str, node: str) -> bool:
    """Return whether a section of a parameter file holds for a node, as ROS 2 decides it.

    Parameters
    ----------
    section : its name; `*` matches one part of a name, `**` for any number of them
    node : fully qualified name, for example `/ship/cable_sim`
    """
    pattern = "".join(
        {"/**": r"(/\w+)*", "/*": r"/\w+"}.get(part, re.escape(part)) for part in re.split(r"(/\*\*|/\*)", section)
    )
    return re.fullmatch(pattern, node) is not None


def sections_of_node(sections: Sections, node: str) -> dict[str, str]:
    """Return the section that each name given to a node comes from: of several, the last one that has it.

    Parameters
    ----------
    sections : of a parameter file
    node : fully qualified name, for example `/ship/cable_sim`
    """
    return {name: section for section, values in sections.items() if holds_for(section, node) for name in values}


def values_of_node(sections: Sections, node: str) -> dict[str, object]:
    """Return what a parameter file says of a node, by the node's own names; not checked, for analysis.

    Parameters
    ----------
    sections : of a parameter file
    node : fully qualified name, for example `/ship/cable_sim`
    """
    given = {name: sections[section][name] for name, section in sections_of_node(sections, node).items()}
    given = {name: one.value for name, one in with_entries({n: Given(v, n, "") for n, v in given.items()}).items()}
    shared = {own: value for name, value in given.items() if (own := own_name(node.rpartition("/")[2], name))}
    return {**shared, **{name: value for name, value in given.items() if not name.startswith(SYSTEM)}}


def write_sections(sections: Mapping[str, Mapping[str, object]], path: Path, *, title: str = "") -> None:
    """Write a parameter file that `read_sections`, `ros2 run --params-file` and `ros2 launch` read.

    Parameters
    ----------
    sections : values by section and dotted name; an empty list is left out, since ROS 2 cannot read one
    path : of the file
    title : comment at its top
    """
    with whole_file(path) as unfinished:
        unfinished.write_text(sections_text(sections, title=title), encoding="utf-8")


def sections_text(sections: Mapping[str, Mapping[str, object]], *, title: str = "") -> str:
    """Return what `write_sections` writes.

    Parameters
    ----------
    sections : values by section and dotted name
    title : comment at the top
    """
    content = {
        section: {PARAMETERS_KEY: nest_names({name: value for name, value in values.items() if value not in ((), [])})}
        for section, values in sections.items()
    }
    comment = "".join(f"# {line}\n" for line in title.splitlines())
    return comment + str(yaml.dump(content, Dumper=_RosDumper, sort_keys=False, allow_unicode=True, width=10_000))
