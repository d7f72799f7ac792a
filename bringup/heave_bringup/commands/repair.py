"""`heave repair`: what can still be read of a damaged bag."""

from __future__ import annotations

import argparse

from heave_bags.mcap.repair import reindex, repair

from heave_bringup.bag_paths import bag_folders
from heave_bringup.errors import CommandError
from heave_bringup.output import write_result
from heave_bringup.progress import ProgressLine


def execute(options: argparse.Namespace) -> None:
    """Save or index, and name the loss."""
    (source,) = bag_folders([options.bag])
    if options.reindex:
        bag = reindex(source)
        text = f"{bag.path}: indexed, {bag.message_count} messages"
        write_result(options, text, {"bag": str(bag.path), "messages": bag.message_count, "losses": []})
        return
    progress = ProgressLine()
    try:
        saved = repair(source, options.output, progress=lambda share: progress.show(f"saving {share:4.0%}"))
    finally:
        progress.close()
    if not saved.messages:
        raise CommandError(f"{source}: nothing in it can be read")
    losses = [str(loss) for loss in saved.losses]
    write_result(options, str(saved), {"bag": str(saved.folder), "messages": saved.messages, "losses": losses})
