"""The recorded fields of a topic as what they should be: numbers, tables of numbers, texts; or nothing.

A bag may come from another version of the messages, from another recorder, or from someone who means harm. What is not
of the requested kind is treated as if it had not been recorded.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.tick.clock_rule import ClockRule
from heave_node.tick.external_clock import ExternalClock
from numpy.typing import NDArray

from heave_bags.cdr.columns import Columns
from heave_bags.mcap.reader import LOG_TIME, TIME
from heave_bags.signals import Signal

RESET = 1.0
"""Time that goes back by more than this was reset [s]; by less, messages have overtaken each other."""


class Fields:
    """The columns of one topic, in the order of time; empty if it was not recorded.

    Parameters
    ----------
    columns : as read from the bag; None: none
    may_reset : time that goes back was reset; else a publisher of several was late

    Attributes
    ----------
    time : of each row, non-decreasing [s]
    resets : how often time went back; only what comes after the last is kept
    """

    def __init__(self, columns: Columns | None = None, *, may_reset: bool = True) -> None:
        self._columns = columns or {TIME: np.empty(0), LOG_TIME: np.empty(0, dtype=np.int64)}
        back = np.flatnonzero(np.diff(self.time) < -RESET)
        self.resets = int(back.size) if may_reset else 0
        if back.size and may_reset:
            self._keep(slice(back[-1] + 1, None))
        if np.any(np.diff(self.time) < 0.0):
            self._keep(np.argsort(self.time, kind="stable"))

    def _keep(self, rows: slice | NDArray[np.intp]) -> None:
        self._columns = {name: values[rows] for name, values in self._columns.items()}

    @property
    def time(self) -> Array:
        """Time of each row [s]."""
        return self._columns[TIME]

    @property
    def size(self) -> int:
        """Number of rows."""
        return int(self.time.size)

    def numbers(self, name: str) -> Array | None:
        """Return the column `name` of numbers; None if there is none."""
        values = self._columns.get(name)
        return values.astype(float) if values is not None and values.ndim == 1 and _is_numeric(values) else None

    def table(self, name: str) -> Array | None:
        """Return the column `name` of arrays of numbers, shape (rows, elements); None if there is none."""
        values = self._columns.get(name)
        return values.astype(float) if values is not None and values.ndim == 2 and _is_numeric(values) else None

    def texts(self, name: str) -> NDArray[Any] | None:
        """Return the column `name` of texts; None if there is none."""
        values = self._columns.get(name)
        return values if values is not None and values.ndim == 1 and values.dtype == object else None

    def codes(self, name: str) -> NDArray[np.int64]:
        """Return the column `name` of whole numbers, such as flags; zeros where there is none."""
        values = self.numbers(name)
        if values is None:
            return np.zeros(self.size, dtype=np.int64)
        return np.nan_to_num(np.clip(values, -(2.0**31), 2.0**31)).astype(np.int64)

    def signal(self, name: str) -> Signal:
        """Return the column `name` as a signal, without the samples that are not finite; empty if there is none."""
        values = self.numbers(name)
        if values is None:
            return Signal()
        good = np.isfinite(values)
        return Signal(self.time, values) if good.all() else Signal(self.time[good], values[good])

    def indices(self, name: str) -> Iterator[int]:
        """Yield the indices of the elements of an array of structures, which have the field `name`."""
        head, _, rest = name.partition("[]")
        index = 0
        while f"{head}[{index}]{rest}" in self._columns:
            yield index
            index += 1


def _is_numeric(values: NDArray[Any]) -> bool:
    return values.dtype.kind in "biuf"


def _read_own_clocks(topics: Sequence[Columns]) -> None:
    """Turn the stamps of a clock of its own into log time, if that is what the stamps of most topics are."""
    apart = [float(np.abs(columns[TIME] - columns[LOG_TIME] * 1e-9).min()) for columns in topics]
    if 2 * sum(difference < RESET for difference in apart) <= len(apart):
        return
    for columns, difference in zip(topics, apart, strict=True):
        if difference < RESET:
            continue
        clock = ExternalClock(ClockRule.OWN)
        pairs = zip(np.rint(columns[TIME] * 1e9).astype(np.int64).tolist(), columns[LOG_TIME].tolist(), strict=True)
        columns[TIME] = np.array([clock.simulated_time(stamp, log_time) for stamp, log_time in pairs]) * 1e-9


def on_one_clock(topics: Mapping[str, Columns]) -> None:
    """Give messages of `topics` without a stamp, in place, the time by the stamps of the others.

    They have their log time, which a recorder may take from another clock than the stamps are from. Where the log time
    is that of the stamps, but not on a topic of hardware with a clock of its own, its stamps are taken as in the run.
    """
    _read_own_clocks([columns for columns in topics.values() if columns[TIME].size])
    stamped = [
        (columns, columns[TIME] != columns[LOG_TIME] * 1e-9) for columns in topics.values() if columns[TIME].size
    ]
    reference, mask = max(stamped, key=lambda pair: int(pair[1].sum()), default=(None, None))
    if reference is None or mask is None or mask.sum() < 2:
        return
    log_time, time = reference[LOG_TIME][mask] * 1e-9, reference[TIME][mask]
    if np.abs(time - log_time).min() < RESET:
        return
    order = np.argsort(log_time, kind="stable")
    for columns, has_stamp in stamped:
        by_log = np.interp(columns[LOG_TIME] * 1e-9, log_time[order], time[order])
        columns[TIME] = np.where(has_stamp, columns[TIME], by_log)
