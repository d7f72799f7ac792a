"""`heave static`: the static equilibrium of a scenario's cable and unit."""

from __future__ import annotations

import argparse
from pathlib import Path

from heave_bringup.commands.arguments import add_scenario
from heave_bringup.commands.command import Command
from heave_bringup.errors import CommandError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments."""
    add_scenario(parser)
    parser.add_argument("--picture", type=Path, metavar="FILE", help="PNG or SVG (default: SCENARIO_static.svg)")


def execute(options: argparse.Namespace) -> None:
    """Print end forces, positions, top tension and angle; draw the shape in both planes."""
    from cable_sim_node.errors import PlantError
    from cable_sim_node.statics.errors import StaticsError
    from cable_sim_node.statics.report import PICTURE_ENDINGS, draw_static, static_report

    from heave_bringup.output import check_output, write_result
    from heave_bringup.scenarios import load_scenario

    check_output("--picture", options.picture, PICTURE_ENDINGS)
    scenario = load_scenario(options.scenario, settings=options.set)
    try:
        report = static_report(scenario.parameters["cable_sim"])
    except (PlantError, StaticsError) as error:
        raise CommandError(f"{scenario.path}: {error}") from error
    picture = options.picture or Path(f"{scenario.name}_static.svg")
    draw_static(report, picture)
    write_result(options, f"{report.table()}\n\npicture   {picture.resolve()}", report.values())


COMMAND = Command(
    name="static",
    summary="Print and draw the static equilibrium of a scenario: end forces, positions, top tension and angle.",
    examples=("heave static s300_driven --set 'cable_sim.current=[0.5, 0.0]' --picture shape.png",),
    add_arguments=add_arguments,
    execute=execute,
)
