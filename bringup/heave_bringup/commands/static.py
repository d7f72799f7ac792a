"""`heave static`: the static equilibrium of a scenario's cable and unit."""

from __future__ import annotations

import argparse
from pathlib import Path

from cable_sim_node.errors import PlantError
from cable_sim_node.reports.hanging import PICTURE_ENDINGS, draw_static, hanging_report

from heave_bringup.errors import CommandError
from heave_bringup.output import check_output, write_result
from heave_bringup.scenarios import load_scenario


def execute(options: argparse.Namespace) -> None:
    """Print end forces, positions, top tension and angle; draw the shape in both planes."""
    check_output("--picture", options.picture, PICTURE_ENDINGS)
    scenario = load_scenario(options.scenario, settings=options.set)
    try:
        report = hanging_report(scenario.parameters["cable_sim"])
    except PlantError as error:
        raise CommandError(f"{scenario.path}: {error}") from error
    picture = options.picture or Path(f"{scenario.name}_static.svg")
    draw_static(report, picture)
    write_result(options, f"{report.table()}\n\npicture   {picture.resolve()}", report.values())
