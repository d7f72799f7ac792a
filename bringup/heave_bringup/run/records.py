"""Bags as the commands judge them: read, with the bounds that kappa needs."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from heave_bags.analyse import analysis
from heave_bags.analyse.run_record import RunRecord

from heave_bringup.progress import ProgressLine
from heave_bringup.run.baseline import add_baseline, parameters_of
from heave_bringup.run.kappa import add_bounds
from heave_bringup.scenarios import load_scenario
from heave_bringup.tables.baseline_law import BASELINE_LAW


def read_records(
    bags: Sequence[Path],
    *,
    scenario: str | None = None,
    transient: float | None = None,
    has_baseline: bool = False,
) -> list[RunRecord]:
    """Read bags, showing progress.

    Parameters
    ----------
    bags : folders or files
    scenario : shipped name or file, for bags that do not carry the scenario of their run
    transient : start of the evaluation window [s]; None takes what each bag says, or else the scenario
    has_baseline : each run is made again under the baseline law, unless that is kept beside its bag

    Raises BagError for the first bag that cannot be read, ParameterError for a scenario that cannot be.
    """
    given = None if scenario is None else load_scenario(scenario, needs_files=False)
    parameters = None if given is None else parameters_of(given)
    with ProgressLine() as progress:
        records = analysis.analyse(
            bags,
            transient=transient,
            parameters=parameters,
            progress=lambda share: progress.show("analysing the bag", share if 0.0 < share < 1.0 else None),
        )
        for record, bag in zip(records, bags, strict=True):
            progress.show("bounds of kappa")
            add_bounds(record, bag, given)
            if has_baseline:
                words = f"{record.name} under law {BASELINE_LAW} (--no-baseline leaves it out)"
                add_baseline(record, bag, given, partial(progress.show, words))
    return records
