"""`heave replay`: publish a bag again."""

from __future__ import annotations

import argparse

from heave_bags.play.player_options import add_arguments

from heave_bringup.commands.command import Command


def execute(options: argparse.Namespace) -> None:
    """Play to the end and say how many messages went out, as `options` say."""
    from heave_bags.play.player_node import play
    from heave_bags.play.player_options import options_from

    from heave_bringup.bag_paths import bag_folders
    from heave_bringup.output import write_result
    from heave_bringup.progress import ProgressLine

    (bag,) = bag_folders([options.bag])
    with ProgressLine() as progress:
        played = play(
            bag,
            options_from(options),
            delay=options.delay,
            progress=lambda time: progress.show(f"t = {time:.1f} s"),
        )
    text = [f"{bag}: {played.messages} messages played", *played.left_out.values(), *played.notes]
    result = {
        "bag": str(bag),
        "messages": played.messages,
        "left_out": dict(played.left_out),
        "notes": list(played.notes),
    }
    write_result(options, "\n".join(text), result)


COMMAND = Command(
    name="replay",
    summary="Republish a bag with the recorded types and quality of service, and /clock.",
    examples=("heave replay runs/b2_calm_300-001/bag --rate 4 --nodes wave_vessel",),
    add_arguments=add_arguments,
    execute=execute,
)
