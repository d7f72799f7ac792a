"""`heave kpi`: the figures of merit of bags."""

from __future__ import annotations

import argparse

from heave_bags import analysis

from heave_bringup.bag_paths import bag_folders
from heave_bringup.output import write_result
from heave_bringup.records import read_records


def execute(options: argparse.Namespace) -> None:
    """Print the figures of one bag, or of several side by side, and of windows over time."""
    records = read_records(bag_folders(options.bags))
    results = [analysis.to_json(record, options.window) for record in records]
    text = analysis.table(records)
    if options.window is not None:
        text = "\n\n".join([text, *(analysis.window_table(record, options.window) for record in records)])
    if options.table is not None:
        analysis.save_frame(analysis.kpi_frame(records, options.window), options.table)
    write_result(options, text, results[0] if len(results) == 1 else {"runs": results})
