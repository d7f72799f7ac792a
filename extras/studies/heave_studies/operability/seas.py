"""The seas to come, from a file, and the seas of a study, against limits."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas
from heave_node.criteria import Criterion
from heave_node.files.given_files import TextFileError, read_text
from heave_node.files.plausible import PLAUSIBLE, question
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError
from numpy.typing import NDArray

from heave_studies.operability.limits import limit_curve, situations
from heave_studies.study.phases import PHASE

Flags = NDArray[np.bool_]


HS, TP = "hs", "tp"
"""Columns: significant wave height [m], peak period [s]."""

_QUANTITIES = {HS: "significant wave height", TP: "peak period"}
_MOST_IMPLAUSIBLE = 0.2
"""Share of a record that may hold fill values; more are another unit."""

MOST_STEPS = 2_000_000
"""Largest number of steps of a record: two centuries of hours."""


@dataclass(frozen=True)
class SeaRecord:
    """The seas of a place and a time, or those of a study."""

    name: str  # of the file
    # columns hs [m] and tp [s]; of a file with the time (UTC) as index, at equal steps, NaN where nothing was known; of
    # a study with a share (of the time)
    states: pandas.DataFrame
    step: float  # between two states [h]; NaN of a study, whose seas have no order
    warnings: tuple[str, ...] = ()  # what was repaired or left out


def read_record(path: Path) -> SeaRecord:
    """Read the seas in the CSV file at `path`, with the columns time, hs, tp.

    Single implausible states, such as fill values, count as missing, and are said. Raises ParameterError for another
    file, and where many states are implausible.
    """
    try:
        text = read_text(path)
        table = pandas.read_csv(io.StringIO("\n".join(text.lines)), comment="#", skipinitialspace=True)
    except TextFileError as error:
        raise ParameterError(str(error)) from error
    except ValueError as error:
        raise ParameterError(f"{path}: is not CSV: {' '.join(str(error).split())}") from error
    table.columns = [str(name).strip().lower() for name in table.columns]
    if not {"time", HS, TP} <= set(table.columns):
        raise ParameterError(f"{path}: must have the columns time, hs, tp, not {', '.join(table.columns)}")
    try:
        states = table.set_index(_times(path, table["time"]))[[HS, TP]].astype(float)
    except (ValueError, TypeError) as error:
        raise ParameterError(f"{path}: {' '.join(str(error).split())}") from error
    states, warnings = _plausible(path, states)
    return at_equal_steps(path.name, states.sort_index(), warnings)


def _plausible(path: Path, states: pandas.DataFrame) -> tuple[pandas.DataFrame, tuple[str, ...]]:
    """Return states without the implausible ones, and what is said of them."""
    implausible = pandas.Series(False, index=states.index)
    first = ""
    for name, quantity in _QUANTITIES.items():
        known = PLAUSIBLE[quantity]
        wrong = states[name].notna() & ~states[name].between(known.least, known.most)
        if wrong.any() and not first:
            first = question(quantity, float(states[name][wrong].iloc[0]), str(states.index[wrong][0]))
        implausible |= wrong
    if implausible.mean() > _MOST_IMPLAUSIBLE:
        raise ParameterError(f"{path}: {int(implausible.sum())} of {len(states)} states are implausible: {first}")
    if not implausible.any():
        return states, ()
    warning = f"{path.name}: {int(implausible.sum())} implausible states count as not measured, the first {first}"
    return states.where(~implausible), (warning,)


def _times(path: Path, column: pandas.Series) -> pandas.Series:
    """Return a column of times, UTC where they have no zone; raise ParameterError where one could be read two ways."""
    times = pandas.to_datetime(column.astype(str).str.strip(), utc=True, format="ISO8601", errors="coerce")
    if times.isna().any():
        wrong = column[times.isna()].iloc[0]
        raise ParameterError(f"{path}: time {wrong!r} is not a time as in 2025-03-01T12:00:00Z (ISO 8601)")
    return times


def at_equal_steps(name: str, states: pandas.DataFrame, warnings: tuple[str, ...]) -> SeaRecord:
    """Return a record at equal steps, those most frequent in it; what is missing in between is NaN.

    Parameters
    ----------
    name : of the record
    states : columns hs and tp by time, rising
    warnings : so far

    Raises ParameterError for fewer than two states.
    """
    states = states[~states.index.duplicated()].dropna()
    if len(states) < 2:
        raise ParameterError(f"{name}: holds {len(states)} sea states with a height and a period: too few for a record")
    step = pandas.Series(states.index).diff().dropna().mode().min()
    if (states.index[-1] - states.index[0]) / step > MOST_STEPS:
        raise ParameterError(f"{name}: {len(states)} sea states over {states.index[-1] - states.index[0]}: too sparse")
    grid = pandas.date_range(states.index[0], states.index[-1], freq=step)
    even = states.reindex(grid, method="nearest", tolerance=step / 2)
    return SeaRecord(name, even, step.total_seconds() / 3600.0, warnings)


def limit_at(curve: pandas.DataFrame, periods: Array, column: str = "limit") -> Array:
    """Return the limit at peak periods, linear between those of the curve and held beyond them.

    Parameters
    ----------
    curve : as `limit_curve` gives it
    periods : any shape [s]
    column : of the curve: limit, lower or upper
    """
    return np.asarray(np.interp(periods, curve["period"], curve[column].fillna(curve["limit"])))


def workable(record: SeaRecord, curve: pandas.DataFrame, column: str = "limit") -> Flags:
    """Return which seas of a record are within the limit.

    Parameters
    ----------
    record : of a place
    curve : as `limit_curve` gives it
    column : of the curve: limit, lower or upper
    """
    return np.asarray(record.states[HS] <= limit_at(curve, record.states[TP].to_numpy(), column))


def workable_share(record: SeaRecord, curve: pandas.DataFrame, column: str = "limit") -> float:
    """Return the share of the measured seas that are within the limit.

    Parameters
    ----------
    record : of a place
    curve : as `limit_curve` gives it
    column : of the curve: limit, lower or upper
    """
    return float(record.states["share"].to_numpy() @ workable(record, curve, column))


@dataclass(frozen=True)
class Situation:
    """What a study found for one heading, depth, ... : limits."""

    name: str  # "" where only the sea was varied
    limit: pandas.DataFrame  # by period, with the law of the scenario
    locked_limit: pandas.DataFrame  # by period, with the winch locked


def study_situations(frame: pandas.DataFrame, criteria: Mapping[str, Sequence[Criterion]]) -> list[Situation]:
    """Return what a study found.

    Parameters
    ----------
    frame : table of the study
    criteria : that are to hold, by phase of a lift; "": there are none
    """
    found = []
    for name, cases in situations(frame):
        wanted = criteria[str(cases[PHASE].iloc[0]) if PHASE in cases else ""]
        found.append(Situation(name, limit_curve(cases, wanted), limit_curve(cases, wanted, locked=True)))
    return found
