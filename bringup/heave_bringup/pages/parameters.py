"""Every parameter of every node, from the parameter sets: what `heave params` prints, and `docs/parameters.md`.

The page is written by `python -m heave_bringup.pages.parameters > docs/parameters.md`; a test holds the two together.
"""

from __future__ import annotations

import fnmatch
import json
import re
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from heave_node.parameters import ParameterInfo, Value, describe
from heave_node.run_parameters import RunParameters
from heave_node.system_parameters import system_names

from heave_bringup.nodes import ENVELOPE, NODES

RUN = "all"
"""Stands for the parameters of the run, which every node has; as in `--set all.PARAM=VALUE`."""

TITLES = {
    RUN: "The run: parameters that every node has, under `/**`",
    "cable_sim": "`cable_sim`: cable, unit, seabed, current, sensors",
    "wave_vessel": "`wave_vessel`: sea, vessel, motion reference unit",
    "virtual_winch": "`virtual_winch`: drum, drive, encoder",
    "winch_controller": "`winch_controller`: what it assumes, and how it works",
    "winch_envelope": "`winch_envelope`: the envelope as a node of its own; all else as of `winch_controller`",
    "winch_adviser": "`winch_adviser`: identification, which takes its nominal from the controller",
    "recorder": "`recorder`: the bag",
}

HEAD = """# Parameters

This page is written by `python -m heave_bringup.pages.parameters` from the code that runs. `heave params` prints the
same, `heave params winch_controller mpc.` a part of it.

`--set NODE.PARAM=VALUE` changes one for a run, and so does the section of a node in a
[scenario](../bringup/heave_bringup/scenarios/README.md). A name under *shared* sets the ship and what the controller
assumes of it at once: `--set system.PARAM=VALUE`. Units are SI.
"""


@dataclass(frozen=True)
class Row:
    """One parameter of one node."""

    node: str  # its name, or "all" for the run
    info: ParameterInfo  # what is known of the parameter
    shared: str = ""  # its name under `system.`; "" where it has none

    @property
    def meaning(self) -> str:
        """Say what it is, and whether it may be changed while the run goes on."""
        return self.info.description + (" May be changed during a run." if self.info.is_live else "")

    def to_json(self) -> dict[str, object]:
        """Return the row for machines."""
        info = self.info
        return {
            "node": self.node,
            "name": info.name,
            "type": f"list of {info.type.__name__}" if info.is_array else info.type.__name__,
            "unit": info.unit,
            "default": info.default,
            "minimum": info.minimum,
            "maximum": info.maximum,
            "choices": list(info.choices),
            "length": info.length,
            "shared": self.shared,
            "live": info.is_live,
            "meaning": info.description,
        }


def all_rows() -> list[Row]:
    """Return every parameter: those of the run, then those of each node, in the order of definition."""
    rows = [Row(RUN, info) for info in describe(RunParameters)]
    for node in NODES:
        infos = describe(node.parameters_type())
        shared = {own: name for name, own in system_names(node.name, [info.name for info in infos]).items()}
        rows += [Row(node.name, info, shared.get(info.name, "")) for info in infos]
    # the envelope alone has groups of the controller
    same = {row.info for row in rows if row.node == "winch_controller"}
    return [row for row in rows if row.node != ENVELOPE or row.info not in same]


def matching(rows: Iterable[Row], pattern: str) -> list[Row]:
    """Return the rows whose name, or shared name, fits a pattern; where none does, those whose meaning or choices do.

    Parameters
    ----------
    rows : to look in
    pattern : a part of the name, in any case, or with * and ? for the whole of it; NODE.PARAM names one
    """
    rows, wanted = list(rows), pattern.lower()
    has_wildcard = any(sign in wanted for sign in "*?[")

    def fits(text: str) -> bool:
        return fnmatch.fnmatchcase(text.lower(), wanted) if has_wildcard else wanted in text.lower()

    by_name = [row for row in rows if any(map(fits, (row.info.name, row.shared, f"{row.node}.{row.info.name}")))]
    return by_name or [row for row in rows if any(map(fits, (row.info.description, *row.info.choices)))]


def value_words(info: ParameterInfo, value: Value) -> str:
    """Return a `value` of a parameter (`info`) as it is written in a scenario."""
    if info.is_array:
        assert isinstance(value, tuple)
        return f"[{', '.join(_scalar(one) for one in value)}]"
    return _scalar(value)


def _scalar(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:.10g}" if float(f"{value:.10g}") == value else repr(value)
    text = str(value)
    return text if PLAIN.fullmatch(text) else json.dumps(text)


def range_words(info: ParameterInfo) -> str:
    """Say in few words what a parameter (`info`) may be."""
    if info.choices:
        words = ", ".join([*info.choices, *([info.also_words] if info.also else [])])
    elif info.type in (bool, str):
        words = {bool: "true, false", str: "text"}[info.type]
    elif info.minimum is not None and info.maximum is not None:
        words = f"{info.minimum:.10g} to {info.maximum:.10g}"
    elif info.minimum is not None:
        words = f"at least {info.minimum:.10g}"
    elif info.maximum is not None:
        words = f"at most {info.maximum:.10g}"
    else:
        words = "any number"
    if info.type is int and not info.choices:
        words = f"whole, {words}"
    if not info.is_array:
        return words
    return f"{info.length} of: {words}" if info.length is not None else f"list of: {words}"


PLAIN = re.compile(r"[A-Za-z0-9_./-]+")
"""Texts that need no quotes in a scenario."""

COLUMNS = ("parameter", "default", "unit", "range", "shared", "meaning")


def cells(row: Row) -> tuple[str, ...]:
    """Return what the table shows of a `row`, by COLUMNS."""
    info = row.info
    return (info.name, value_words(info, info.default), info.unit, range_words(info), row.shared, row.meaning)


def page(rows: Sequence[Row] | None = None) -> str:
    """Return the page of the given `rows` (None: of all), a table for each node, as Markdown."""
    rows = all_rows() if rows is None else rows
    parts = [HEAD]
    for node in dict.fromkeys(row.node for row in rows):
        parts.append(f"## {TITLES.get(node, f'`{node}`')}\n")
        lines = [COLUMNS, ("---",) * len(COLUMNS)]
        lines += [_marked(cells(row)) for row in rows if row.node == node]
        parts.append("\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n")
    return "\n".join(parts)


def _marked(texts: tuple[str, ...]) -> tuple[str, ...]:
    name, default, unit, allowed, shared, meaning = (text.replace("|", "\\|") for text in texts)
    return (f"`{name}`", f"`{default}`", unit, allowed, f"`{shared}`" if shared else "", meaning)


if __name__ == "__main__":
    sys.stdout.write(page())
