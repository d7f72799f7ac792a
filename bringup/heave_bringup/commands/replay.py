"""`heave replay`: publish a bag again."""

from __future__ import annotations

import argparse

from heave_bags.play.player_node import play
from heave_bags.play.player_options import options_from

from heave_bringup.bag_paths import bag_folders
from heave_bringup.output import write_result
from heave_bringup.progress import ProgressLine


def execute(options: argparse.Namespace) -> None:
    """Play to the end and say how many messages went out."""
    (bag,) = bag_folders([options.bag])
    progress = ProgressLine()
    try:
        published = play(
            bag,
            options_from(options),
            delay=options.delay,
            progress=lambda time: progress.show(f"t = {time:.1f} s"),
        )
    finally:
        progress.close()
    write_result(options, f"{bag}: {published} messages played", {"bag": str(bag), "messages": published})
