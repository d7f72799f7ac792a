"""Bags as the commands judge them: read, with the bounds that kappa needs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from heave_bags.analyse import analysis
from heave_bags.analyse.run_record import RunRecord

from heave_bringup.progress import ProgressLine
from heave_bringup.run.kappa import add_bounds


def read_records(bags: Sequence[Path]) -> list[RunRecord]:
    """Read bags, showing progress; raises BagError for the first that cannot be read."""
    with ProgressLine() as progress:
        records = analysis.analyse(bags, progress=lambda share: progress.show("reading", share))
        for record, bag in zip(records, bags, strict=True):
            progress.show("bounds of kappa")
            add_bounds(record, bag)
    return records
