"""`heave design`: what the law lqg of a scenario will do, before anyone starts it."""

from __future__ import annotations

import argparse
from pathlib import Path

from heave_bringup.commands.arguments import add_scenario
from heave_bringup.commands.command import Command
from heave_bringup.errors import CommandError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    add_scenario(parser)
    parser.add_argument("--length", type=float, metavar="M", help="deployed length (default: the scenario's)")
    parser.add_argument(
        "--pictures", type=Path, metavar="DIR", help="folder for the figures (default: SCENARIO_design)"
    )


def execute(options: argparse.Namespace) -> None:
    """Print gains, poles, margins, predictions, bounds and curves; draw them, as `options` say."""
    from cable_sim_node.errors import PlantError
    from heave_node.numerics.linear_model import ModelError
    from winch_controller_node.design.report import design_report
    from winch_controller_node.design.report_figures import draw_report
    from winch_controller_node.model.lqr import DesignError

    from heave_bringup.output import warn, write_result
    from heave_bringup.progress import ProgressLine
    from heave_bringup.run.checks.files import vessel_warnings
    from heave_bringup.scenarios import check_lengths, load_scenario

    if options.length is not None:
        check_lengths("--length", [options.length])
    scenario = load_scenario(options.scenario, settings=options.set)
    with ProgressLine() as progress:
        progress.show("designing the controller and predicting the loop")
        try:
            report = design_report(
                scenario.parameters["winch_controller"],
                tick_period=scenario.run.tick_period,
                seed=scenario.run.seed,
                length=options.length,
            )
        except (PlantError, DesignError, ModelError) as error:
            where = scenario.path if options.length is None else f"--length {options.length:g} of {scenario.path}"
            raise CommandError(f"{where}: {error}") from error
    warn(vessel_warnings(scenario))
    folder = options.pictures or Path(f"{scenario.name}_design")
    pictures = "\n".join(f"picture   {path.resolve()}" for path in draw_report(report, folder))
    write_result(options, f"{report.table()}\n\n{pictures}", report.values())


COMMAND = Command(
    name="design",
    summary="Design the law lqg: gains, poles, margins, predicted motion, bounds, trade-offs, demand on the winch.",
    examples=("heave design b3_deep_900 --set system.sea.peak_period=12",),
    add_arguments=add_arguments,
    execute=execute,
)
