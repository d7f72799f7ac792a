"""The seas of a place, a record or a scatter diagram, against limits: weather windows, waiting times.

The waiting time of a moment is the time from it to the next start of a window: that many hours of workable seas without
a break. It is counted from every moment of a record up to its last start of a window; moments after that would wait for
seas that nobody has measured. Statistics of a month are those of the moments in it. Missing seas are not workable.
"""

from __future__ import annotations

import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas
from heave_node.criteria import Criterion
from heave_node.files.given_files import TextFileError, read_text
from heave_node.files.plausible import PLAUSIBLE, question
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError
from numpy.typing import NDArray
from wave_vessel_node.sea.spectrum_files import read_spectra
from wave_vessel_node.sea.spectrum_record import SpectrumFileError

from heave_studies.operability.limits import limit_curve, situations
from heave_studies.study.phases import PHASE

PERCENTILES = (10, 50, 90)
ALL = "all"
"""Row of the whole record beside those of the months."""

Flags = NDArray[np.bool_]


def window_starts(workable: Flags, steps: int) -> Flags:
    """Return at which steps a window can start.

    Parameters
    ----------
    workable : by step, shape (n,)
    steps : of a window
    """
    starts = np.zeros(workable.size, dtype=bool)
    if 0 < steps <= workable.size:
        total = np.concatenate(([0], np.cumsum(workable)))
        starts[: workable.size - steps + 1] = total[steps:] - total[:-steps] == steps
    return starts


def waiting_times(workable: Flags, step: float, hours: float) -> Array:
    """Return the waiting time from each step to the next window [h], shape (n,); NaN after the last one.

    Parameters
    ----------
    workable : by step, shape (n,)
    step : [h]
    hours : of a window [h]
    """
    starts = np.flatnonzero(window_starts(workable, steps_of(hours, step)))
    waiting = np.full(workable.size, np.nan)
    if starts.size:
        moments = np.arange(starts[-1] + 1)
        waiting[: moments.size] = (starts[np.searchsorted(starts, moments)] - moments) * step
    return waiting


def steps_of(hours: float, step: float) -> int:
    """Return the steps of `step` [h] that a window of so many `hours` takes, a broken one as a whole."""
    return max(1, math.ceil(hours / step - 1e-9))


def waiting_by_month(time: pandas.DatetimeIndex, workable: Flags, step: float, hours: float) -> pandas.DataFrame:
    """Return the waiting time for a window by month, and over the whole record.

    Parameters
    ----------
    time : of the steps, shape (n,)
    workable : by step, shape (n,)
    step : [h]
    hours : of a window [h]

    Returns
    -------
    table : rows "1" to "12", those that the record has, and "all"; columns mean, p10, p50, p90 [h], and `at_once`, the
        share of moments at which a window starts
    """
    waiting = pandas.Series(waiting_times(workable, step, hours), index=time).dropna()
    months = waiting.groupby(pandas.DatetimeIndex(waiting.index).month)
    rows = {str(month): _statistics(part) for month, part in months} | {ALL: _statistics(waiting)}
    return pandas.DataFrame.from_dict(rows, orient="index")


def _statistics(waiting: pandas.Series) -> dict[str, float]:
    values = waiting.to_numpy()
    if not values.size:
        return {"mean": math.nan, **{f"p{p}": math.nan for p in PERCENTILES}, "at_once": 0.0}
    percentiles = {f"p{p}": float(np.percentile(values, p)) for p in PERCENTILES}
    return {"mean": float(values.mean()), **percentiles, "at_once": float(np.mean(values == 0.0))}


def monthly_share(time: pandas.DatetimeIndex, workable: Flags, known: Flags) -> pandas.Series:
    """Return the workable share of the measured seas by month, shape (12,) or fewer.

    Parameters
    ----------
    time : of the steps, shape (n,)
    workable, known : by step, shape (n,)
    """
    series = pandas.Series(workable[known], index=time[known])
    return series.groupby(series.index.month).mean()


def all_windows(time: pandas.DatetimeIndex, workable: Flags, windows: Sequence[float], step: float) -> pandas.DataFrame:
    """Return the waiting times by month for windows of several lengths, one below the other.

    Parameters
    ----------
    time : of the steps, shape (n,)
    workable : by step, shape (n,)
    windows : their lengths [h]
    step : [h]
    """
    parts = []
    for hours in windows:
        table = waiting_by_month(time, workable, step, hours)
        parts.append(table.assign(window_h=hours, month=table.index))
    columns = ["window_h", "month", "mean", *(f"p{p}" for p in PERCENTILES), "at_once"]
    return pandas.concat(parts, ignore_index=True)[columns]


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


def workable(record: SeaRecord, curve: pandas.DataFrame, *, alpha: float = 1.0) -> Flags:
    """Return which seas of a record are within the limit; missing ones are not.

    Parameters
    ----------
    record : of a place
    curve : as `limit_curve` gives it
    alpha : share of the limit up to which seas are taken [-]
    """
    states = record.states
    limits = alpha * limit_at(curve, states[TP].to_numpy())
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


@dataclass(frozen=True)
class Place:
    """The seas of a place, and what is asked of them."""

    record: SeaRecord  # of the place
    windows: tuple[float, ...]  # lengths of weather windows [h]
    alpha: float = 1.0  # share of a limit up to which a forecast may go [-]


@dataclass(frozen=True)
class Exposure:
    """A limit curve at a place."""

    share: float  # of the measured seas within the mean limit [-]
    cautious: float  # of those within the lower end of its confidence [-]; NaN where the seeds show none
    outside: float  # share of the seas whose period the study has not run [-]
    # workable share; empty of a scatter diagram, as are the following
    by_month: pandas.Series = field(default_factory=lambda: pandas.Series(dtype=float))
    # waiting times by length of window and month [h]
    windows: pandas.DataFrame = field(default_factory=pandas.DataFrame)


@dataclass(frozen=True)
class Situation:
    """What a study found for one heading, depth, ... : limits, and what they mean at a place."""

    name: str  # "" where only the sea was varied
    cases: pandas.DataFrame  # rows of the study's table
    limit: pandas.DataFrame  # by period, with the law of the scenario
    locked_limit: pandas.DataFrame  # by period, with the winch locked
    exposure: Exposure | None  # at the place; None without one
    locked_exposure: Exposure | None  # the same with the winch locked


def study_situations(
    frame: pandas.DataFrame, criteria: Mapping[str, Sequence[Criterion]], place: Place | None
) -> list[Situation]:
    """Return what a study found.

    Parameters
    ----------
    frame : table of the study
    criteria : that are to hold, by phase of a lift; "": there are none
    place : whose seas it is held against; None: none
    """
    found = []
    for name, cases in situations(frame):
        wanted = criteria[str(cases[PHASE].iloc[0]) if PHASE in cases else ""]
        limit = limit_curve(cases, wanted)
        locked = limit_curve(cases, wanted, locked=True)
        exposures = [None if place is None else exposure_of(place, curve) for curve in (limit, locked)]
        found.append(Situation(name, cases, limit, locked, *exposures))
    return found


def exposure_of(place: Place, curve: pandas.DataFrame) -> Exposure:
    """Return what a limit curve means at a place.

    Parameters
    ----------
    place : and what is asked of it
    curve : as `limit_curve` gives it
    """
    record = place.record
    cautious = math.nan if curve["lower"].isna().any() else workable_share(record, curve, "lower")
    shares = (workable_share(record, curve), cautious, beyond_the_grid(record, curve))
    if not record.has_order:
        return Exposure(*shares)
    time = pandas.DatetimeIndex(record.states.index)
    flags = workable(record, curve)
    known = np.asarray(record.states[HS].notna())
    return Exposure(
        *shares,
        by_month=monthly_share(time, flags, known),
        windows=all_windows(time, workable(record, curve, alpha=place.alpha), place.windows, record.step),
    )


def exposure_json(exposure: Exposure | None) -> dict[str, object] | None:
    """Return an `exposure` as plain data; None where there is none."""
    if exposure is None:
        return None
    return {
        "workable_share": exposure.share,
        "workable_share_lower": exposure.cautious,
        "beyond_the_grid": exposure.outside,
        "by_month": {str(month): float(share) for month, share in exposure.by_month.items()},
        "windows": exposure.windows.to_dict("records"),
    }
