"""`heave design`: what the law lqg of a scenario will do, before anyone starts it."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

from heave_bringup.commands.arguments import add_scenario
from heave_bringup.commands.models.loads import load_lines, refuse_failed, strengths_in
from heave_bringup.errors import CommandError

if TYPE_CHECKING:
    from winch_controller_node.design.report import DesignReport

SUMMARY = "Show what the winch must deliver (stroke, speed, torque, power), predicted motion, gains and margins."
EXAMPLES = ("heave design unit_1500 --set system.sea.peak_period=12",)

HOURS = 3.0
"""Duration of a sea state, in which the largest tension is expected [h]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    add_scenario(parser)
    parser.add_argument("--pictures", type=Path, metavar="DIR", help="draw the figures into this folder")


def execute(options: argparse.Namespace) -> None:
    """Print demand on the winch, predictions, margins, gains and curves; draw them, as `options` say."""
    from cable_sim_node.errors import PlantError
    from heave_bags.analyse.verdict import judge_loads
    from heave_node.loads.strength import load_checks
    from heave_node.numerics.linear_model import ModelError
    from winch_controller_node.design.report import design_report
    from winch_controller_node.design.report_figures import draw_report
    from winch_controller_node.model.lqr import DesignError

    from heave_bringup.output import warn, write_result
    from heave_bringup.progress import ProgressLine
    from heave_bringup.run.before import vessel_warnings
    from heave_bringup.scenarios import load_scenario

    scenario = load_scenario(options.scenario, settings=options.set)
    with ProgressLine() as progress:
        progress.show("designing the controller and predicting the loop")
        try:
            report = design_report(
                scenario.parameters["winch_controller"], tick_period=scenario.run.tick_period, seed=scenario.run.seed
            )
        except (PlantError, DesignError, ModelError) as error:
            raise CommandError(f"{scenario.path}: {error}") from error
    warn(vessel_warnings(scenario))
    drawn = [] if options.pictures is None else draw_report(report, options.pictures)
    pictures = [f"picture   {path.resolve()}" for path in drawn]
    top, unit = expected_loads(report)
    verdict = judge_loads(load_checks(strengths_in(scenario), top=top, unit=unit))
    expected = f"largest top tension expected in {HOURS:g} h: {1e-3 * top:.2f} kN (Rayleigh)"
    text = "\n".join([report.table(), expected, "", *pictures, *load_lines(verdict)])
    write_result(options, text, {**report.values(), "expected_tension_max_n": top, "verdict": verdict.to_json()})
    refuse_failed(verdict)


def expected_loads(report: DesignReport) -> tuple[float, float]:
    """Return the largest tension expected in HOURS of the design sea of a `report`, at the boom tip and at the unit
    [N].

    It has a crest in each peak period. Both are NaN for an identified cable, which knows no weights. The most probable
    largest of N crests of a narrow-banded Gaussian motion is sigma sqrt(2 ln N) above its mean (M. S. Longuet-Higgins,
    On the statistical distribution of the heights of sea waves, J. Marine Research 11, 1952).
    """
    crests = HOURS * 3600.0 / report.design.parameters.sea.peak_period
    rise = report.prediction.sigma["tension"] * math.sqrt(2.0 * math.log(crests))
    cable = report.design.cable
    top, unit = (
        weight + rise if 0.0 < weight < math.inf else math.nan for weight in (cable.static_tension, cable.unit_weight)
    )
    return top, unit
