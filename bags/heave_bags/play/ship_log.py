"""Logs of ships as text: columns by name, time in seconds, Unix time or ISO 8601, commas, semicolons or tabs."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from datetime import datetime, timezone
from pathlib import Path

import numpy as np
from heave_node.files.given_files import read_given
from heave_node.numerics.arrays import Array

from heave_bags.errors import BagError

SEPARATORS = (",", ";", "\t")
TIME_NAMES = ("time_s", "time", "timestamp", "datetime", "date_time", "utc", "unix", "seconds", "t")
"""Headings, in any case, that are taken for the time where none is named."""
UNIX_UNITS = ((1e17, 1e-9, "nanoseconds"), (1e14, 1e-6, "microseconds"), (1e11, 1e-3, "milliseconds"))
"""From which number on a time is Unix time in which unit: 1e11 s is the year 5138."""
EARLIEST_UNIX = 1e8
"""A time from this on is a date (3 March 1973); below, it counts from some start of its own [s]."""


class ShipLog:
    """A text file of columns under a line of headings; lines that begin with # are left out.

    Parameters
    ----------
    source : the file

    Raises BagError for a file that cannot be read, is empty, or has a header alone.
    """

    def __init__(self, source: Path) -> None:
        self.source = source
        try:
            lines = read_given(source, encoding="utf-8-sig").splitlines()
        except (OSError, ValueError) as error:
            raise BagError(f"{source}: cannot be read: {error}") from error
        lines = [line for line in lines if line.strip() and not line.startswith("#")]
        if not lines:
            raise BagError(f"{source}: is empty")
        self._separator = max(SEPARATORS, key=lines[0].count)
        rows = [row for row in csv.reader(lines, delimiter=self._separator) if row]
        self.header = [name.strip() for name in rows[0]]
        self._rows = rows[1:]
        if not self._rows:
            raise BagError(f"{source}: has a header but no rows")

    def numbers(self, column: str, role: str) -> Array:
        """Return a column as numbers; a cell that is none is NaN.

        Parameters
        ----------
        column : its heading
        role : what it is wanted for, named where it is missing

        Raises BagError where there is no such column.
        """
        return np.array([self._number(text) for text in self._cells(column, role)])

    def time(self, column: str | Sequence[str], scale: float) -> tuple[Array, str]:
        """Return the time of each row [s], and what was found out about it ("": nothing).

        Parameters
        ----------
        column : its heading, or those of date and time; "": found by its name
        scale : time in seconds = scale * number; 1 for Unix time in any unit, which shows in its size
        """
        columns = [column] if isinstance(column, str) else list(column)
        columns = [self._time_column()] if columns == [""] else columns
        parts = [self._cells(name, "time") for name in columns]
        texts = [" ".join(part.strip() for part in row) for row in zip(*parts, strict=True)]
        numbers = np.array([self._number(text) for text in texts])
        if np.isfinite(numbers).mean() > 0.5:
            return self._seconds(numbers, scale)
        time = np.array([unix_time(text) for text in texts])
        if not np.isfinite(time).any():
            raise BagError(
                f"{self.source}: {' and '.join(columns)} = {texts[0]!r} is neither a number nor a time as in "
                "2025-03-01T12:00:00.5Z"
            )
        return time, ""

    def _seconds(self, numbers: Array, scale: float) -> tuple[Array, str]:
        middle = float(np.nanmedian(numbers))
        for least, unit, words in UNIX_UNITS:
            if scale == 1.0 and middle > least:
                return numbers * unit, f"time: taken as {words} of Unix time"
        return numbers * scale, ""

    def _time_column(self) -> str:
        known = {name.lower(): name for name in reversed(self.header)}
        found = next((known[name] for name in TIME_NAMES if name in known), None)
        if found is None:
            raise BagError(
                f"{self.source}: which column is the time? name it by time_column in a mapping file (--mapping); "
                f"it has {', '.join(self.header)}"
            )
        return found

    def _cells(self, column: str, role: str) -> list[str]:
        if column not in self.header:
            raise BagError(f"{self.source}: no column {column!r} for {role}; it has {', '.join(self.header)}")
        index = self.header.index(column)
        return [row[index] if index < len(row) else "" for row in self._rows]

    def _number(self, text: str) -> float:
        try:
            return float(text.replace(",", ".") if self._separator == ";" else text)
        except ValueError:
            return math.nan


def unix_time(text: str) -> float:
    """Return the Unix time of a `text` in ISO 8601 [s]; NaN where it is none. Without a zone it is UTC."""
    text = text.strip().replace("Z", "+00:00").replace("z", "+00:00").replace(",", ".")
    head, point, tail = text.partition(".")
    digits = len(tail) - len(tail.lstrip("0123456789"))
    fraction = f".{tail[:digits]:0<6.6}" if point and digits else ""  # Python 3.10 reads three or six digits alone
    try:
        moment = datetime.fromisoformat(head + fraction + tail[digits:])
    except ValueError:
        return math.nan
    return (moment if moment.tzinfo else moment.replace(tzinfo=timezone.utc)).timestamp()


def time_words(time: float) -> str:
    """Return a `time` [s] as a person reads it: a date where it is Unix time, else seconds."""
    if time < EARLIEST_UNIX:
        return f"t = {time:.3f} s"
    return datetime.fromtimestamp(time, tz=timezone.utc).isoformat(timespec="milliseconds").replace("+00:00", "Z")
