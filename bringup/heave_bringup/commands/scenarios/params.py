"""`heave params`: every parameter of every node, with unit, range, default and meaning."""

from __future__ import annotations

import argparse
import difflib
from typing import TYPE_CHECKING

from heave_node.parameters import ParameterError

from heave_bringup.commands.arguments import completed_by
from heave_bringup.nodes import NODE_BY_NAME

if TYPE_CHECKING:
    from rich.table import Table

SUMMARY = "Print the parameters of every node, with unit, range, default and meaning."
EXAMPLES = ("heave params winch_controller mpc.", "heave params peak_period", 'heave params "*noise*"')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    node = parser.add_argument(
        "node", metavar="NODE", nargs="?", help="node of the suite, or all for the run's parameters (optional)"
    )
    completed_by(node, lambda: [*NODE_BY_NAME, "all"])
    pattern = parser.add_argument(
        "pattern",
        metavar="PATTERN",
        nargs="?",
        help="part of the name, a pattern with * and ?, a word of the meaning, or a choice",
    )
    completed_by(pattern, _names)


def _names() -> list[str]:
    from heave_bringup.pages.parameters import all_rows

    return list(dict.fromkeys(row.info.name for row in all_rows()))


def execute(options: argparse.Namespace) -> None:
    """Print the parameters that `options` name."""
    from heave_bringup.output import write_result
    from heave_bringup.pages.parameters import RUN, all_rows, matching

    node, pattern = options.node, options.pattern
    if node is not None and node not in (*NODE_BY_NAME, RUN):
        if pattern is not None:
            raise ParameterError(f"there is no node {node}; known: {', '.join([*NODE_BY_NAME, RUN])}")
        node, pattern = None, node  # a pattern alone
    rows = [row for row in all_rows() if node in (None, row.node)]
    found = matching(rows, pattern) if pattern else rows
    if not found:
        near = difflib.get_close_matches(pattern, [row.info.name for row in rows], n=1, cutoff=0.5)
        hint = f"did you mean {near[0]}?" if near else "heave params prints all"
        raise ParameterError(f"no parameter{f' of {node}' if node else ''} matches {pattern}; {hint}")
    nodes = dict.fromkeys(row.node for row in found)
    parts = [part for name in nodes for part in (name, _table([row for row in found if row.node == name]))]
    write_result(options, parts, [row.to_json() for row in found])


def _table(rows: list) -> Table:  # type: ignore[type-arg]
    from heave_bringup.output import make_table
    from heave_bringup.pages.parameters import COLUMNS, cells

    lines = [cells(row) for row in rows]
    shown = [number for number, name in enumerate(COLUMNS) if name != "shared" or any(line[number] for line in lines)]
    columns = [COLUMNS[number] for number in shown]
    return make_table(columns, [[line[number] for number in shown] for line in lines], texts=columns)
