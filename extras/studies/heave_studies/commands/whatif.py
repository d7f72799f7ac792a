"""`heave whatif`: what another law, gain or winch would have done in the sea of a bag."""

from __future__ import annotations

import argparse
from pathlib import Path

from heave_bringup.commands.arguments import add_settings
from heave_bringup.errors import CommandError

from heave_studies.whatif import DRAWS

SUMMARY = "Experimental: predict from a bag's sensors what another law, gain or winch would have done in its sea."
EXAMPLES = ("heave whatif runs/b2_calm_300-001/bag --compare off,industrial,lqg,mpc",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument("bag", metavar="BAG", type=Path, help="bag folder or run folder")
    parser.add_argument("--law", default="", help="law to predict (default: the recorded one)")
    parser.add_argument(
        "--compare", default="", metavar="LAW,LAW", help="more laws to compare, such as off,industrial,lqg,mpc"
    )
    add_settings(parser)
    parser.add_argument(
        "--know",
        action="append",
        default=[],
        metavar="NAME=VALUE+-SPREAD",
        help="what you know better than the scenario, with its standard deviation: cable.axial_stiffness=1.42e7+-2%%, "
        "cable.inertia_factor, cable.damping_factor, cable.drag_factor, cable.stiffness_factor, mru.scale, mru.delay "
        "[s] or mru.lever_arm [m]; may be repeated",
    )
    parser.add_argument(
        "--scenario", metavar="SCENARIO", help="scenario of the run, for a bag that does not contain one"
    )
    parser.add_argument(
        "--transient", type=float, metavar="S", help="initial time to exclude (default: the scenario's)"
    )
    parser.add_argument("--end", type=float, metavar="S", help="ignore the bag after this time")
    parser.add_argument(
        "--draws",
        type=int,
        default=DRAWS,
        metavar="N",
        help="number of plants for the uncertainty bands (default: %(default)s)",
    )
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="seed of the draws (default: 1)")
    parser.add_argument(
        "--output", type=Path, metavar="FILE", help="page to write (default: whatif.html beside the bag)"
    )


def execute(options: argparse.Namespace) -> None:
    """Answer and write the page, as `options` say."""
    from heave_bags.mcap.read.folder import bag_of
    from heave_bringup.output import check_output, make_table, warn, write_result
    from heave_bringup.progress import ProgressLine

    from heave_studies.whatif.fitness import warnings
    from heave_studies.whatif.page import render
    from heave_studies.whatif.question import Question, ask
    from heave_studies.whatif.words import (
        EXPERIMENTAL,
        IDENTIFIED,
        causes,
        headings,
        identified_rows,
        lines_before,
        rows,
        to_json,
    )

    warn([EXPERIMENTAL])
    check_output("--output", options.output, (".html",))
    folder = bag_of(options.bag)
    page = options.output or folder.parent / "whatif.html"
    check_output("--output", page)
    question = Question(
        options.law,
        [one for one in options.compare.split(",") if one],
        options.set,
        options.know,
        options.scenario or "",
        options.transient,
        options.end,
        options.draws,
        options.seed,
    )
    with ProgressLine() as progress:
        result = ask(folder, question, show=progress.show)
        progress.show("the page", 0.0)
        text = render(f"{folder.resolve().parent.name}: what would have been", result)
        progress.show("the page", 1.0)
    try:
        page.write_text(text, encoding="utf-8")
    except OSError as error:
        raise CommandError(f"{page}: cannot be written: {error.strerror}") from error
    table = make_table(headings(), rows(result))
    values = make_table(IDENTIFIED, identified_rows(result.known), texts=IDENTIFIED[-1:])
    lines = [*lines_before(result), *causes(result.answers)]
    warn(warnings(result.known, result.answers))
    ends = f"bands are of 90 %\n\npage      {page.resolve()}"
    write_result(options, ["\n".join(lines), table, values, ends], {**to_json(result), "page": str(page.resolve())})
