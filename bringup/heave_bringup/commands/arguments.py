"""Arguments that several subcommands have."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_settings(parser: argparse.ArgumentParser) -> None:
    """Let the user of `parser` change parameters of a scenario."""
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NODE.PARAM=VALUE",
        help="change a parameter of one node; system.PARAM changes both the ship and the controller's model of it, "
        "all.PARAM the run; may be repeated",
    )


def add_scenario(parser: argparse.ArgumentParser) -> None:
    """Let the user of `parser` name a scenario and change its parameters."""
    parser.add_argument("scenario", metavar="SCENARIO", help="a shipped scenario (heave list) or a parameter file")
    add_settings(parser)


def add_bags(parser: argparse.ArgumentParser) -> None:
    """Let the user of `parser` name one or several bags."""
    parser.add_argument("bags", metavar="BAG", type=Path, nargs="+", help="bag folder, or the folder of a run")
    parser.add_argument(
        "--transient", type=float, metavar="S", help="initial time that the figures leave out (default: the bag's)"
    )
    parser.add_argument(
        "--scenario",
        metavar="SCENARIO",
        help="scenario of the run, for bags from other recorders, which do not carry one",
    )


def add_network(parser: argparse.ArgumentParser) -> None:
    """Let the user of `parser` open the run to other hosts."""
    parser.add_argument(
        "--network", action="store_true", help="let nodes on other hosts join; without it, nothing leaves this machine"
    )
