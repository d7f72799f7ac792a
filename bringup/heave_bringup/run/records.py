"""Bags as the commands judge them: read, with the bounds that kappa needs."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from heave_bags.analyse import analysis
from heave_bags.analyse.run_record import RunRecord
from heave_studies.baseline import add_baseline, parameters_of
from heave_studies.kappa import add_bounds

from heave_bringup.output import warn
from heave_bringup.progress import ProgressLine
from heave_bringup.run.baseline_law import BASELINE_LAW
from heave_bringup.scenarios import load_scenario


def read_records(
    bags: Sequence[Path],
    *,
    scenario: str | None = None,
    transient: float | None = None,
    has_baseline: bool = False,
    whatif: bool | None = False,
) -> list[RunRecord]:
    """Read bags, showing progress.

    Parameters
    ----------
    bags : folders or files
    scenario : shipped name or file, for bags that do not carry the scenario of their run
    transient : start of the evaluation window [s]; None takes what each bag says, or else the scenario
    has_baseline : each run is made again under the baseline law, unless that is kept beside its bag
    whatif : each run is reconstructed from its sensors, unless that is kept beside its bag; None: only what is kept

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
            if whatif is not False:
                laws = (BASELINE_LAW,) if has_baseline else ()
                warn(_add_reconstruction(record, bag, laws, scenario, transient, progress, computes=whatif is not None))
    return records


def _add_reconstruction(
    record: RunRecord,
    bag: Path,
    laws: Sequence[str],
    scenario: str | None,
    transient: float | None,
    progress: ProgressLine,
    *,
    computes: bool,
) -> list[str]:
    """Put what would have been, under the winch locked and `laws`, into a `record`; the others as for its callers."""
    from heave_studies.whatif.known import OFF  # noqa: PLC0415 - slow to import, and seldom asked for
    from heave_studies.whatif.of_run import add_reconstruction  # noqa: PLC0415
    from heave_studies.whatif.question import Question  # noqa: PLC0415

    question = Question(OFF, laws, scenario=scenario or "", transient=transient)
    return add_reconstruction(
        record,
        bag,
        question,
        computes=computes,
        show=lambda words, share: progress.show(f"{record.name}, what would have been: {words}", share),
    )
