"""`heave design`: what the controller of a scenario will do, before anyone starts it."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from cable_sim_node.errors import PlantError
from heave_node.parameters import ParameterError
from winch_controller_node.lqr import DesignError
from winch_controller_node.report import design_report
from winch_controller_node.report_figures import draw_report

from heave_bringup.errors import CommandError
from heave_bringup.output import write_result
from heave_bringup.progress import ProgressLine
from heave_bringup.scenarios import load_scenario


def execute(options: argparse.Namespace) -> None:
    """Print gains, poles, margins, predictions, bounds and curves; draw them."""
    if options.length is not None and not 0.0 < options.length < math.inf:
        raise ParameterError(f"--length {options.length:g}: must be a number above 0 [m]")
    scenario = load_scenario(options.scenario, settings=options.set)
    progress = ProgressLine()
    progress.show("designing, and predicting the loop")
    try:
        report = design_report(
            scenario.parameters["winch_controller"],
            tick_period=scenario.run.tick_period,
            seed=scenario.run.seed,
            length=options.length,
        )
    except (PlantError, DesignError) as error:
        where = scenario.path if options.length is None else f"--length {options.length:g} of {scenario.path}"
        raise CommandError(f"{where}: {error}") from error
    finally:
        progress.close()
    folder = options.pictures or Path(f"{scenario.name}_design")
    pictures = "\n".join(f"picture   {path.resolve()}" for path in draw_report(report, folder))
    write_result(options, f"{report.table()}\n\n{pictures}", report.values())
