"""`heave list`: the shipped scenarios."""

from __future__ import annotations

import argparse

SUMMARY = "List the shipped scenarios."
EXAMPLES = ("heave list",)


def add_arguments(_: argparse.ArgumentParser) -> None:
    """Add nothing to the parser: the command has no arguments of its own."""


def execute(options: argparse.Namespace) -> None:
    """Print name and description of each scenario, as `options` say."""
    from heave_bringup.output import make_table, write_result
    from heave_bringup.scenarios import description_of, shipped_scenarios

    scenarios = {name: description_of(path) for name, path in shipped_scenarios().items()}
    write_result(options, make_table(["scenario", "description"], scenarios.items(), texts=["description"]), scenarios)
