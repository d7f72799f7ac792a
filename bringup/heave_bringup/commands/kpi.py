"""`heave kpi`: the figures of merit of bags."""

from __future__ import annotations

import argparse

from heave_bags import analysis

from heave_bringup.bag_paths import bag_folders
from heave_bringup.output import write_result
from heave_bringup.records import read_records


def execute(options: argparse.Namespace) -> None:
    """Print the figures of one bag, or of several side by side."""
    records = read_records(bag_folders(options.bags))
    results = [analysis.to_json(record) for record in records]
    write_result(options, analysis.table(records), results[0] if len(results) == 1 else {"runs": results})
