"""`heave modes`: natural periods and mode shapes of cable and unit, and where a lowering meets resonance."""

from __future__ import annotations

import argparse
import math
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from heave_node.extras import how_to_install
from heave_node.parameters import ParameterError

from heave_bringup.commands.arguments import add_scenario
from heave_bringup.errors import CommandError

if TYPE_CHECKING:
    from cable_sim_node.reports.modes import ModesReport

SUMMARY = "Print and draw natural periods and mode shapes of rope and load, and the rope lengths that resonate."
EXAMPLES = ("heave modes b3_deep_900", "heave modes b6_resonance_payout --period 10 --longest 900")

AMPLITUDE = 0.5
"""Of the boom tip, at which drag is linearised [m]."""
MODES = 4
"""That are printed and drawn."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    add_scenario(parser)
    for name, metavar, text in (
        ("--longest", "M", "longest rope of the resonance map (default: that paid out)"),
        ("--period", "S", "find the resonant rope length for this period (default: the sea's peak period)"),
    ):
        parser.add_argument(name, type=float, metavar=metavar, help=text)
    parser.add_argument("--picture", type=Path, metavar="FILE", help="PNG or SVG (default: SCENARIO_modes.svg)")


def execute(options: argparse.Namespace) -> None:
    """Print natural periods and resonant length; draw mode shapes and the resonance map, as `options` say."""
    from cable_sim_node.errors import PlantError
    from cable_sim_node.line.observation import snapshot
    from cable_sim_node.reports.modes import modes_report
    from cable_sim_node.reports.report import PICTURE_ENDINGS
    from heave_node.numerics.compiled import is_compiled

    from heave_bringup.output import check_output, write_result
    from heave_bringup.progress import ProgressLine
    from heave_bringup.scenarios import check_lengths, load_scenario

    check_output("--picture", options.picture, PICTURE_ENDINGS)
    if options.period is not None and not 0.0 < options.period < math.inf:
        raise ParameterError(f"--period {options.period:g}: must be a number above 0")
    if options.longest is not None:
        check_lengths("--longest", [options.longest])
    scenario = load_scenario(options.scenario, settings=options.set)
    plant, sea = scenario.parameters["cable_sim"], scenario.parameters["wave_vessel"]
    sea_period = sea.period if sea.boom_tip_source == "regular" else sea.peak_period
    if not is_compiled(snapshot):
        ProgressLine().tell("compiling the plant: a few seconds, once after installation")
    try:
        report = modes_report(
            plant,
            sea_period=options.period or sea_period,
            amplitude=AMPLITUDE,
            count=MODES,
            longest=options.longest,
            boom_tip=(0.0, 0.0, plant.boom_tip_height),
        )
    except PlantError as error:
        raise CommandError(f"{scenario.path}: {error}") from error
    write_result(
        options, f"{report.table()}\n\npicture   {_drawn(report, options.picture, scenario.name)}", report.values()
    )


def _drawn(report: ModesReport, picture: Path | None, name: str) -> str:
    """Draw a `report` on the scenario `name` to the `picture` asked for, or to one of its own; say where it is."""
    from cable_sim_node.reports.report import save_picture

    if picture is None and find_spec("matplotlib") is None:
        return f"none: needs heave[design]; {how_to_install('design')}"
    path = picture or Path(f"{name}_modes.svg")
    save_picture(report, path)
    return str(path.resolve())
