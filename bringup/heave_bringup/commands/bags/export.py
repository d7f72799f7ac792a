"""`heave export`: the signals of a bag on one time base, as CSV, Parquet or a spreadsheet."""

from __future__ import annotations

import argparse
import math
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from heave_node.parameters import ParameterError

from heave_bringup.errors import CommandError

if TYPE_CHECKING:
    from heave_bags.analyse.time_base import Column

SUMMARY = "Export the signals of a bag on a common time base as CSV, Parquet or a spreadsheet."
EXAMPLES = (
    "heave export runs/b2_calm_300-001 --table b2.csv",
    "heave export runs/b2_calm_300-001 --topics winch/state winch/load_cell --period 0.1 --table winch.parquet",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument("bag", metavar="BAG", type=Path, help="bag folder or run folder")
    parser.add_argument(
        "--table",
        type=Path,
        nargs="+",
        required=True,
        metavar="FILE",
        help="write the table to this .csv, .parquet or .xlsx (needs heave[xlsx])",
    )
    parser.add_argument(
        "--topics",
        nargs="+",
        default=[],
        metavar="TOPIC",
        help="export every number of these topics (e.g. winch/state) instead of the default signals: heave of"
        " boom tip, load and load with the winch locked, payout, tension, mode",
    )
    parser.add_argument(
        "--period", type=float, metavar="S", help="time between rows (default: that of the fastest signal)"
    )


def execute(options: argparse.Namespace) -> None:
    """Write the tables that `options` name, and say what is in them."""
    from heave_bags.analyse import time_base
    from heave_bags.analyse.analysis import TABLE_ENDINGS, legend_file, save_frame
    from heave_bags.analyse.read_run import read_run
    from heave_bags.mcap.loss import remarks
    from heave_bags.mcap.reader import Bag

    from heave_bringup.output import check_output, warn, write_result
    from heave_bringup.progress import ProgressLine

    for path in options.table:
        check_output("--table", path, TABLE_ENDINGS)
        if path.suffix.lower() == ".xlsx" and find_spec("xlsxwriter") is None:
            raise CommandError(f"--table {path}: needs the package xlsxwriter: pip install xlsxwriter")
    if options.period is not None and not time_base.SHORTEST_PERIOD <= options.period < math.inf:
        raise ParameterError(f"--period {options.period:g}: must be at least {time_base.SHORTEST_PERIOD:g} [s]")
    import_module("pandas")  # refused before the bag is read
    with ProgressLine() as progress:
        if options.topics:
            bag = Bag(options.bag)
            samples = time_base.topic_samples(bag, options.topics, lambda share: progress.show("reading", share))
            lost = remarks(bag.notes, bag.losses)
            columns = time_base.topic_columns(bag, samples)
        else:
            record = read_run(options.bag, progress=lambda share: progress.show("reading", share))
            samples, lost = time_base.run_samples(record), record.remarks()
            columns = {name: time_base.COLUMNS.get(name, time_base.MODE) for name in samples}
        frame = time_base.on_one_time_base(samples, options.period)
        progress.show("writing")
        columns = {name: columns[name] for name in frame.columns}
        legend = time_base.legend(columns)
        for path in options.table:
            save_frame(frame, path, legend)
    warn(lost)
    step = float(frame.index[1] - frame.index[0]) if len(frame) > 1 else 0.0
    span = f"{len(frame)} rows every {step:.6g} s, from {frame.index[0]:.6g} s to {frame.index[-1]:.6g} s"
    lines = [f"{path.resolve()}: {span}" for path in options.table]
    lines += [f"{legend_file(path).resolve()}: what each column is" for path in options.table if path.suffix != ".xlsx"]
    width = max(map(len, columns))
    reported = {
        "files": [str(path.resolve()) for path in options.table],
        "rows": len(frame),
        "columns": {name: one._asdict() for name, one in columns.items()},
        "remarks": lost,
    }
    described = [f"  {name:{width}}  {_described(one)}".rstrip() for name, one in columns.items()]
    write_result(options, "\n".join([*lines, *described]), reported)


def _described(column: Column) -> str:
    """Return meaning and unit of a `column` in words."""
    has_unit = not column.unit or f"[{column.unit}]" in column.meaning
    return column.meaning if has_unit else f"{column.meaning} [{column.unit}]"
