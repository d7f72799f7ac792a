"""`heave report`: the HTML report of bags."""

from __future__ import annotations

import argparse

from heave_bags.analyse import analysis
from heave_bags.analyse.report import save_report

from heave_bringup.bag_paths import bag_folders
from heave_bringup.output import write_result
from heave_bringup.run.records import read_records


def execute(options: argparse.Namespace) -> None:
    """Write the report and say where it is."""
    bags = bag_folders(options.bags)
    output = options.output or bags[0].parent / "report.html"
    records = read_records(bags, scenario=options.scenario, transient=options.transient)
    save_report(records, output)
    text = "\n".join([analysis.table(records), "", f"report    {output.resolve()}"])
    write_result(options, text, {"report": str(output.resolve()), "runs": [analysis.to_json(r) for r in records]})
