"""`heave list`: the shipped scenarios."""

from __future__ import annotations

import argparse

from heave_bringup.commands.command import Command


def execute(options: argparse.Namespace) -> None:
    """Print name and description of each scenario, as `options` say."""
    from heave_bringup.output import make_table, write_result
    from heave_bringup.scenarios import description_of, shipped_scenarios

    scenarios = {name: description_of(path) for name, path in shipped_scenarios().items()}
    write_result(options, make_table(["scenario", "description"], scenarios.items(), texts=["description"]), scenarios)


COMMAND = Command(
    name="list",
    summary="List the shipped scenarios.",
    examples=("heave list",),
    execute=execute,
)
