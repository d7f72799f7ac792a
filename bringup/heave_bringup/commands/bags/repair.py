"""`heave repair`: what can still be read of a damaged bag."""

from __future__ import annotations

import argparse
from pathlib import Path

from heave_bringup.errors import CommandError

SUMMARY = "Recover a damaged bag into a new one, or rebuild an index; report what is lost."
EXAMPLES = ("heave repair damaged/bag --output saved",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument("bag", metavar="BAG", type=Path, help="bag folder, folder of a run, or MCAP file")
    chosen = parser.add_mutually_exclusive_group(required=True)
    chosen.add_argument("--output", type=Path, metavar="DIR", help="folder for the repaired bag")
    chosen.add_argument("--reindex", action="store_true", help="rewrite metadata.yaml in place")


def execute(options: argparse.Namespace) -> None:
    """Save or index, and name the loss, as `options` say."""
    from heave_bags.mcap.read.folder import bag_of
    from heave_bags.mcap.repair import reindex, repair

    from heave_bringup.output import write_result
    from heave_bringup.progress import ProgressLine

    source = bag_of(options.bag)
    if options.reindex:
        bag = reindex(source)
        losses = [str(loss) for loss in bag.losses]
        text = "\n".join([f"{bag.path}: indexed, {bag.message_count} messages", *bag.notes, *losses])
        result = {"bag": str(bag.path), "messages": bag.message_count, "losses": losses, "notes": bag.notes}
        write_result(options, text, result)
        return
    with ProgressLine() as progress:
        saved = repair(source, options.output, progress=lambda share: progress.show("saving", share))
    if not saved.messages:
        raise CommandError(f"{source}: nothing in it is readable")
    losses = [str(loss) for loss in saved.losses]
    result = {"bag": str(saved.folder), "messages": saved.messages, "losses": losses, "notes": list(saved.notes)}
    write_result(options, str(saved), result)
