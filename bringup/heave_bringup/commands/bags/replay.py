"""`heave replay`: publish a bag again, or have an adviser answer it again."""

from __future__ import annotations

import argparse
from pathlib import Path

from heave_bags.play.player_options import add_arguments as add_player_arguments

from heave_bringup.errors import CommandError

SUMMARY = "Republish a bag with its recorded types, quality of service and /clock, or re-run the adviser on it."
EXAMPLES = (
    "heave replay runs/b2_calm_300-001/bag --rate 4 --nodes wave_vessel",
    "heave replay runs/b2_calm_300-001/bag --adviser",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    add_player_arguments(parser)
    parser.add_argument(
        "--adviser",
        action="store_true",
        help="publish nothing: re-run the adviser on the bag's observations and compare its results with the "
        "recorded ones, bit for bit",
    )


def execute(options: argparse.Namespace) -> None:
    """Play, or have an adviser answer again, as `options` say."""
    from heave_bags.mcap.read.folder import bag_of

    bag = bag_of(options.bag)
    if options.adviser:
        _advise_again(bag, options)
    else:
        _play(bag, options)


def _advise_again(path: Path, options: argparse.Namespace) -> None:
    """Answer the observations in a bag again, and say whether its beliefs are the same."""
    from heave_bags.mcap.reader import Bag
    from heave_node.interface import topics
    from winch_controller_node.advice.answering import compare_again
    from winch_controller_node.adviser_node import WinchAdviserNode

    from heave_bringup.output import write_result

    bag = Bag(path)
    asked, answered = topics.CONTROLLER_OBSERVATIONS.name, topics.CONTROLLER_BELIEFS.name
    for name in (asked, answered):
        if not bag.has(name):
            raise CommandError(f"{path}: no messages on {name}: record a run with winch_adviser")
    period = float(bag.run.get("tick_period_s", "nan"))
    if not period > 0.0:
        raise CommandError(f"{path}: it does not say its tick period; only the suite's recorder does")
    recorded = [(content.asked, message.data) for message, content in bag.decoded([answered])]
    questions = (content for _, content in bag.decoded([asked]))
    try:
        found = compare_again(questions, recorded, WinchAdviserNode.make_adviser, period)
    except ValueError as error:
        raise CommandError(f"{path}: {error}") from error
    result = {"bag": str(path), **vars(found)}
    if not found.is_same:
        write_result(options, [], result)
        first = f", first that to tick {found.different[0]}" if found.different else ""
        unasked = f"; {found.unasked} without observations" if found.unasked else ""
        raise CommandError(f"{path}: {len(found.different)} of {len(recorded)} answers differ{first}{unasked}")
    text = f"{path}: {found.equal} answers equal the recorded beliefs, bit for bit; {found.unrecorded} not recorded"
    write_result(options, text, result)


def _play(bag: Path, options: argparse.Namespace) -> None:
    """Play to the end and say how many messages went out, as `options` say."""
    from heave_bags.play.player_node import play
    from heave_bags.play.player_options import options_from

    from heave_bringup.output import write_result
    from heave_bringup.progress import ProgressLine

    with ProgressLine() as progress:
        played = play(
            bag, options_from(options), delay=options.delay, progress=lambda time: progress.show(f"t = {time:.1f} s")
        )
    text = [f"{bag}: {played.messages} messages played", *played.left_out.values(), *played.notes]
    result = {
        "bag": str(bag),
        "messages": played.messages,
        "left_out": dict(played.left_out),
        "notes": list(played.notes),
    }
    write_result(options, "\n".join(text), result)
