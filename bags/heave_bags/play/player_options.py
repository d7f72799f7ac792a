"""The player's command-line options; free of ROS and of numpy, so that help and mistakes are answered at once."""

from __future__ import annotations

import argparse
import math
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING

from heave_bags.errors import BagError

if TYPE_CHECKING:
    from heave_bags.play.playback import PlaybackOptions

DISCOVERY_TIME = 1.0
"""Wall time that subscribers get to find the player before the first message [s]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the player's options to the `parser` of a command."""
    parser.add_argument("bag", type=Path, help="folder of the bag, or one MCAP file")
    parser.add_argument("--rate", type=float, default=1.0, help="playback speed relative to wall time (default 1)")
    parser.add_argument("--start", type=float, default=0.0, metavar="S", help="start S seconds into the bag")
    parser.add_argument("--duration", type=float, default=math.inf, metavar="S", help="play S seconds of the bag")
    parser.add_argument("--loop", action="store_true", help="start again at the end")
    parser.add_argument("--paused", action="store_true", help="start paused, until the service player/control resumes")
    parser.add_argument(
        "--topics", nargs="+", default=[], metavar="TOPIC", help="play only topics that match these patterns"
    )
    parser.add_argument(
        "--exclude", nargs="+", default=[], metavar="TOPIC", help="skip topics that match these patterns"
    )
    parser.add_argument(
        "--nodes", nargs="+", default=[], metavar="NODE", help="play only topics published by these nodes"
    )
    parser.add_argument("--remap", nargs="+", default=[], metavar="OLD:=NEW", help="publish OLD as NEW")
    parser.add_argument(
        "--delay", type=float, default=DISCOVERY_TIME, metavar="S", help="wait S seconds for subscribers"
    )


def options_from(arguments: argparse.Namespace) -> PlaybackOptions:
    """Return what the arguments of `add_arguments` say. Raises BagError where they make no sense."""
    from heave_bags.play.playback import PlaybackOptions  # noqa: PLC0415 (reads bags: numpy takes its time to load)

    remap = {}
    for text in arguments.remap:
        old, arrow, new = text.partition(":=")
        if not (old and arrow and new):
            raise BagError(f"--remap {text}: it must be OLD:=NEW")
        remap[old] = new
    own = {one.name: getattr(arguments, one.name) for one in fields(PlaybackOptions)}
    return PlaybackOptions(**{**own, "remap": remap})
