"""`heave extremes`: the largest motion and tension to be expected in some hours."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

from heave_node.parameters import ParameterError

if TYPE_CHECKING:
    from rich.table import Table

SUMMARY = "Print the largest motion and tension expected in 3 h of the same sea, with confidence bounds."
EXAMPLES = (
    "heave extremes runs/b3_deep_900-001/bag",
    "heave extremes b3.parquet --hours 1    # of heave campaign b3_seeds --no-baseline --output b3.parquet",
)

HOURS = 3.0
"""A stationary sea state, as design codes take it."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument(
        "source",
        metavar="BAG|TABLE.parquet",
        type=Path,
        help="bag of a long run, or result table of a campaign with many seeds",
    )
    parser.add_argument("--hours", type=float, default=HOURS, metavar="H", help="duration of the same sea (default: 3)")
    parser.add_argument(
        "--transient", type=float, metavar="S", help="initial time of a bag to exclude (default: the bag's)"
    )


def execute(options: argparse.Namespace) -> None:
    """Print what the run, or the seeds of each sea, let one expect, as `options` say."""
    from heave_bringup.output import make_table, write_result

    from heave_studies.extremes.of_run import COLUMNS, expected_of_run, table_rows, warnings_of
    from heave_studies.tables.case_table import ENDING

    if not 0.0 < options.hours < math.inf:
        raise ParameterError(f"--hours {options.hours:g}: must be a number above 0")
    duration = 3600.0 * options.hours
    if options.source.suffix == ENDING:
        from heave_studies.campaign.extremes import extremes_of_table

        if options.transient is not None:
            raise ParameterError("--transient: is for bags: the cases of a table have had theirs left out")
        found = extremes_of_table(options.source, duration)
    else:
        from heave_bags.mcap.read.folder import bag_of
        from heave_bringup.run.records import read_records

        (record,) = read_records([bag_of(options.source)], scenario=None, transient=options.transient)
        found = [(f"{record.name}, {(record.end - record.start) / 60.0:.3g} min", expected_of_run(record, duration))]
    parts: list[str | Table] = []
    for name, expected in found:
        parts += [
            f"{name}: largest in {options.hours:g} h",
            make_table(COLUMNS, table_rows(expected), texts=["by"]),
            *(f"caution: {words}" for words in warnings_of(expected)),
        ]
    seas = [{"sea": name, "expected": [one.to_json() for one in expected]} for name, expected in found]
    write_result(options, parts, {"hours": options.hours, "seas": seas})
