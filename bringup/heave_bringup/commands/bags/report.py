"""`heave report`: the HTML report of bags."""

from __future__ import annotations

import argparse
from pathlib import Path

from heave_bringup.commands.arguments import add_bags, add_baseline
from heave_bringup.commands.command import Command
from heave_bringup.errors import VerdictError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    add_bags(parser)
    add_baseline(parser)
    parser.add_argument("--output", type=Path, metavar="FILE", help="default: report.html beside the first bag")


def execute(options: argparse.Namespace) -> None:
    """Write the report and say where it is, as `options` say."""
    from heave_bags.analyse import analysis
    from heave_bags.analyse.report import save_report
    from heave_bags.analyse.verdict import judge

    from heave_bringup.bag_paths import bag_folders
    from heave_bringup.output import write_result
    from heave_bringup.run.records import read_records

    bags = bag_folders(options.bags)
    output = options.output or bags[0].parent / "report.html"
    records = read_records(bags, scenario=options.scenario, transient=options.transient, has_baseline=options.baseline)
    verdicts = [judge(record, record.wanted, moves_winch=record.moves_winch) for record in records]
    save_report(records, output, verdicts)
    told = [f"{record.name}: {line}" for record, one in zip(records, verdicts, strict=True) for line in one.lines()]
    text = "\n".join([analysis.table(records), "", f"report    {output.resolve()}", "", *told])
    runs = [
        {**analysis.to_json(record), "verdict": one.to_json()} for record, one in zip(records, verdicts, strict=True)
    ]
    write_result(options, text, {"report": str(output.resolve()), "runs": runs})
    failures = [f"{record.name}: {one}" for record, of in zip(records, verdicts, strict=True) for one in of.failures]
    if failures:
        raise VerdictError(failures)


COMMAND = Command(
    name="report",
    summary="Write the HTML report of one or several bags: one file that opens offline.",
    examples=("heave report runs/b2_calm_300-001/bag --output report.html",),
    add_arguments=add_arguments,
    execute=execute,
)
