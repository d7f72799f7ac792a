"""The command line of `heave`: every subcommand's arguments, help and example."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any, NoReturn

from heave_bags.play.player_options import add_arguments
from heave_node.run_parameters import LOCKSTEP, REALTIME

from heave_bringup.commands import modes, static
from heave_bringup.run.node_table import NODE_BY_NAME


class OneLineParser(argparse.ArgumentParser):
    """Complains in one line."""

    def error(self, message: str) -> NoReturn:
        """Say what is wrong and where help is, and exit with status 2."""
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the whole command; the chosen subcommand is in `command`."""
    parser = OneLineParser(
        prog="heave",
        description="Active heave compensation: run scenarios over ROS 2, record, replay, analyse, design.",
        epilog="example: heave run b2_calm_300 --duration 600",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for add in (
        *(_add_run, _add_list, _add_report, _add_kpi, _add_record, _add_replay, _add_import, _add_repair),
        *(_add_design, _add_identify, _add_static, _add_modes, _add_campaign, _add_bench),
    ):
        add(commands)
    return parser


def _add(commands: Any, name: str, description: str, example: str) -> argparse.ArgumentParser:
    """Add a subcommand with its example in the help, and the options that all have."""
    parser: argparse.ArgumentParser = commands.add_parser(
        name,
        help=description[0].lower() + description[1:].rstrip("."),
        description=description,
        epilog=f"example: {example}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.set_defaults(module=name)
    parser.add_argument(
        "--json", metavar="FILE", help="write the result as JSON; - for standard output, and nothing else there"
    )
    return parser


def _add_scenario(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenario", metavar="SCENARIO", help="a shipped scenario (heave list) or a parameter file")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NODE.PARAM=VALUE",
        help="change a parameter; NODE may be all; may be given again",
    )


def _add_run(commands: Any) -> None:
    parser = _add(
        commands,
        "run",
        "Run a scenario: start its nodes, record every topic, print the figures of merit, write a report.",
        "heave run b2_calm_300 --duration 600 --set wave_vessel.peak_period=7",
    )
    _add_scenario(parser)
    parser.add_argument("--pacing", choices=(LOCKSTEP, REALTIME), help="as fast as possible, or against the wall clock")
    parser.add_argument("--duration", type=float, metavar="S", help="simulated seconds")
    parser.add_argument("--seed", type=int, metavar="N", help="seed of every random number")
    parser.add_argument(
        "--bag", type=Path, metavar="DIR", help="folder for the bag and the report (default: runs/SCENARIO-NNN)"
    )
    parser.add_argument(
        "--external",
        action="append",
        default=[],
        metavar="NODE",
        choices=tuple(NODE_BY_NAME),
        help="do not start NODE: hardware or another program takes its place (real time)",
    )
    parser.add_argument(
        "--from-bag",
        action="append",
        default=[],
        metavar="NODE=BAG",
        help="play what NODE published in BAG in its place; the other nodes run live",
    )
    parser.add_argument(
        "--network", action="store_true", help="let nodes on other hosts join; without it nothing leaves this machine"
    )
    parser.add_argument("--no-report", action="store_true", help="leave out the HTML report")


def _add_list(commands: Any) -> None:
    _add(commands, "list", "List the shipped scenarios.", "heave list")


def _add_judgement(parser: argparse.ArgumentParser) -> None:
    """Add what a bag of another recorder does not say of its run."""
    parser.add_argument("--transient", type=float, metavar="S", help="time that no figure counts (default: the bag's)")
    parser.add_argument(
        "--scenario", metavar="SCENARIO", help="scenario of the run, for bags of other recorders, which carry none"
    )


def _add_report(commands: Any) -> None:
    parser = _add(
        commands,
        "report",
        "Write the HTML report of one or several bags: one file that opens offline.",
        "heave report runs/b2_calm_300-001/bag --output report.html",
    )
    parser.add_argument("bags", metavar="BAG", type=Path, nargs="+", help="bag folder, or the folder of a run")
    _add_judgement(parser)
    parser.add_argument("--output", type=Path, metavar="FILE", help="default: report.html beside the first bag")


def _add_kpi(commands: Any) -> None:
    parser = _add(
        commands,
        "kpi",
        "Print the figures of merit of one or several bags, side by side.",
        "heave kpi runs/b2_calm_300-001/bag --window 60 --table kpis.csv",
    )
    parser.add_argument("bags", metavar="BAG", type=Path, nargs="+", help="bag folder, or the folder of a run")
    _add_judgement(parser)
    parser.add_argument("--window", type=float, metavar="S", help="figures of each S seconds of the run as well")
    parser.add_argument("--table", type=Path, metavar="FILE", help="write the figures to a .csv or .parquet file")


def _add_static(commands: Any) -> None:
    parser = _add(
        commands,
        "static",
        "Print and draw cable and unit at rest: hanging, towed, moored, at the end of their reach, or laid.",
        static.EXAMPLES,
    )
    _add_scenario(parser)
    static.add_arguments(parser)


def _add_modes(commands: Any) -> None:
    parser = _add(
        commands,
        "modes",
        "Print and draw natural periods and mode shapes of cable and unit, and the lengths that resonate with the sea.",
        modes.EXAMPLES,
    )
    _add_scenario(parser)
    modes.add_arguments(parser)


def _add_design(commands: Any) -> None:
    parser = _add(
        commands,
        "design",
        "Design a controller: gains, poles, margins, predicted motion, bounds, trade-offs, demand on the winch.",
        "heave design b3_deep_900 --set winch_controller.sea.peak_period=12",
    )
    _add_scenario(parser)
    parser.add_argument("--length", type=float, metavar="M", help="deployed length (default: the scenario's)")
    parser.add_argument("--pictures", type=Path, metavar="DIR", help="folder of the figures (default: SCENARIO_design)")


def _add_identify(commands: Any) -> None:
    parser = _add(
        commands,
        "identify",
        "Identify the two-state cable, a z'' + b z' + z = z0 - p, from a simulated or a recorded response.",
        "heave identify b3_deep_900 --drag quadratic",
    )
    parser.add_argument("source", metavar="SCENARIO|BAG", help="a shipped scenario, a parameter file, or a bag folder")
    parser.add_argument("--set", action="append", default=[], metavar="NODE.PARAM=VALUE", help="change a parameter")
    parser.add_argument("--drag", choices=("linear", "quadratic"), default="linear", help="thesis Eq. 6.2 or Eq. 6.3")
    parser.add_argument("--lengths", type=float, nargs="+", metavar="M", help="identify at each of these lengths")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="default: NAME_identify.svg")


def _add_campaign(commands: Any) -> None:
    parser = _add(
        commands,
        "campaign",
        "Run many cases of a scenario (seeds, a grid, random draws) without ROS, and print one table.",
        "heave campaign b9_model_error --json result.json",
    )
    parser.add_argument(
        "campaign", metavar="CAMPAIGN", help="a shipped campaign, or a file (heave_bringup/campaign.py says its form)"
    )
    parser.add_argument("--processes", type=int, metavar="N", help="default: one per processor")
    parser.add_argument("--duration", type=float, metavar="S", help="simulated time of a case, instead of the file's")
    parser.add_argument("--draws", type=int, metavar="N", help="only the first N of the file's random draws")


def _add_replay(commands: Any) -> None:
    parser = _add(
        commands,
        "replay",
        "Publish a bag again, with the recorded types and quality of service, and /clock.",
        "heave replay runs/b2_calm_300-001/bag --rate 4 --nodes wave_vessel",
    )
    add_arguments(parser)


def _add_import(commands: Any) -> None:
    parser = _add(
        commands,
        "import",
        "Make a sea of a ship's own record: a bag of any standard motion type, or a CSV log.",
        "heave import sea_trial/ --topic /imu/data --output sea.csv",
    )
    parser.add_argument("source", metavar="BAG|CSV", type=Path, help="bag folder, MCAP file or CSV log")
    parser.set_defaults(module="import_sea")
    chosen = parser.add_mutually_exclusive_group(required=True)
    chosen.add_argument("--topic", help="the one topic of a standard type that holds the motion")
    chosen.add_argument("--mapping", type=Path, metavar="FILE", help="mapping file: where surge, heave, roll... are")
    parser.add_argument("--output", type=Path, required=True, metavar="FILE", help="CSV for wave_vessel's file source")


def _add_repair(commands: Any) -> None:
    parser = _add(
        commands,
        "repair",
        "Save what can be read of a damaged bag into a sound one, or index a folder anew; say what is lost.",
        "heave repair damaged/bag --output saved",
    )
    parser.add_argument("bag", metavar="BAG", type=Path, help="bag folder, folder of a run, or MCAP file")
    chosen = parser.add_mutually_exclusive_group(required=True)
    chosen.add_argument("--output", type=Path, metavar="DIR", help="folder of the sound bag")
    chosen.add_argument("--reindex", action="store_true", help="write metadata.yaml anew, in place")


def _add_bench(commands: Any) -> None:
    parser = _add(
        commands,
        "bench",
        "Measure the speed of plant (beside MoorDyn), loop over ROS, controller and recorder on this machine.",
        "heave bench --only loop controller --json bench.json",
    )
    parts = ("plant", "loop", "controller", "recorder")
    parser.add_argument("--only", nargs="+", choices=parts, default=parts, metavar="PART", help=", ".join(parts))
    parser.add_argument("--seconds", type=float, default=120.0, metavar="S", help="length of each measurement")


def _add_record(commands: Any) -> None:
    parser = _add(
        commands,
        "record",
        "Record every topic that appears, of any type, on a ship or beside any other program, until Ctrl-C.",
        "heave record sea_trial --set split_duration=600.0",
    )
    parser.add_argument("directory", metavar="DIR", type=Path, help="folder of the bag; it must not exist yet")
    parser.add_argument(
        "--set", action="append", default=[], metavar="PARAM=VALUE", help="change a parameter of the recorder"
    )
    parser.add_argument(
        "--network", action="store_true", help="let nodes on other hosts join; without it nothing leaves this machine"
    )
