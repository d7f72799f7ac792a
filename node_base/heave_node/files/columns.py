"""Tables in text as tools write them: columns by commas, semicolons, tabs or spaces, decimal points or commas.

Before the line of headings there may be lines of any kind, after it one of units; lines that begin with # are comments.
Separator and headings are found by the rows of numbers below them.
"""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

_SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "": "spaces"}
"""Each with its name; "" is any number of spaces."""
_SAMPLE = 300
"""Lines at the end of a file by which its format is recognised."""
_POINT = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_POINT_OR_COMMA = re.compile(r"[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?")
_TIME = re.compile(
    r"\d[\d:./\-]*[:/\-][\d:./\-,T Z+]*\d\d?( ?[AP]M)?( ?(UTC|GMT))?( ?[Z+-][\d:]*)?|[+-]?(nan|inf)", re.IGNORECASE
)
_UNITS = frozenset(
    (
        *("s", "ms", "us", "sec", "secs", "second", "seconds", "min", "mins", "minutes", "h", "hr", "hrs", "hours"),
        *("m", "cm", "mm", "ft", "feet", "metre", "metres", "meter", "meters", "m/s", "m/s2", "m/s^2", "m/s²", "g"),
        *("deg", "degree", "degrees", "°", "º", "rad", "rads", "radians", "deg/s", "rad/s", "hz", "kn", "kt", "knots"),
        *("n", "v", "%", "utc", "yyyy-mm-dd", "hh:mm:ss", "-", "none", "bool"),
    )
)
"""Words of a line of units."""


class ColumnsError(ValueError):
    """Text that is no table; the message says what is missing, without the file's name."""


@dataclass(frozen=True)
class Columns:
    """A table of text."""

    header: list[str]  # headings, in order
    header_line: int  # number of their line, from 1
    rows: list[list[str]]  # cells of each row, as many as there are
    lines: list[int]  # number of each row's line, from 1
    decimal_comma: bool = False  # numbers have decimal commas
    # of each column, as the line below the headings has them; empty where there is none
    units: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)  # what was found out about the form, one line each

    def number(self, text: str) -> float:
        """Return the `text` of a cell as a number; NaN where it is none."""
        try:
            return float(text.replace(",", ".") if self.decimal_comma else text)
        except ValueError:
            return math.nan


def read_columns(lines: Sequence[str], known: Collection[str] = ()) -> Columns:
    """Return the table in `lines` of text.

    Parameters
    ----------
    lines : of the file
    known : headings of which some are there: the first line with one of them is that of the headings. Empty: it is the
        last line before the rows of numbers that has as many cells

    Raises ColumnsError where there is no line, none with headings, or no row.
    """
    numbered = [(n, line) for n, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")]
    if not numbered:
        comments = sum(bool(line.strip()) for line in lines)
        raise ColumnsError(f"{comments} lines, all begin with #, as comments do" if comments else "is empty")
    separator = _separator([line for _, line in numbered], known)
    cells = _split([line for _, line in numbered], separator)
    notes = [] if separator in (",", ";") else [f"columns parted by {_SEPARATORS[separator]}"]
    comma = separator != "," and _has_commas(cells[-_SAMPLE:])
    if comma and separator != ";":
        notes.append("numbers with decimal commas")
    first, units = _places(cells, known)
    if first is None:
        header, header_line, start = [*_from_comment(lines, separator, len(cells[-1]), numbered[0][0]), 0]
        notes.append(f"headings taken from the comment in line {header_line}")
    else:
        header, header_line, start = cells[first], numbered[first][0], first + 1 + units
        if len(header) == 1 and not known and len(cells[-1]) > 1:
            raise ColumnsError(
                f"has no headings for its {len(cells[-1])} columns, parted by {_SEPARATORS[separator]} from line "
                f"{header_line + 1} on: line {header_line} is {header[0][:60]!r}"
            )
    if first is not None and first > 0:
        notes.append(f"{first} lines before the headings in line {header_line} left out")
    if units:
        notes.append(f"units in line {numbered[start - 1][0]}: {', '.join(cells[start - 1])}")
    header = [name.strip() for name in header]
    kept = _without_repeats(header, header_line, cells, range(start, len(cells)), numbered)
    if len(kept) < len(cells) - start:
        notes.append(f"headings repeated among the rows: {len(cells) - start - len(kept)} lines left out")
    if not kept:
        raise ColumnsError("has a header but no rows")
    return Columns(
        header,
        header_line,
        [cells[index] for index in kept],
        [numbered[index][0] for index in kept],
        comma,
        [name.strip() for name in cells[start - 1]] if units else [],
        notes,
    )


def _split(lines: Sequence[str], separator: str) -> list[list[str]]:
    if not separator:
        return [line.split() for line in lines]
    try:
        # one line is one row, whatever quotes are left open in it
        return [next(csv.reader([line], delimiter=separator, skipinitialspace=True), [""]) for line in lines]
    except csv.Error as error:
        raise ColumnsError(f"cannot be parted into columns: {error}") from error


def _separator(lines: Sequence[str], known: Collection[str]) -> str:
    """Return the separator by which most lines have equally many cells, and most of those numbers."""
    if known:
        for separator in _SEPARATORS:
            for line in lines:
                if len({name.strip() for name in _split([line], separator)[0]} & set(known)) > 1:
                    return separator
    sample = lines[-_SAMPLE:]

    def score(separator: str) -> tuple[float, int]:
        cells = _split(sample, separator)
        width, _ = Counter(map(len, cells)).most_common(1)[0]
        if width < 2:
            return 0.0, 0
        number = _POINT if separator == "," else _POINT_OR_COMMA
        good = sum(_is_figure(cell, number) for row in cells if len(row) == width for cell in row)
        return round(good / (len(cells) * width), 3), width

    best = max(_SEPARATORS, key=score)
    return best if score(best) > (0.0, 0) else max((",", ";", "\t"), key=lines[0].count)


def _is_figure(cell: str, number: re.Pattern[str]) -> bool:
    text = cell.strip()
    return bool(number.fullmatch(text) or _TIME.fullmatch(text))


def _has_commas(rows: Sequence[Sequence[str]]) -> bool:
    texts = [text for row in rows for cell in row if _POINT_OR_COMMA.fullmatch(text := cell.strip())]
    commas = sum("," in text for text in texts)
    return commas > 0 and not any("." in text for text in texts if not text.startswith("."))


def _places(cells: Sequence[Sequence[str]], known: Collection[str]) -> tuple[int | None, int]:
    """Return the index of the line of headings (None: there is none), and how many lines of units stand below it."""
    if known:
        for index, row in enumerate(cells):
            if {name.strip() for name in row} & set(known):
                return index, int(index + 1 < len(cells) and _are_units(cells[index + 1]))
        return 0, 0
    width, _ = Counter(len(row) for row in cells[-_SAMPLE:]).most_common(1)[0]
    counts = [_figures(row) for row in cells[-_SAMPLE:] if len(row) == width]
    usual = sorted(counts)[len(counts) // 2]
    least = max(1.0, 0.8 * usual)
    first = next((i for i, row in enumerate(cells) if len(row) == width and _figures(row) >= least), None)
    if first is None or usual == 0:
        return 0, 0
    while first and len(cells[first - 1]) == width and _is_figure(cells[first - 1][0], _POINT_OR_COMMA):
        first -= 1  # a row with words for what is missing
    if first == 0:
        return None, 0
    units = int(first > 1 and _are_units(cells[first - 1]))
    return first - 1 - units, units


def _figures(row: Sequence[str]) -> int:
    """Return how many cells of a row are numbers or times, or empty."""
    return sum(not cell.strip() or _is_figure(cell, _POINT_OR_COMMA) for cell in row)


def _are_units(row: Sequence[str]) -> bool:
    cells = [cell.strip() for cell in row]
    words = [cell.strip("[]()").lower() for cell in cells]
    if not any(words):
        return False
    if all(cell[:1] + cell[-1:] in ("[]", "()", "") for cell in cells):
        return True
    return all(not word or word in _UNITS or all(part in _UNITS for part in word.split("/")) for word in words)


def _without_repeats(
    header: Sequence[str],
    header_line: int,
    cells: Sequence[Sequence[str]],
    indices: Sequence[int],
    numbered: Sequence[tuple[int, str]],
) -> list[int]:
    """Return the `indices` of rows of `cells` that do not repeat the headings, or their units.

    Raises ColumnsError for other headings among the rows: what is below them has other columns or units.
    """
    kept: list[int] = []
    for index in indices:
        row = cells[index]
        if _is_figure(row[0], _POINT_OR_COMMA) or not row[0].strip():
            kept.append(index)
            continue
        names = [name.strip() for name in row]
        if names == header:
            continue
        is_repeated_before = index - 1 in indices and (not kept or kept[-1] != index - 1)
        if is_repeated_before and _are_units(row):
            continue
        is_like = names[0] == header[0] or len(set(names) & set(header)) > 1
        if is_like and not any(name and _is_figure(name, _POINT_OR_COMMA) for name in names):
            raise ColumnsError(
                f"has other headings in line {numbered[index][0]} ({', '.join(names)}) than in line {header_line}: "
                "split the file there"
            )
        kept.append(index)
    return kept


def _from_comment(lines: Sequence[str], separator: str, width: int, before: int) -> tuple[list[str], int]:
    """Return the headings in the last comment before the line `before` that has `width` cells, and its number."""
    for number in range(before - 1, 0, -1):
        line = lines[number - 1].lstrip().lstrip("#").strip()
        names = _split([line], separator)[0] if line else []
        if len(names) == width:
            return names, number
    raise ColumnsError(f"has no line of headings: name its {width} columns in a first line")
