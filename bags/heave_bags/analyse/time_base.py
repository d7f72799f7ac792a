"""The signals of a run, or the fields of topics, as one table on one time base, for programs of others.

A number is linear between its samples; a flag, a count, a code or a text keeps its last value. Where a signal has no
sample for LONGEST_GAP of its own periods, before its first and after its last, the table has no value.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray

from heave_bags.analyse.events import Interval
from heave_bags.analyse.read_run import ROOM, ROOM_PER_BYTE
from heave_bags.analyse.run_record import RunRecord
from heave_bags.errors import BagError
from heave_bags.mcap.read.decode import LOG_TIME, TIME
from heave_bags.mcap.reader import LONGEST_ARRAY, Bag, Progress, no_progress

if TYPE_CHECKING:
    import pandas

LONGEST_GAP = 5.0
"""Periods of a signal without a sample after which its value is not known."""
MOST_CELLS = 50_000_000
"""Cells of a table: what a bag brings has a bound."""
SHORTEST_PERIOD = 1e-4
"""Shortest period of a time base [s]."""

Samples = tuple[Array, NDArray[Any]]
"""Times [s] and values of one column, both of shape (n,)."""

EDGE = 1.0
"""Signals that begin within this time of the first one, and end within it of the last one, set the span of the table:
it begins where all of them have begun, and ends where the first of them ends [s]."""

ABOUT_MEAN = "; about its mean over the run, positive up"


class Column(NamedTuple):
    """What a column of a table is."""

    unit: str  # of its values; empty for counts, flags and words
    meaning: str  # what it is, with its sign and where it comes from
    signal: str = ""  # of the run that it is (`heave_bags.signals.RunSignals`); empty: none of them


TIME_S = Column("s", "time of the row; simulated time, or that of the recorded stamps")

COLUMNS = {
    "boom_tip_heave_m": Column("m", f"vertical motion of the boom tip{ABOUT_MEAN}", "boom_tip_heave"),
    "unit_heave_m": Column("m", f"vertical motion of the unit{ABOUT_MEAN}", "unit_heave"),
    "uncompensated_unit_heave_m": Column(
        "m", f"vertical motion of the unit in the same sea with the winch locked{ABOUT_MEAN}", "uncompensated_heave"
    ),
    "unit_height_m": Column("m", "height of the unit above still water, positive up: minus its depth", "unit_height"),
    "payout_m": Column("m", "unstretched cable paid out beyond the datum length, positive pays out", "payout"),
    "payout_rate_mps": Column("m/s", "rate of payout, positive pays out", "payout_rate"),
    "payout_acceleration_mps2": Column(
        "m/s^2", "acceleration of payout, positive pays out faster", "payout_acceleration"
    ),
    "top_tension_n": Column(
        "N", "tension of the cable at the boom tip; of a load cell where the truth is not known", "tension"
    ),
    "unit_tension_n": Column(
        "N",
        "tension at mid-length of the lowest segment of the cable; at the unit it is less by half the segment's weight "
        "in water",
        "unit_tension",
    ),
}
"""Columns of a run's table. The truth of a simulation; what a ship measures or estimates where there is none."""

MODE = Column("", "mode of the controller")


def run_samples(record: RunRecord) -> dict[str, Samples]:
    """Return the signals of the run `record` by column name, SI units in the names, and the controller's mode."""
    found: dict[str, Samples] = {}
    for name, column in COLUMNS.items():
        signal = getattr(record.signals, column.signal)
        if signal.size:
            is_heave = name.endswith("_heave_m")
            found[name] = signal.time, signal.value - signal.value.mean() if is_heave else signal.value
    if record.modes:
        found["mode"] = _steps(record.modes)
    return found


def topic_columns(bag: Bag, names: Iterable[str]) -> dict[str, Column]:
    """Return what each column `topic.field` of `names` is, by the comments of the definitions in a `bag`.

    A comment ends with its unit in brackets: "float64 payout  # cable let out [m]".
    """
    found: dict[str, Column] = {}
    for name in names:
        topic, _, field = name.partition(".")
        found[name] = field_column(bag.topics[bag.resolve(topic)].schema, field)
    return found


def field_column(schema: str, field: str) -> Column:
    """Return what a `field` of a message is, by its comment in the `ros2msg` definition `schema` of its type."""
    first = re.split(r"[.\[]", field, maxsplit=1)[0]
    text = schema.partition("\n===")[0]
    line = re.search(rf"^\s*[\w/\[\]<=]+\s+{re.escape(first)}\s*#\s*(.*)$", text, re.MULTILINE)
    meaning = line[1].strip() if line else ""
    units = re.findall(r"\[([^\]]+)\]", meaning)
    return Column(units[0] if len(units) == 1 else "", meaning)


def legend(columns: Mapping[str, Column]) -> pandas.DataFrame:
    """Return what each of `columns` is as a table: column, unit, meaning."""
    import pandas  # noqa: PLC0415 - as below

    rows = {"time_s": TIME_S, **columns}
    return pandas.DataFrame(
        [(name, one.unit, one.meaning) for name, one in rows.items()], columns=["column", "unit", "meaning"]
    )


def _steps(modes: Sequence[Interval]) -> Samples:
    times = [time for mode in modes for time in (mode.start, mode.end)]
    return np.asarray(times), np.asarray([mode.name for mode in modes for _ in range(2)], dtype=object)


def topic_samples(bag: Bag, topics: Sequence[str], progress: Progress = no_progress) -> dict[str, Samples]:
    """Return every number and short text of `topics`, full names or their ends, of a `bag` by `topic.field`; `progress`
    is given the share that is read.

    Raises BagError for a topic that is not there, and for more bytes than an analysis takes.
    """
    names = list(dict.fromkeys(bag.resolve(topic) for topic in topics))
    room = max(ROOM, ROOM_PER_BYTE * bag.size)
    columns = bag.columns(dict.fromkeys(names), longest=LONGEST_ARRAY, most_bytes=room, progress=progress)
    found: dict[str, Samples] = {}
    for topic in names:
        own = columns[topic]
        time = np.asarray(own[TIME], dtype=float)
        for field, values in own.items():
            if field not in (TIME, LOG_TIME):
                flat = {field: values} if values.ndim == 1 else _elements(field, values)
                found |= {f"{topic.lstrip('/')}.{name}": (time, part) for name, part in flat.items()}
    return found


def _elements(field: str, values: NDArray[Any]) -> dict[str, NDArray[Any]]:
    return {f"{field}[{index}]": values[:, index] for index in range(min(values.shape[1], LONGEST_ARRAY))}


def on_one_time_base(samples: Mapping[str, Samples], period: float | None = None) -> pandas.DataFrame:
    """Return `samples` as a table with the index `time_s`, every `period` [s] over the time of the samples (EDGE).

    None takes the shortest period that any column has. Raises BagError where there is nothing, or where the table would
    have more than MOST_CELLS.
    """
    import pandas  # noqa: PLC0415 - half a second to import, for those who want frames only

    sound = {name: _in_order(*one) for name, one in samples.items()}
    sound = {name: one for name, one in sound.items() if one[0].size}
    if not sound:
        raise BagError("nothing to export: no sample with a time")
    step = period or max(min(map(_period, (time for time, _ in sound.values()))), SHORTEST_PERIOD)
    if not math.isfinite(step):
        step = 1.0  # single samples
    first, last = _span([time for time, _ in sound.values()])
    rows = (last - first) / step + 1.0
    if rows * len(sound) > MOST_CELLS:
        raise BagError(
            f"a table of {rows:.3g} rows, every {step:.4g} s from {first:.6g} s to {last:.6g} s, and {len(sound)} "
            "columns is too large: give a longer --period, or --topics of one clock"
        )
    grid: Array = np.asarray(first + step * np.arange(math.floor(rows + 1e-6)), dtype=np.float64)
    table = {name: _at(grid, *one, step) for name, one in sound.items()}
    return pandas.DataFrame(table, index=pandas.Index(grid.round(9), name="time_s"))


def _span(times: Sequence[Array]) -> tuple[float, float]:
    """Return first and last time of a table of columns with these `times` [s]."""
    begins, ends = [float(time[0]) for time in times], [float(time[-1]) for time in times]
    first = max(begin for begin in begins if begin <= min(begins) + EDGE)
    last = min(end for end in ends if end >= max(ends) - EDGE)
    return (first, last) if first <= last else (min(begins), max(ends))


def _in_order(time: Array, values: NDArray[Any]) -> Samples:
    """Return samples in the order of their times, those without a time left out; of equal times the last."""
    finite = np.isfinite(time)
    time, values = time[finite], values[finite]
    order = np.argsort(time, kind="stable")
    time, values = time[order], values[order]
    last = np.append(np.diff(time) > 0.0, True)[: time.size]
    return time[last], values[last]


def _period(time: Array) -> float:
    return float(np.median(np.diff(time))) if time.size > 1 else math.inf


def _at(grid: Array, time: Array, values: NDArray[Any], step: float) -> NDArray[Any]:
    """Return samples at the times of the `grid`, `step` [s] apart; missing where nothing is known."""
    slack = 1e-6 * step
    before = np.searchsorted(time, grid + slack, side="right") - 1
    is_number = values.dtype.kind == "f"
    gap = np.inf if time.size == 1 else LONGEST_GAP * max(_period(time), step)
    after = np.minimum(before + 1, time.size - 1)
    is_text = values.dtype.kind not in "fiub"
    spread = time[after] - time[np.maximum(before, 0)]
    is_sample = np.abs(grid - time[np.maximum(before, 0)]) <= slack
    known = (before >= 0) & ((spread <= gap) | is_text | is_sample)
    known &= (grid <= time[-1] + slack) | (time.size == 1)
    if is_number and time.size > 1:
        return np.where(known, np.interp(grid, time, values), np.nan)
    held = values[np.maximum(before, 0)]
    if is_text:
        return np.where(known, held.astype(object), "")
    return held if known.all() else np.where(known, held.astype(float), np.nan)
