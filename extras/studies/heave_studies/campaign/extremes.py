"""Extremes by the seeds of a campaign: cases that differ in their seed only are records of one sea."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError

from heave_studies.campaign.plan import Case
from heave_studies.campaign.table import FAILURE, NOMINAL, SEED, settings_of
from heave_studies.extremes.of_run import Expected, expected_of_seeds
from heave_studies.tables.case_table import CASE, load_case, read_cases

FEWEST_SEEDS = 3
"""Fewest seeds of a sea from which its extremes are estimated."""
FIGURES = ("max_abs_heave_m", "uncompensated_max_abs_heave_m", "tension_mean_n", "tension_max_n", "tension_min_n")
"""Figures of merit that they are estimated from."""


def extremes_of_table(path: Path, duration: float) -> list[tuple[str, list[Expected]]]:
    """Return what the seeds of each sea in a table of cases let one expect.

    Parameters
    ----------
    path : of the table
    duration : of the time that is asked for [s]

    Raises ParameterError for another file, and where no sea has FEWEST_SEEDS seeds.
    """
    frame, _ = read_cases(path)
    _check(path, frame)
    good = frame[frame[FAILURE] == ""]
    settings = settings_of(frame)
    groups = (
        [good] if not settings else [part for _, part in good.groupby([good[name].astype(str) for name in settings])]
    )
    groups = [part for part in groups if part[SEED].nunique() >= FEWEST_SEEDS]
    if not groups:
        raise ParameterError(
            f"{path}: no sea has {FEWEST_SEEDS} seeds, and 20 make a fit: run the campaign with more "
            "seeds, or name the bag of a long run"
        )
    return [(_label(part, settings), _of_group(path, part, duration)) for part in groups]


def _check(path: Path, frame: pandas.DataFrame) -> None:
    """Raise ParameterError where a table lacks a column that is needed, or has it in another form."""
    for name in (SEED, NOMINAL, FAILURE, *FIGURES):
        if name not in frame.columns:
            raise ParameterError(f"{path}: is not a table of heave campaign: it has no column {name}")
        if name in (SEED, *FIGURES) and not pandas.api.types.is_numeric_dtype(frame[name]):
            raise ParameterError(f"{path}: is not a table of heave campaign: its {name} is no number")


def _label(part: pandas.DataFrame, settings: list[str]) -> str:
    values = {name: part[name].iloc[0] for name in settings}
    words = Case(0, 0, values, is_nominal=bool(part[NOMINAL].iloc[0])).label.removeprefix("seed=0").strip()
    return f"{words or 'all cases'}: {len(part)} seeds"


def _of_group(path: Path, part: pandas.DataFrame, duration: float) -> list[Expected]:
    run = load_case(path, int(part[CASE].iloc[0])).run

    def column(name: str) -> Array:
        return np.asarray(part[name], dtype=float)

    still, tension = np.zeros(len(part)), column("tension_mean_n")
    maxima = {
        "load heave about its mean": ("m", still, column("max_abs_heave_m"), 1.0),
        "uncompensated heave about its mean": ("m", still, column("uncompensated_max_abs_heave_m"), 1.0),
        "top tension, largest": ("N", tension, column("tension_max_n") - tension, 1.0),
        "top tension, smallest": ("N", tension, tension - column("tension_min_n"), -1.0),
    }
    known = {name: found for name, found in maxima.items() if np.all(np.isfinite(found[2]))}
    return expected_of_seeds(known, run.duration - run.transient, duration)
