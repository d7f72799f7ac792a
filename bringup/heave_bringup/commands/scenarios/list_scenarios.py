"""`heave list`: the shipped scenarios."""

from __future__ import annotations

import argparse

SUMMARY = "List the shipped scenarios, with load in air and in water, rope length and purpose."
EXAMPLES = ("heave list",)


def add_arguments(_: argparse.ArgumentParser) -> None:
    """Add nothing to the parser: the command has no arguments of its own."""


def execute(options: argparse.Namespace) -> None:
    """Print load, rope and description of each scenario, as `options` say."""
    from heave_node.loads.strength import mass_words

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
