"""A scenario file to start from: the values of another one, each with its unit and meaning beside it."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping

from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_node.catalogue import FROM, KINDS, find
from heave_node.files.file_kinds import PARAMETERS_KEY
from heave_node.parameters import ParameterInfo, describe
from heave_node.run_parameters import RunParameters
from heave_node.scenario import WILDCARD, Sections, nest_names
from heave_node.system_parameters import SYSTEM, system_names

from heave_bringup.nodes import NODE_BY_NAME, NODES

WANTED = "wanted."
INDENT = "  "
COMMENTS_AT = 50

HEAD = """# {title}
# Values are SI. Parameters not listed keep their defaults; heave params lists all. heave list cable (unit, winch)
# lists those that can be given by name. Run it: heave run {path}
"""
SECTION_WORDS = {
    WILDCARD: "the run, its criteria (wanted), and what ship and controller share",
    "wave_vessel": "sea and vessel, where they differ from what the controller assumes",
    "cable_sim": "cable, unit, seabed, current, sensors",
    "virtual_winch": "the winch",
    "winch_controller": "the controller, and where its assumptions differ",
    "winch_envelope": "the envelope as a separate node",
    "winch_adviser": "the adviser",
    "recorder": "the bag",
}


def commented_scenario(sections: Sections, *, title: str, path: str) -> str:
    """Return a scenario file, `path` in its head, with a comment beside each value of its `sections`, by section and
    dotted name.

    The `title` is the first line, which `heave list` and reports show.
    """
    lines = [HEAD.format(title=title, path=shlex.quote(path)).rstrip()]
    for section, values in sections.items():
        node = section.rpartition("/")[2] if section != WILDCARD else WILDCARD
        lines += [f"{section}:  # {SECTION_WORDS.get(node, '')}".rstrip("# "), f"{INDENT}{PARAMETERS_KEY}:"]
        lines += _lines(nest_names(values), "", 2, _words_of(node))
    return "\n".join(lines) + "\n"


def _lines(nested: Mapping[str, object], prefix: str, depth: int, words: Mapping[str, str]) -> list[str]:
    lines = []
    for key, value in nested.items():
        name = f"{prefix}{key}"
        if isinstance(value, Mapping):
            lines += [f"{INDENT * depth}{key}:", *_lines(value, f"{name}.", depth + 1, words)]
        else:
            line = f"{INDENT * depth}{key}: {_value(value)}"
            comment = _named(name, value) or words.get(name, "")
            lines.append(f"{line:<{COMMENTS_AT}}  # {comment}" if comment else line)
    return lines


def _value(value: object) -> str:
    """Return a value as YAML and ROS 2 read it alike."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, float):
        text = repr(value)
        return text if "." in text or "e" not in text else text.replace("e", ".0e")
    return json.dumps(value) if isinstance(value, bool | str) else str(value)


def _named(name: str, value: object) -> str:
    """Say what the catalogue has under a name; "" for what is none."""
    kind = name.removeprefix(SYSTEM).removesuffix(f".{FROM}")
    return find(kind, value).title if name.startswith(SYSTEM) and kind in KINDS else ""


def _words_of(node: str) -> dict[str, str]:
    """Return unit and meaning of what a section may hold, by name."""
    if node != WILDCARD:
        return {info.name: _words(info) for info in describe(NODE_BY_NAME[node].parameters_type())}
    words = {info.name: _words(info) for info in describe(RunParameters)}
    words |= {f"{WANTED}{key}": definition.title for key, definition in DEFINITION_OF.items()}
    for one in reversed(NODES):
        infos = {info.name: info for info in describe(one.parameters_type())}
        words |= {name: _words(infos[own]) for name, own in system_names(one.name, list(infos)).items()}
    return words


def _words(info: ParameterInfo) -> str:
    unit = f"[{info.unit}] " if info.unit else ""
    unreported = any(choice not in info.description for choice in info.choices)
    choices = f" ({', '.join(info.choices)})" if unreported else ""
    return f"{unit}{info.description.rstrip('.')}{choices}"
