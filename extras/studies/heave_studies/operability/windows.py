"""Persistence and weather windows: how long seas stay workable, and how long one waits for a window.

The waiting time of a moment is the time from it to the next start of a window: that many hours of workable seas without
a break. It is counted from every moment of a record up to its last start of a window; moments after that would wait for
seas that nobody has measured. Statistics of a month are those of the moments in it. Missing seas are not workable.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError
from numpy.typing import NDArray

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


def spells(flags: Flags, step: float) -> Array:
    """Return how long each unbroken spell of true `flags` lasts [h], one flag for each `step` [h]."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], flags.astype(int), [0]))))
    return np.asarray((edges[1::2] - edges[::2]) * step, dtype=float)


def persistence(workable: Flags, step: float) -> pandas.DataFrame:
    """Return how long workable seas and the others last.

    Parameters
    ----------
    workable : by step, shape (n,)
    step : [h]

    Returns
    -------
    table : rows workable and waiting; columns spells (their number), mean, p10, p50, p90, longest [h]
    """
    rows = {}
    for name, flags in (("workable", workable), ("waiting", ~workable)):
        found = spells(flags, step)
        known = found if found.size else np.array([np.nan])
        percentiles = {f"p{p}": float(np.percentile(known, p)) for p in PERCENTILES}
        rows[name] = {
            "spells": float(found.size),
            "mean": float(known.mean()),
            **percentiles,
            "longest": float(known.max()),
        }
    return pandas.DataFrame.from_dict(rows, orient="index")


def monthly_share(time: pandas.DatetimeIndex, workable: Flags, known: Flags) -> pandas.Series:
    """Return the workable share of the measured seas by month, shape (12,) or fewer.

    Parameters
    ----------
    time : of the steps, shape (n,)
    workable, known : by step, shape (n,)
    """
    series = pandas.Series(workable[known], index=time[known])
    return series.groupby(series.index.month).mean()


def all_windows(
    time: pandas.DatetimeIndex, workable_for: Sequence[tuple[float, Flags]], step: float
) -> pandas.DataFrame:
    """Return the waiting times by month for windows of several lengths, one below the other.

    Parameters
    ----------
    time : of the steps, shape (n,)
    workable_for : hours of each window, and by step whether its seas are workable, shape (n,)
    step : [h]
    """
    parts = []
    for hours, workable in workable_for:
        table = waiting_by_month(time, workable, step, hours)
        parts.append(table.assign(window_h=hours, month=table.index))
    columns = ["window_h", "month", "mean", *(f"p{p}" for p in PERCENTILES), "at_once"]
    return pandas.concat(parts, ignore_index=True)[columns]


@dataclass(frozen=True)
class AlphaTable:
    """Factors by planned duration and design wave height."""

    hours: Array  # planned durations, rising, shape (n,) [h]
    heights: Array  # design significant wave heights, rising, shape (m,) [m]
    factors: Array  # above 0, at most 1, shape (n, m)

    def factor(self, hours: float, heights: Array) -> Array:
        """Return the factor.

        Parameters
        ----------
        hours : planned duration [h]
        heights : design wave heights, any shape [m]
        """
        of_duration = np.array([np.interp(hours, self.hours, column) for column in self.factors.T])
        return np.asarray(np.interp(heights, self.heights, of_duration))


def read_alpha(path: Path) -> AlphaTable:
    """Read the table at `path`; raise ParameterError, in one line, for what is wrong with it."""
    try:
        table = pandas.read_csv(path, comment="#", skipinitialspace=True)
        heights = np.array([float(name) for name in table.columns[1:]])
        values = table.to_numpy(dtype=float)
    except OSError as error:
        raise ParameterError(f"{path}: cannot be read: {error.strerror}") from error
    except (ValueError, UnicodeDecodeError) as error:
        raise ParameterError(f"{path}: is not a table of hours by wave heights: {error}") from error
    hours, factors = values[:, 0], values[:, 1:]
    if not factors.size or (np.diff(hours) <= 0.0).any() or (np.diff(heights) <= 0.0).any():
        raise ParameterError(f"{path}: hours and wave heights must rise")
    if not ((factors > 0.0) & (factors <= 1.0)).all():
        raise ParameterError(f"{path}: alpha factors must be above 0 and at most 1")
    return AlphaTable(hours, heights, factors)
