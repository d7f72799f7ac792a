"""`heave static`: a scenario's cable and unit at rest: hanging, towed, moored, at full reach, laid, or in a network."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

from heave_bringup.commands.arguments import add_scenario
from heave_bringup.commands.models.loads import load_lines, refuse_failed, strengths_in
from heave_bringup.errors import CommandError
from heave_node.parameters import ParameterError

if TYPE_CHECKING:
    from cable_sim_node.reports.report import LoadReport
    from heave_bringup.scenarios import Scenario

SUMMARY = "Print and draw the static shape of rope and load: hanging, towed, moored, at full reach, laid, in a network."
EXAMPLES = (
    "heave static s300_driven --set 'cable_sim.current=[0.5, 0.0]' --picture shape.png",
    "heave static s300_driven --towing --speed 0.5 1 1.5 2",
    "heave static s300_driven --mooring --depth 290 --offset 45 55 65 75",
    "heave static s300_driven --footprint --depth 280 --thrust 2000",
    "heave static s300_driven --laying --depth 280 --speed 0.5 1 2",
    "heave static s300_driven --network lift_and_umbilical.yaml",
)

BELONGS = {
    "speed": ("towing", "laying"),
    "course": ("towing", "mooring", "laying"),
    "depth": ("mooring", "footprint", "laying"),
    "offset": ("mooring",),
    "pull": ("mooring",),
    "thrust": ("footprint",),
    "tension_limit": ("footprint",),
    "vertical_pull": ("footprint",),
    "payout_speed": ("laying",),
    "bottom_tension": ("laying",),
}
"""Problems to which each option belongs."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the problems and their options to the parser of the command."""
    add_scenario(parser)
    problems = parser.add_mutually_exclusive_group()
    problems.set_defaults(problem="hanging")
    for name, text in (
        ("towing", "towed behind the ship at each --speed: depth and layback"),
        ("mooring", "lower end fixed to the seabed, ship offset by each --offset or pulled by each --pull"),
        ("footprint", "reach of a vehicle with --thrust, in all directions"),
        ("laying", "cable laid on the seabed at each --speed: touchdown point, suspended length"),
    ):
        problems.add_argument(f"--{name}", dest="problem", action="store_const", const=name, help=text)
    problems.add_argument("--network", type=Path, metavar="FILE", help="several cables to one load, or a net (YAML)")
    for name, metavar, text in (
        ("--speed", "M/S", "towing, laying: ship's speed over ground; several give a table"),
        ("--offset", "M", "mooring: horizontal distance from lower end to boom tip; several give a table"),
        ("--pull", "N", "mooring: horizontal force at the boom tip; several give a table"),
    ):
        parser.add_argument(name, type=float, nargs="+", metavar=metavar, help=text)
    for name, metavar, text in (
        (
            "--course",
            "DEG",
            "towing, laying, mooring: direction of ship, offset or pull, from x towards y (default: 0)",
        ),
        ("--depth", "M", "mooring, footprint, laying: water depth (default: cable_sim.seabed.depth)"),
        ("--thrust", "N", "footprint: largest horizontal thrust of the vehicle"),
        ("--tension-limit", "N", "footprint: largest tension at the boom tip (default: none)"),
        (
            "--vertical-pull",
            "N",
            "footprint: vertical pull that lifts the vehicle (default: its weight in water)",
        ),
        (
            "--payout-speed",
            "M/S",
            "laying: payout speed (default: enough to follow seabed.slope)",
        ),
        ("--bottom-tension", "N", "laying: tension of the cable at touchdown (default: 0)"),
    ):
        parser.add_argument(name, type=float, metavar=metavar, help=text)
    parser.add_argument("--picture", type=Path, metavar="FILE", help="PNG or SVG (default: SCENARIO_PROBLEM.svg)")


def execute(options: argparse.Namespace) -> None:
    """Print the equilibrium of the requested problem, and draw it, as `options` say."""
    from cable_sim_node.errors import PlantError
    from cable_sim_node.reports.report import PICTURE_ENDINGS, save_picture
    from heave_bags.analyse.verdict import judge_loads
    from heave_bringup.output import check_output, write_result
    from heave_bringup.progress import ProgressLine
    from heave_bringup.scenarios import load_scenario
    from heave_node.loads.strength import load_checks
    from heave_node.numerics.compiled import is_compiled

    from heave_statics.march import march

    check_output("--picture", options.picture, PICTURE_ENDINGS)
    check_options(options)
    scenario = load_scenario(options.scenario, settings=options.set)
    if not is_compiled(march):
        ProgressLine().tell("compiling the static solver: a few seconds, once after installation")
    try:
        report = _report(scenario, options)
    except PlantError as error:
        raise CommandError(f"{scenario.path}: {error}") from error
    suffix = "static" if options.problem == "hanging" else options.problem
    picture = options.picture or Path(f"{scenario.name}_{suffix}.svg")
    save_picture(report, picture)
    verdict = judge_loads(load_checks(strengths_in(scenario), top=report.largest_tension, unit=report.unit_load))
    text = "\n".join([report.table(), "", f"picture   {picture.resolve()}", *load_lines(verdict)])
    write_result(options, text, {**report.values(), "verdict": verdict.to_json()})
    refuse_failed(verdict)


def check_options(options: argparse.Namespace) -> None:
    """Refuse, naming it, one of `options` that the problem does not have or whose value cannot be."""
    if options.network is not None:
        options.problem = "network"
    for name, problems in BELONGS.items():
        values = getattr(options, name)
        if values is None:
            continue
        option = f"--{name.replace('_', '-')}"
        if options.problem not in problems:
            raise ParameterError(f"{option}: needs {' or '.join(f'--{problem}' for problem in problems)}")
        for value in values if isinstance(values, list) else [values]:
            if not math.isfinite(value):
                raise ParameterError(f"{option} {value:g}: must be a finite number")
            if value < 0.0 and name not in ("course", "offset"):
                raise ParameterError(f"{option} {value:g}: must not be negative")
    if options.problem in ("towing", "laying") and options.speed is None:
        raise ParameterError(f"--{options.problem}: give --speed M/S, one or more")
    if options.problem == "mooring" and options.offset is None and options.pull is None:
        raise ParameterError("--mooring: give --offset M or --pull N, one or more")
    if options.problem == "footprint" and options.thrust is None:
        raise ParameterError("--footprint: give --thrust N")


def _depth(scenario: Scenario, options: argparse.Namespace) -> float:
    """Return the depth of the bottom [m]."""
    depth = options.depth or scenario.parameters["cable_sim"].seabed.depth
    if not depth > 0.0:
        raise ParameterError(
            f"--{options.problem}: {scenario.name} has no seabed: give --depth M or --set cable_sim.seabed.depth=M"
        )
    return float(depth)


def _report(scenario: Scenario, options: argparse.Namespace) -> LoadReport:
    """Return the report of the requested problem."""
    from heave_statics.reports.footprint import footprint_report
    from heave_statics.reports.hanging import hanging_report
    from heave_statics.reports.laying import laying_report
    from heave_statics.reports.mooring import mooring_report
    from heave_statics.reports.network import network_report
    from heave_statics.reports.towing import towing_report

    plant = scenario.parameters["cable_sim"]
    height, course = plant.boom_tip_height, math.radians(options.course or 0.0)
    tip = (0.0, 0.0, height)
    if options.problem == "network":
        return network_report(plant, options.network, tip)
    if options.problem == "hanging":
        return hanging_report(plant, tip)
    if options.problem == "towing":
        return towing_report(plant, options.speed, course=course, boom_tip=tip)
    depth = _depth(scenario, options)
    if options.problem == "mooring":
        offsets, pulls = options.offset or (), options.pull or ()
        return mooring_report(plant, depth, offsets=offsets, pulls=pulls, direction=course, boom_tip_height=height)
    if options.problem == "footprint":
        limit = math.inf if options.tension_limit is None else options.tension_limit
        pull = options.vertical_pull
        return footprint_report(
            plant, depth, options.thrust, tension_limit=limit, vertical_pull=pull, boom_tip_height=height
        )
    return laying_report(
        *(plant, depth, options.speed),
        course=course,
        rise=math.cos(course) * plant.seabed.slope[0] + math.sin(course) * plant.seabed.slope[1],
        payout_speed=options.payout_speed,
        bottom_tension=options.bottom_tension or 0.0,
        boom_tip_height=height,
    )
