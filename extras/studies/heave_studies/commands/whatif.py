"""`heave whatif`: what another law, gain or winch would have done in the sea of a bag."""

from __future__ import annotations

import argparse
from pathlib import Path

from heave_bringup.commands.arguments import add_settings

SUMMARY = "Experimental: predict from a bag's sensors what another law, gain or winch would have done in its sea."
EXAMPLES = ("heave whatif runs/b2_calm_300-001/bag --law off,industrial,lqg,mpc",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument("bag", metavar="BAG", type=Path, help="bag folder or run folder")
    parser.add_argument("--law", default="", metavar="LAW,LAW", help="laws to predict (default: the recorded one)")
    add_settings(parser)
    parser.add_argument("--end", type=float, metavar="S", help="ignore the bag after this time")


def execute(options: argparse.Namespace) -> None:
    """Answer, as `options` say."""
    from heave_bags.mcap.read.folder import bag_of
    from heave_bringup.output import make_table, warn, write_result
    from heave_bringup.progress import ProgressLine

    from heave_studies.whatif.fitness import ANSWERS, EXPERIMENTAL, lines_before, to_json
    from heave_studies.whatif.question import ask

    warn([EXPERIMENTAL])
    with ProgressLine() as progress:
        laws = list(filter(None, options.law.split(",")))
        result = ask(bag_of(options.bag), laws, options.set, options.end, show=progress.show)
    warn(result.warnings)
    table = make_table(ANSWERS.headings, ANSWERS.cells(result.rows))
    write_result(options, ["\n".join(lines_before(result)), table, "bands are of 90 %"], to_json(result))
