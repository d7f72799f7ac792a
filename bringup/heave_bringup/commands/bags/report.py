"""`heave report`: the HTML report of bags, and on request its PDF."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

from heave_node.parameters import ParameterError

from heave_bringup.commands.arguments import add_bags, add_baseline, add_full
from heave_bringup.errors import VerdictError

SUMMARY = "Write the HTML report of one or more bags: one file that opens offline. Optionally PDF."
EXAMPLES = (
    "heave report runs/b2_calm_300-001 --pdf",
    "heave report runs/b2_calm_300-001 runs/b2_calm_300-002 --output compared.html",
)

REPORT = "report.html"
"""Name of the report of one run, in the folder of the run."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    add_bags(parser)
    add_baseline(parser)
    add_full(parser)
    parser.add_argument(
        "--output",
        type=Path,
        metavar="FILE.html",
        help=f"default: {REPORT} beside the bag; for several bags comparison-NNN.html in the folder above",
    )
    parser.add_argument(
        "--pdf", action="store_true", help="also write a PDF (A4) beside the HTML file; needs Chromium, Chrome or Edge"
    )


def execute(options: argparse.Namespace) -> None:
    """Write the report and say where it is, as `options` say."""
    from heave_bags.analyse import analysis
    from heave_bags.analyse.verdict import judge
    from heave_bags.mcap.read.folder import bag_of
    from heave_bags.report import headline
    from heave_bags.report.paper import find_browser, save_pdf
    from heave_bags.report.report import save_report

    from heave_bringup.output import check_output, write_result
    from heave_bringup.run.records import read_records

    bags = [bag_of(bag) for bag in options.bags]
    check_output("--output", options.output, (".html", ".htm"), makes_folder=True)
    output = _output(options.output, bags)
    if options.pdf:
        find_browser()
    records = read_records(bags, scenario=options.scenario, transient=options.transient, baseline=options.baseline)
    judged = [(record, judge(record, record.wanted, moves_winch=record.moves_winch)) for record in records]
    save_report(records, output, [verdict for _, verdict in judged])
    files = {"report": output.resolve()}
    if options.pdf:
        files["pdf"] = output.resolve().with_suffix(".pdf")
        save_pdf(output, files["pdf"])
    reported = [f"{record.name}: {line}" for record, one in judged for line in one.lines()]
    table = analysis.table(records) if options.full else headline.table(records)
    places = [f"{name:<9} {path}" for name, path in files.items()]
    runs = [{**analysis.to_json(record), "verdict": one.to_json()} for record, one in judged]
    result = {**{name: str(path) for name, path in files.items()}, "runs": runs}
    write_result(options, "\n".join([table, "", *places, "", *reported]), result)
    failures = [f"{record.name}: {one}" for record, of in judged for one in of.failures]
    if failures:
        raise VerdictError(failures, str(output))


def _output(given: Path | None, bags: Sequence[Path]) -> Path:
    """Return the file of the report: the one `given`, or else one that no other report of these `bags` has."""
    own = [bag.parent / REPORT for bag in bags]
    if len(bags) == 1:
        return given or own[0]
    if given is not None:
        if given.resolve() in [path.resolve() for path in own]:
            raise ParameterError(f"--output {given}: is the report of one of the runs; give a comparison another name")
        return given
    above = Path(os.path.commonpath([bag.resolve().parent.parent for bag in bags]))
    number = 1
    while (path := above / f"comparison-{number:03d}.html").exists():
        number += 1
    return path
