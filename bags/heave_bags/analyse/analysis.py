"""What a bag says in numbers: KPIs of the run and of windows in it, extremes with their times, as table, JSON,
CSV or Parquet.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from heave_node import kpi
from heave_node.files.given_files import whole_file

from heave_bags.analyse import kpi_set
from heave_bags.analyse.kpis.definition import QUANTITIES
from heave_bags.analyse.read_run import read_run
from heave_bags.analyse.reading.stored import NodeParameters
from heave_bags.analyse.run_record import RunRecord
from heave_bags.errors import BagError
from heave_bags.mcap.reader import Progress, no_progress
from heave_bags.signals import Signal

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True)
class Extreme:
    """The largest or smallest value of something, its `name`, and when it was: `time` [s], `value` in the SI `unit`."""

    name: str
    value: float
    unit: str
    time: float

    @property
    def shown(self) -> tuple[str, str]:
        """The size and its unit as people see them, the same as in the table of figures of merit."""
        unit, scale = QUANTITIES[self.unit]
        return f"{scale * abs(self.value):.2f}", unit


def analyse(
    paths: Sequence[str | Path],
    *,
    transient: float | None = None,
    parameters: NodeParameters | None = None,
    progress: Progress = no_progress,
) -> list[RunRecord]:
    """Read the bags of several runs, `paths`, one after another.

    `transient`, `parameters` and `progress` as for `read_run`. Raises BagError for the first that cannot be read.
    """
    records = []
    for number, path in enumerate(paths):
        part = _part(progress, number, len(paths))
        records.append(read_run(path, transient=transient, parameters=parameters, progress=part))
    names = [record.name for record in records]
    for record, path in zip(records, paths, strict=True):
        if names.count(record.name) > 1:
            record.name = str(path)
    return records


def _part(progress: Progress, number: int, total: int) -> Progress:
    return lambda share: progress((number + share) / total)


def extremes(record: RunRecord) -> list[Extreme]:
    """Return the extremes of the run `record` within its evaluation window."""
    signals = record.signals
    found: list[Extreme] = []

    def add(name: str, signal: Signal, unit: str, *, about_mean: bool = False, smallest: bool = False) -> None:
        part = signal.window(record.start, record.end)
        if not part.size:
            return
        values = part.value - part.value.mean() if about_mean else part.value
        index = (
            int(np.argmin(values)) if smallest else int(np.argmax(values if name.endswith("largest") else abs(values)))
        )
        found.append(Extreme(name, float(values[index]), unit, float(part.time[index])))

    add("load heave about its mean", signals.unit_heave, "m", about_mean=True)
    add("load heave about its mean, winch locked", signals.uncompensated_heave, "m", about_mean=True)
    add("boom-tip heave about its mean", signals.boom_tip_heave, "m", about_mean=True)
    add("top tension, smallest", signals.tension, "N", smallest=True)
    add("top tension, largest", signals.peak_tension(), "N")
    add("winch speed", signals.payout_rate, "m/s")
    add("winch acceleration", signals.payout_acceleration, "m/s²")
    if signals.tension.size and signals.payout_rate.size:
        rate = signals.payout_rate
        add("winch power", Signal(rate.time, signals.tension.at(rate) * rate.value), "W")
    return found


def snaps(record: RunRecord) -> list[float]:
    """Return the times [s] of snaps of the run `record` within its evaluation window."""
    tension = record.signals.tension.window(record.start, record.end)
    if not tension.size:
        return []
    static = record.signals.static_at(tension)
    peaks = record.signals.peak_tension().window(record.start, record.end).value
    return [float(time) for time in kpi.snap_times(tension.time, tension.value, static, peaks)]


MOST_WINDOWS = 100_000


@dataclass(frozen=True)
class WindowKpis:
    """KPIs of one window of a run, `start` to `end` [s]: `values` by key."""

    start: float
    end: float
    values: dict[str, float]


def windows(record: RunRecord, length: float, step: float | None = None) -> list[WindowKpis]:
    """Return the KPIs of windows of `length` [s] that begin every `step` [s] (default: one after another).

    They cover the whole run of `record`: from one sample before the first, which is where a run starts; an end that is
    shorter than a window is left out.

    Raises BagError if `length` or `step` is not positive, or for more windows than anyone would look at.
    """
    step = length if step is None else step
    if not (length > 0.0 and step > 0.0):
        raise BagError(f"windows need a positive length and step, got {length:g} s and {step:g} s")
    first = _start_of_run(record)
    count = math.floor((record.end - first - length) / step + 1e-9) + 1
    if count > MOST_WINDOWS:
        raise BagError(f"{record.name}: {count} windows of {length:g} s would be needed, {MOST_WINDOWS} are allowed")
    bounds = [(first + number * step, first + number * step + length) for number in range(max(count, 0))]
    return [WindowKpis(start, end, record.kpis(start, end)) for start, end in bounds]


def _start_of_run(record: RunRecord) -> float:
    """Return the time one sample before the first [s]: the first sample of a run is that of the end of tick 1."""
    time = record.signals.unit_heave.time
    if time.size < 2:
        return float(time[0]) if time.size else 0.0
    return round(float(time[0] - np.median(np.diff(time))), 9) + 0.0  # stamps are whole nanoseconds; never -0


def to_json(record: RunRecord, window: float | None = None) -> dict[str, Any]:
    """Return everything of the run `record` as plain data.

    KPIs by their keys, those of windows of `window` [s] if it is given, then `extremes`, `snap_times_s`, `run`,
    `outcome`, `losses`, `notes`.
    """
    content: dict[str, Any] = dict(kpi_set.to_json(record.kpis()))
    content["bag"] = record.name
    content["window_start_s"], content["window_end_s"] = record.start, record.end
    content["extremes"] = [
        {"name": extreme.name, "value": extreme.value, "unit": extreme.unit, "time_s": extreme.time}
        for extreme in extremes(record)
    ]
    content["snap_times_s"] = snaps(record)
    content["run"], content["outcome"] = dict(record.run), dict(record.outcome)
    content["sources"] = dict(record.sources)
    content["losses"] = [str(loss) for loss in record.losses]
    content["notes"] = list(record.notes)
    if window is not None:
        content["windows"] = [
            {"start_s": part.start, "end_s": part.end, **kpi_set.to_json(part.values)}
            for part in windows(record, window)
        ]
    return content


def table(records: Sequence[RunRecord]) -> str:
    """Return the KPIs of the runs `records` side by side as text, and below them what a reader of them must know."""
    sources = {record.name: record.sources for record in records}
    shown = kpi_set.table({record.name: as_seen(record) for record in records}, sources)
    return "\n".join([shown, *remarks(records)])


def remarks(records: Sequence[RunRecord]) -> list[str]:
    """Return what a reader of the figures of the runs `records` must know, each line with the name of its run."""
    return [f"{record.name}: {text}" for record in records for text in record.remarks()]


def as_seen(record: RunRecord) -> dict[str, float]:
    """Return the KPIs of the run `record` as people see them."""
    return kpi_set.as_seen(record.kpis(), record.run.get("pacing", ""))


def kpi_frame(records: Sequence[RunRecord], window: float | None = None) -> pandas.DataFrame:
    """Return the KPIs of the runs `records` as a DataFrame.

    One row per run, or per window of `window` [s] of each run, with columns bag, start_s, end_s and the KPI keys.
    """
    import pandas  # noqa: PLC0415 - half a second to import, for those who want frames only

    rows: list[dict[str, Any]] = []
    for record in records:
        parts = [WindowKpis(record.start, record.end, record.kpis())] if window is None else windows(record, window)
        rows += [{"bag": record.name, "start_s": part.start, "end_s": part.end, **part.values} for part in parts]
    return pandas.DataFrame(rows)


TABLE_ENDINGS = (".csv", ".parquet", ".xlsx")
MOST_ROWS_XLSX = 1_048_575
"""Rows of a sheet beside its heading."""


def save_frame(frame: pandas.DataFrame, path: Path, legend: pandas.DataFrame | None = None) -> None:
    """Write a frame as CSV, Parquet or a spreadsheet, by the ending of `path`.

    An index that has a name is the first column in each of them. A `legend` of its columns goes with it: a second sheet
    of a spreadsheet, else the file that `legend_file` names.

    A text that a spreadsheet would take for a formula gets an apostrophe before it. Raises BagError for another ending,
    without the package that writes it, for a sheet of too many rows, or if the file cannot be written.
    """
    ending = path.suffix.lower()
    if ending not in TABLE_ENDINGS:
        raise BagError(f"{path}: the table's name must end in {' or '.join(TABLE_ENDINGS)}")
    if ending == ".xlsx" and len(frame) > MOST_ROWS_XLSX:
        raise BagError(f"{path}: {len(frame)} rows do not fit a sheet of {MOST_ROWS_XLSX}: take .csv or .parquet")
    has_index = frame.index.name is not None
    try:
        with whole_file(path) as unfinished:
            if ending == ".parquet":
                (frame.reset_index() if has_index else frame).to_parquet(unfinished, index=False)
            elif ending == ".csv":
                _without_formulas(frame).to_csv(unfinished, index=has_index, float_format="%.9g")
            else:
                _save_sheet(_without_formulas(frame), unfinished, legend, has_index=has_index)
        if legend is not None and ending != ".xlsx":
            with whole_file(legend_file(path)) as unfinished:
                _without_formulas(legend).to_csv(unfinished, index=False)
    except ImportError as error:
        package = {".parquet": "pyarrow", ".xlsx": "xlsxwriter"}[ending]
        raise BagError(f"{path}: writing {ending} needs the package {package}: pip install {package}") from error
    except OSError as error:
        raise BagError(f"{path}: the table cannot be written: {error.strerror or error}") from error


def legend_file(path: Path) -> Path:
    """Return the file with the legend of the table `path`."""
    return path.with_name(f"{path.stem}_columns.csv")


def _save_sheet(frame: pandas.DataFrame, path: Path, legend: pandas.DataFrame | None, *, has_index: bool) -> None:
    import pandas  # noqa: PLC0415 - as above

    as_text = {"options": {"strings_to_formulas": False, "strings_to_urls": False}}
    with pandas.ExcelWriter(path, engine="xlsxwriter", engine_kwargs=as_text) as writer:
        frame.to_excel(writer, sheet_name="heave", index=has_index, freeze_panes=(1, int(has_index)))
        if legend is not None:
            _without_formulas(legend).to_excel(writer, sheet_name="columns", index=False, freeze_panes=(1, 0))
            writer.sheets["columns"].autofit()


def _without_formulas(frame: pandas.DataFrame) -> pandas.DataFrame:
    """Return a frame in which no text, heading included, begins as a formula of a spreadsheet does."""

    def plain(value: object) -> object:
        return f"'{value}" if isinstance(value, str) and value.startswith(("=", "+", "-", "@", "\t", "\r")) else value

    texts = {name: frame[name].map(plain) for name in frame.columns if frame[name].dtype.kind not in "fiubM"}
    return frame.assign(**texts).rename(columns=plain) if len(frame.columns) else frame
