"""`heave kpi`: the figures of merit of bags."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from heave_node.parameters import ParameterError

from heave_bringup.commands.arguments import add_bags, add_baseline

SUMMARY = "Print the figures of merit of one or more bags, side by side."
EXAMPLES = ("heave kpi runs/b2_calm_300-001/bag --window 60 --table kpis.csv",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    add_bags(parser)
    add_baseline(parser)
    parser.add_argument(
        "--window", type=float, metavar="S", help="in --table and --json: the figures for each S seconds of the run"
    )
    parser.add_argument("--table", type=Path, metavar="FILE", help="write the figures to this .csv, .parquet or .xlsx")


def execute(options: argparse.Namespace) -> None:
    """Print the figures of one bag, or of several side by side, as `options` say."""
    from heave_bags.analyse import analysis, run_warnings
    from heave_bags.mcap.read.folder import bag_of

    from heave_bringup.output import check_output, write_result
    from heave_bringup.run.records import read_records

    check_output("--table", options.table, analysis.TABLE_ENDINGS)
    if options.window is not None and not 0.0 < options.window < math.inf:
        raise ParameterError(f"--window {options.window:g}: must be a number above 0 [s]")
    bags = [bag_of(bag) for bag in options.bags]
    records = read_records(bags, scenario=options.scenario, transient=options.transient, baseline=options.baseline)
    warned = [(record, run_warnings.warnings(record, record.kpis())) for record in records]
    results = [{**analysis.to_json(record, options.window), "warnings": own} for record, own in warned]
    reported = [f"{record.name}: {line}" for record, own in warned for line in own]
    text = "\n".join([analysis.table(records), *reported])
    if options.table is not None:
        analysis.save_frame(analysis.kpi_frame(records, options.window), options.table)
    write_result(options, text, results[0] if len(results) == 1 else {"runs": results})
