"""Logs of ships as text: columns by name, times of all forms, samples that the log itself calls invalid."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from heave_bags.errors import BagError
from heave_node.files.columns import ColumnsError, read_columns
from heave_node.files.given_files import TextFileError, read_text
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray

from heave_devices.maps.channel import GOOD_WORDS, Channel
from heave_devices.records.ship_time import (
    TimeError,
    counted_on,
    gps_time,
    is_gps,
    spread,
    time_of_numbers,
    time_of_texts,
)

TIME_NAMES = (
    *("time_s", "time", "timestamp", "datetime", "date_time", "utc", "unix", "seconds", "t", "time_utc", "utc_time"),
    *("time_ms", "t_ms", "unix_ms", "sod", "seconds_of_day", "clock", "epoch", "local_time", "time_local"),
)
"""Headings, in any case and without their units, that are taken for the time where none is named."""
DATE_NAMES, CLOCK_NAMES = ("date", "date_utc", "utc_date"), ("time", "clock", "utc", "time_utc", "utc_time", "hhmmss")
WEEK_NAMES = ("gps_week", "gpsweek", "week", "wn")
TOW_NAMES = ("gps_tow", "tow", "gps_seconds", "gps_time", "seconds_of_week", "sow", "tow_s", "tow_ms")
BAD_WORDS = ("false", "invalid", "bad", "no", "v")
"""Texts that call a sample not valid; those of GOOD_WORDS, and a number other than 0, call it valid."""
_LENGTHS = {"cm": 0.01, "mm": 0.001, "ft": 0.3048, "feet": 0.3048, "dm": 0.1, "inch": 0.0254}
_ANGLES = {word: math.radians(1.0) for word in ("deg", "degs", "degree", "degrees", "°", "º")} | {"mrad": 1e-3}
"""Units that headings state, in metres and radians."""
_SENTENCE = re.compile(r"([$!](?:P[A-Z]{3,}|[A-Z]{5})),[^*]*(\*[0-9A-Fa-f]{2})?")
_NOVATEL = re.compile(r"\s*[#%]([A-Z0-9]+A),[^;]*;")
"""Head of a log of NovAtel's receivers in ASCII (OEM7 Commands and Logs Reference Manual, ASCII message format)."""
_GROUPED = re.compile(r"[+-]?(\d{1,3}([.,' ]\d{3})+([.,]\d*)?|\d+,\d+)")
"""A number with marks for thousands, or with a decimal comma where the others have points."""
_UNIT = re.compile(r"\s*[\[(].*?[\])]\s*")


class ShipLog:
    """A text file of columns; see `heave_node.files.columns` for its form.

    Parameters
    ----------
    source : the file

    Attributes
    ----------
    header : headings, in order
    notes : what was found out about the form, one line each

    Raises BagError for a file that cannot be read, is empty, has no columns, or holds NMEA 0183.
    """

    def __init__(self, source: Path) -> None:
        self.source = source
        try:
            text = read_text(source)
            _refuse_sentences(text.lines)
            self._columns = read_columns(text.lines)
        except TextFileError as error:
            raise BagError(str(error)) from error
        except ColumnsError as error:
            raise BagError(f"{source}: {error}") from error
        self.header = self._columns.header
        self.notes = [*text.notes, *self._columns.notes]

    def numbers(self, column: str, role: str) -> Array:
        """Return a `column`, called in any case with its unit or without, as numbers; a cell that is none is NaN.

        It is wanted for a `role`, which is named where it is missing.
        Raises BagError where there is no such column, or for a number whose comma or point can be of thousands.
        """
        cells = self._cells(column, role)
        values = np.array([self._columns.number(text) for text in cells])
        strange = next((i for i in np.flatnonzero(np.isnan(values)) if _GROUPED.fullmatch(cells[i].strip())), None)
        if strange is not None:
            raise BagError(
                f"{self.source}: line {self._columns.lines[strange]}: {column} = {cells[strange].strip()!r} can be "
                "read in two ways: write all numbers of the file with decimal points, without marks for thousands"
            )
        return values

    def validity(self, column: str, channel: Channel) -> NDArray[np.bool_]:
        """Return which samples of a `channel` a `column` calls valid, shape (n,) of bool.

        Raises BagError where there is no such column, or for a word that says neither.
        """
        statuses = [_status(cell.strip()) for cell in self._cells(column, "valid")]
        known = ("", *GOOD_WORDS, *BAD_WORDS)
        strange = next((one for one in statuses if isinstance(one, str) and one.lower() not in known), None)
        if strange is not None and not (channel.invalid_bits or channel.valid_values):
            raise BagError(
                f"{self.source}: {column} = {strange!r} is neither a number nor one of "
                f"{', '.join((*GOOD_WORDS, *BAD_WORDS))}"
            )
        return np.array([channel.is_valid(status) for status in statuses])

    def stated_scale(self, column: str, motion: str) -> tuple[str, float]:
        """Return the unit that heading or unit line of a `column` state for a `motion`, and its size in m or rad.

        The size is negative for heave that they call positive down.
        ("", 1) where it is theirs, or none is stated. Raises BagError where there is no such column.
        """
        words = re.split(r"[^a-z°º]+", self._with_unit(self._place(column, motion)).lower())
        sizes = _ANGLES if motion in ("roll", "pitch") else _LENGTHS
        unit, size = next(((word, sizes[word]) for word in words if word in sizes), ("", 1.0))
        if motion == "heave" and "down" in words:
            return f"{unit or 'm'} positive down", -size
        return unit, size

    def find(self, *names: str) -> str:
        """Return the first heading that is one of the `names`, in any case and without its unit; "": there is none."""
        known = {_bare(name): name for name in reversed(self.header)}
        return next((known[name] for name in names if name in known), "")

    def time(self, column: str | Sequence[str], scale: float, order: str = "") -> tuple[Array, list[str]]:
        """Return the time of each row [s], and what was found out about it.

        Parameters
        ----------
        column : its heading, those of date and time, or of GPS week and seconds; "": found by their names
        scale : time in seconds = scale * number; 1 for Unix time in any unit, which shows in its size
        order : of dates with the year last, one of DATE_ORDERS; "": as the dates themselves show

        Raises BagError where the columns are not there, or hold no time.
        """
        names = [column] if isinstance(column, str) else list(column)
        others: list[str] = []
        if names == [""]:
            names = self._time_columns()
            known = {_bare(name): name for name in self.header if name not in names}
            others = [known[name] for name in (*TIME_NAMES, *TOW_NAMES) if name in known and len(names) == 1]
        parts = [[cell.strip() for cell in self._cells(name, "time")] for name in names]
        try:
            time, notes = self._time_of(names, parts, scale, order)
        except TimeError as error:
            raise BagError(f"{self.source}: {' and '.join(names)}: {error}") from error
        time, found = counted_on(time)
        time, words = spread(time)
        notes += found
        if others:
            notes.append(f"time: taken from {names[0]}, not from {', '.join(others)}; --time-column names another")
        return time, notes + words

    def _time_of(
        self, names: Sequence[str], parts: Sequence[Sequence[str]], scale: float, order: str
    ) -> tuple[Array, list[str]]:
        if len(parts) == 2:
            week, second = (np.array([self._columns.number(cell) for cell in part]) for part in parts)
            if is_gps(week, second):
                return gps_time(week, second)
        texts = [" ".join(row) for row in zip(*parts, strict=True)]
        numbers = np.array([self._columns.number(text) for text in texts])
        if np.isfinite(numbers).mean() > 0.5:
            return time_of_numbers(numbers, self._with_unit(self._place(names[0], "time")), scale)
        return time_of_texts(texts, order)

    def _time_columns(self) -> list[str]:
        week, second = self.find(*WEEK_NAMES), self.find(*TOW_NAMES)
        if week and second:
            return [week, second]
        date, clock = self.find(*DATE_NAMES), self.find(*CLOCK_NAMES)
        if date and clock:
            return [date, clock]
        found = self.find(*TIME_NAMES) or date
        if not found:
            raise BagError(
                f"{self.source}: which column is the time? name it by --time-column, or by time_column in a mapping "
                f"file; it has {', '.join(self.header)}"
            )
        return [found]

    def _cells(self, column: str, role: str) -> list[str]:
        index = self.header.index(self._place(column, role))
        return [row[index] if index < len(row) else "" for row in self._columns.rows]

    def _place(self, column: str, role: str) -> str:
        """Return the heading that is meant by `column`."""
        place = column if column in self.header else self.find(_bare(column))
        if not place:
            raise BagError(f"{self.source}: no column {column!r} for {role}; it has {', '.join(self.header)}")
        same = [name for name in self.header if (name if column in self.header else _bare(name)) == _bare(place)]
        if self.header.count(place) > 1 or (column not in self.header and len(same) > 1):
            raise BagError(
                f"{self.source}: {column!r} for {role} names more than one column ({', '.join(self.header)}): give "
                "each a heading of its own, and name the whole of it"
            )
        return place

    def _with_unit(self, place: str) -> str:
        """Return the heading `place` and the unit below it."""
        index, units = self.header.index(place), self._columns.units
        return f"{place} {units[index]}" if index < len(units) else place


def is_text(source: Path) -> bool:
    """Return whether a `source` is read as a log: a file that neither by its ending nor by its first bytes is a bag."""
    if source.exists() and not source.is_file():
        return not source.is_dir()  # a pipe is not opened: it may never end
    if source.suffix.lower() in (".mcap", ".db3", ".bag", ".zstd", ".zst"):
        return False
    try:
        with source.open("rb") as file:
            return not file.read(8).startswith((b"\x89MCAP0\r\n", b"SQLite f", b"#ROSBAG "))
    except OSError:
        return source.suffix.lower() in (".csv", ".txt", ".log", ".tsv")


def _refuse_sentences(lines: Sequence[str]) -> None:
    """Raise ColumnsError for lines that are sentences of NMEA 0183, a stamp before them or not, or NovAtel's logs."""
    written = [line for line in lines[:200] if line.strip()]
    if (logs := [match[1] for line in written if (match := _NOVATEL.match(line))]) and 2 * len(logs) > len(written):
        raise ColumnsError(
            f"{len(lines)} lines of NovAtel's ASCII logs ({', '.join(dict.fromkeys(logs))}): "
            "--mapping novatel_ascii reads INSPVA and INSPVAS"
        )
    found = [match[1] for line in lines[:200] if (match := _SENTENCE.search(line))]
    if found and 2 * len(found) > len(written):
        kinds = ", ".join(dict.fromkeys(found))
        raise ColumnsError(
            f"this is NMEA 0183 ({kinds}): sentences, not columns under headings: say by --mapping which field of "
            "which sentence is heave, as the maps of `heave adapt --list` do"
        )


def _bare(heading: str) -> str:
    """Return a heading in small letters, without a unit in brackets, words joined by _."""
    return re.sub(r"\W+", "_", _UNIT.sub(" ", heading).strip().lower()).strip("_") or heading.strip().lower()


def _status(cell: str) -> float | str:
    """Return the number in a `cell`, such as 6 or 0x8000; the text of one that holds none."""
    try:
        return float(int(cell, 16)) if "x" in cell.lower() else float(cell)
    except (ValueError, OverflowError):
        return cell
