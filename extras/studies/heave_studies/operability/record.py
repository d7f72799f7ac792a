"""The seas of a place: a measured record, or a scatter diagram."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas
from heave_node.files.given_files import TextFileError, read_text
from heave_node.files.plausible import PLAUSIBLE, question
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError
from wave_vessel_node.sea.spectrum_files import read_spectra
from wave_vessel_node.sea.spectrum_record import SpectrumFileError

from heave_studies.operability.windows import AlphaTable, Flags

HS, TP = "hs", "tp"
"""Columns: significant wave height [m], peak period [s]."""

_QUANTITIES = {HS: "significant wave height", TP: "peak period"}
_MOST_IMPLAUSIBLE = 0.2
"""Share of a record that may hold fill values; more are another unit."""

MOST_STEPS = 2_000_000
"""Largest number of steps of a record: two centuries of hours."""


@dataclass(frozen=True)
class SeaRecord:
    """The seas of a place."""

    name: str  # of the file
    # columns hs [m], tp [s] and share (of the time); of a record with the time (UTC) as index, at equal steps, NaN
    # where nothing was measured
    states: pandas.DataFrame
    step: float  # between two states [h]; NaN of a scatter diagram, which knows no order
    warnings: tuple[str, ...] = ()  # what was repaired or left out

    @property
    def has_order(self) -> bool:
        """Whether it is a record, in which one can wait for a window."""
        return bool(np.isfinite(self.step))

    @property
    def missing(self) -> float:
        """Share of a record's time in which nothing was measured."""
        return float(self.states[HS].isna().mean())


def read_record(path: Path) -> SeaRecord:
    """Read the seas in the file at `path`.

    A .csv is a record with the columns time, hs, tp, or a scatter diagram: `hs` and peak periods in its first line, a
    height and the numbers of its seas in each further one. Any other file holds spectra (NDBC, or what `wavespectra`
    reads), whose heights and periods are taken. Single implausible states, such as fill values, count as not
    measured, and are said.

    Raises ParameterError for what is none of these, and where many states are implausible.
    """
    if not path.is_file():
        raise ParameterError(f"{path}: no such file")
    if path.suffix.lower() == ".csv":
        return _read_csv(path)
    try:
        file = read_spectra(path)
    except SpectrumFileError as error:
        raise ParameterError(str(error)) from error
    states = pandas.DataFrame(
        {
            HS: [record.spectrum.significant_wave_height for record in file.records],
            TP: [record.spectrum.peak_period for record in file.records],
        },
        index=pandas.DatetimeIndex([record.time for record in file.records]),
    )
    return at_equal_steps(path.name, states, file.warnings)


def _read_csv(path: Path) -> SeaRecord:
    try:
        text = read_text(path)
        table = pandas.read_csv(io.StringIO("\n".join(text.lines)), comment="#", skipinitialspace=True)
    except TextFileError as error:
        raise ParameterError(str(error)) from error
    except ValueError as error:
        raise ParameterError(f"{path}: is not CSV: {' '.join(str(error).split())}") from error
    table.columns = [str(name).strip().lower() for name in table.columns]
    if {"time", HS, TP} <= set(table.columns):
        try:
            states = table.set_index(_times(path, table["time"]))[[HS, TP]].astype(float)
        except (ValueError, TypeError) as error:
            raise ParameterError(f"{path}: {' '.join(str(error).split())}") from error
        states, warnings = _plausible(path, states)
        return at_equal_steps(path.name, states.sort_index(), warnings)
    return _scatter(path, table)


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


def _scatter(path: Path, table: pandas.DataFrame) -> SeaRecord:
    try:
        if table.columns[0] != HS:
            raise ValueError(f"the first column is {table.columns[0]}")
        periods = [float(name) for name in table.columns[1:]]
        cells = table.astype(float)
    except (ValueError, IndexError) as error:
        raise ParameterError(
            f"{path}: must have the columns time, hs, tp, or hs and peak periods (scatter diagram): {error}"
        ) from error
    counts = np.nan_to_num(cells.iloc[:, 1:].to_numpy())
    if (counts < 0.0).any() or counts.sum() <= 0.0:
        raise ParameterError(f"{path}: a scatter diagram must hold numbers of seas, none below 0 and not all 0")
    heights = cells[HS].to_numpy()
    states = pandas.DataFrame(
        {
            HS: np.repeat(heights, len(periods)),
            TP: np.tile(periods, len(heights)),
            "share": (counts / counts.sum()).ravel(),
        }
    )
    states = states[states["share"] > 0.0].reset_index(drop=True)
    for name, quantity in _QUANTITIES.items():
        for value in states[name]:
            if objection := question(quantity, float(value), str(path)):
                raise ParameterError(objection)
    return SeaRecord(path.name, states, float("nan"))


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
    even["share"] = np.where(even[HS].isna(), 0.0, 1.0) / max(int(even[HS].notna().sum()), 1)
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


def workable(
    record: SeaRecord, curve: pandas.DataFrame, *, alpha: AlphaTable | None = None, hours: float = 0.0
) -> Flags:
    """Return which seas of a record are within the limit; missing ones are not.

    Parameters
    ----------
    record : of a place
    curve : as `limit_curve` gives it
    alpha : factors on the limit, by the planned duration; None: the forecast is trusted
    hours : planned duration [h]
    """
    states = record.states
    limits = limit_at(curve, states[TP].to_numpy())
    if alpha is not None:
        limits = limits * alpha.factor(hours, limits)
    with np.errstate(invalid="ignore"):
        return np.asarray(states[HS].to_numpy() <= limits)


def workable_share(record: SeaRecord, curve: pandas.DataFrame, column: str = "limit") -> float:
    """Return the share of the measured seas that are within the limit.

    Parameters
    ----------
    record : of a place
    curve : as `limit_curve` gives it
    column : of the curve: limit, lower or upper
    """
    states = record.states.dropna(subset=[HS])
    within = states[HS].to_numpy() <= limit_at(curve, states[TP].to_numpy(), column)
    return float(states["share"].to_numpy() @ within)


def beyond_the_grid(record: SeaRecord, curve: pandas.DataFrame) -> float:
    """Return the share of the measured seas whose period lies outside the curve's, where its end is held.

    Parameters
    ----------
    record : of a place
    curve : as `limit_curve` gives it
    """
    states = record.states.dropna(subset=[HS])
    outside = (states[TP] < curve["period"].min()) | (states[TP] > curve["period"].max())
    return float(states["share"].to_numpy() @ outside.to_numpy())
