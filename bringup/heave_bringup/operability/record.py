"""The seas of a place: a measured record, or a scatter diagram."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas
from heave_node.parameters import ParameterError
from wave_vessel_node.sea.spectrum_files import read_spectra
from wave_vessel_node.sea.spectrum_record import SpectrumFileError

HS, TP = "hs", "tp"
"""Columns: significant wave height [m], peak period [s]."""

MOST_STEPS = 2_000_000
"""Of a record: two centuries of hours."""


@dataclass(frozen=True)
class SeaRecord:
    """The seas of a place.

    Attributes
    ----------
    name : of the file
    states : columns hs [m], tp [s] and share (of the time); of a record with the time (UTC) as index, at equal steps,
        NaN where nothing was measured
    step : between two states [h]; NaN of a scatter diagram, which knows no order
    warnings : what was repaired or left out
    """

    name: str
    states: pandas.DataFrame
    step: float
    warnings: tuple[str, ...] = ()

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
    reads), whose heights and periods are taken.

    Raises ParameterError for what is none of these.
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
        table = pandas.read_csv(path, comment="#", skipinitialspace=True)
    except (ValueError, UnicodeDecodeError) as error:
        raise ParameterError(f"{path}: is not CSV: {' '.join(str(error).split())}") from error
    table.columns = [str(name).strip().lower() for name in table.columns]
    if {"time", HS, TP} <= set(table.columns):
        try:
            states = table.set_index(_times(path, table["time"]))[[HS, TP]].astype(float)
        except (ValueError, TypeError) as error:
            raise ParameterError(f"{path}: {' '.join(str(error).split())}") from error
        return at_equal_steps(path.name, states.sort_index(), ())
    return _scatter(path, table)


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
    return SeaRecord(path.name, states[states["share"] > 0.0].reset_index(drop=True), float("nan"))


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
