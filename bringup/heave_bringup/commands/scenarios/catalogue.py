"""`heave catalogue`: cables, units and winches with published particulars, to be named in a scenario."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from heave_node.catalogue import KINDS, Entry, entries, find
from heave_node.loads.strength import payload_words

if TYPE_CHECKING:
    from rich.table import Table

SUMMARY = "List cables, loads and winches with published data that a scenario can refer to by name."
EXAMPLES = ("heave catalogue cable", "heave catalogue cable wire_28mm_6x36")

HOW_TO_USE = """in a scenario: system: {cable: NAME, unit: NAME, winch: NAME}; for one run: --set system.cable=NAME
all values of an entry, and its sources: heave catalogue KIND NAME"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument("kind", nargs="?", choices=KINDS, help="list one kind only")
    parser.add_argument("name", nargs="?", metavar="NAME", help="show one entry with all its values and sources")


def execute(options: argparse.Namespace) -> None:
    """Print the entries that `options` name; a single one with all that is known of it."""
    from heave_bringup.output import make_table, write_result

    parts: list[str | Table] = []
    if options.name:
        shown = [find(options.kind, options.name)]
        parts = [_whole(shown[0])]
    else:
        kinds = [options.kind] if options.kind else KINDS
        shown = [entry for kind in kinds for entry in entries(kind).values()]
        rows = [(entry.kind, entry.name, _particulars(entry), entry.title) for entry in shown]
        columns = ["kind", "name", "particulars", "what it is"]
        parts = [make_table(columns, rows, texts=columns), HOW_TO_USE]
    write_result(options, parts, [_to_json(entry) for entry in shown])


def _particulars(entry: Entry) -> str:
    values = entry.values
    if entry.kind == "cable":
        force = f", breaks at {1e-3 * entry.breaking_force:.0f} kN" if entry.breaking_force else ""
        return f"{values['mass_per_length']:.2f} kg/m, EA {1e-6 * float(str(values['axial_stiffness'])):.1f} MN{force}"
    if entry.kind == "unit":
        return payload_words(float(str(values["mass"])), float(str(values["volume"])))
    return ", ".join(
        f"{name} {value}" for name, value in values.items() if name.endswith(("constant", "limit", "rate"))
    )


def _whole(entry: Entry) -> str:
    lines = [f"{entry.name}: {entry.title}"]
    lines += [f"  system.{entry.kind}.{name}: {value}" for name, value in entry.values.items()]
    return "\n".join([*lines, *(f"source: {source}" for source in entry.sources)])


def _to_json(entry: Entry) -> dict[str, object]:
    return {
        "kind": entry.kind,
        "name": entry.name,
        "title": entry.title,
        "sources": list(entry.sources),
        "values": dict(entry.values),
        "breaking_force_n": entry.breaking_force or None,
    }
