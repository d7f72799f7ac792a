"""`heave list`: the shipped scenarios, and the catalogue of cables, units and winches that a scenario may name."""

from __future__ import annotations

import argparse

from heave_node.catalogue import KINDS, Entry, entries, find
from heave_node.loads.strength import mass_words, payload_words

SUMMARY = "List the shipped scenarios, or the cables, loads or winches with published data that a scenario can name."
EXAMPLES = ("heave list", "heave list cable", "heave list cable wire_28mm_6x36")

HOW_TO_USE = """in a scenario: system: {cable: NAME, unit: NAME, winch: NAME}; for one run: --set system.cable=NAME
all values of an entry, and its sources: heave list KIND NAME"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument("kind", nargs="?", choices=KINDS, help="list the catalogue of this kind instead of scenarios")
    parser.add_argument("name", nargs="?", metavar="NAME", help="show one entry with all its values and sources")


def execute(options: argparse.Namespace) -> None:
    """Print what `options` name: scenarios, a kind of the catalogue, or all that is known of one of its entries."""
    from heave_bringup.output import make_table, write_result

    if not options.kind:
        _list_scenarios(options)
    elif options.name:
        entry = find(options.kind, options.name)
        write_result(options, _whole(entry), [_to_json(entry)])
    else:
        shown = entries(options.kind).values()
        columns = ["name", "particulars", "what it is"]
        rows = [(entry.name, _particulars(entry), entry.title) for entry in shown]
        write_result(options, [make_table(columns, rows, texts=columns), HOW_TO_USE], [*map(_to_json, shown)])


def _list_scenarios(options: argparse.Namespace) -> None:
    """Print load, rope and description of each scenario, as `options` say."""
    from heave_bringup.output import make_table, write_result
    from heave_bringup.scenarios import description_of, load_scenario, shipped_scenarios

    rows, found = [], {}
    for name, path in shipped_scenarios().items():
        plant = load_scenario(name, needs_files=False).parameters["cable_sim"]
        submerged = plant.unit.mass - plant.water_density * plant.unit.volume
        words = description_of(path)
        rows.append((name, mass_words(plant.unit.mass), mass_words(submerged), f"{plant.length:g} m", words))
        found[name] = {
            "description": words,
            "mass_kg": plant.unit.mass,
            "mass_in_water_kg": submerged,
            "length_m": plant.length,
        }
    columns = ["scenario", "load in air", "in water", "rope", "description"]
    write_result(options, make_table(columns, rows, texts=["description"]), found)


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
