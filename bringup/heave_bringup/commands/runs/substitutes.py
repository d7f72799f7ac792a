"""What takes the place of a node in `heave run`: a bag in which it is recorded, or an FMU of a drive."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from heave_node.extras import how_to_install
from heave_node.parameters import ParameterError

from heave_bringup.errors import CommandError
from heave_bringup.nodes import NODE_BY_NAME

WINCH = "virtual_winch"


def add_substitutes(parser: argparse.ArgumentParser) -> None:
    """Let the user of `parser` put a bag or an FMU in the place of a node."""
    parser.add_argument(
        "--from-bag",
        action="append",
        default=[],
        metavar="NODE=BAG",
        help="play back what NODE published in BAG in place of NODE; the other nodes run live",
    )
    parser.add_argument(
        "--winch-fmu",
        type=Path,
        metavar="FILE",
        help=f"a drive in place of {WINCH}: an FMU, or a map that names one and its variables (.yaml). The code in an "
        "FMU runs as yours: name only one that you trust; needs the package fmpy",
    )


def substitutes(options: argparse.Namespace) -> dict[str, Path]:
    """Return the file or folder by the node whose place it takes, as `options` say."""
    chosen = _bags(options.from_bag)
    drive: Path | None = options.winch_fmu
    if drive is None:
        return chosen
    external = [name.partition("=")[0] for name in options.external]
    if WINCH in (*chosen, *options.foreign, *external):
        raise ParameterError(f"--winch-fmu {drive}: {WINCH} is replaced already")
    if find_spec("fmpy") is None:
        raise CommandError(f"--winch-fmu {drive}: needs the package fmpy; {how_to_install('fmu')}")
    from heave_fmu.drive import drive_names, read_drive

    drive_names(read_drive(drive))
    return {**chosen, WINCH: drive.resolve()}


def _bags(settings: Sequence[str]) -> dict[str, Path]:
    """Return which bag is played in place of which node, from the command's NODE=BAG texts."""
    from heave_bags.mcap.read.folder import bag_of

    chosen: dict[str, Path] = {}
    for setting in settings:
        node, _, bag = setting.partition("=")
        if node not in NODE_BY_NAME or not bag:
            raise ParameterError(f"--from-bag {setting}: must be NODE=BAG, NODE one of {', '.join(NODE_BY_NAME)}")
        chosen[node] = bag_of(Path(bag).resolve())
        if not chosen[node].exists():
            raise ParameterError(f"--from-bag {setting}: no such bag: {bag}")
    return chosen
