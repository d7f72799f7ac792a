"""RAO tables from files: CSV (read and written), and Capytaine's NetCDF database by `capytaine_files`.

CSV: comment lines begin with #, then a header and one row for each speed, heading and frequency, in any order, the
grid complete; parted by commas, semicolons (decimal commas), tabs or spaces. Columns: speed_mps, heading_rad,
omega_radps, and for each of surge, sway, heave, roll, pitch, yaw an amplitude (surge_m_per_m, roll_rad_per_m, ...) and
a phase lead over the wave crest (surge_phase_rad, ...). Conventions: see `rao`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cache, lru_cache
from importlib import resources
from pathlib import Path

import numpy as np
from heave_node.files.columns import Columns, ColumnsError, read_columns
from heave_node.files.given_files import TextFileError, read_text
from heave_node.files.plausible import question
from heave_node.numerics.arrays import Array

from wave_vessel_node.vessel.capytaine_files import read_capytaine
from wave_vessel_node.vessel.motion import DEGREES_OF_FREEDOM
from wave_vessel_node.vessel.rao import RaoError, ResponseTable, judged

SHIPPED_TABLE = "wigley_90m.csv"
_GRID = ("speed_mps", "heading_rad", "omega_radps")
_UNITS = ("m_per_m", "m_per_m", "m_per_m", "rad_per_m", "rad_per_m", "rad_per_m")
_AMPLITUDES = tuple(f"{name}_{unit}" for name, unit in zip(DEGREES_OF_FREEDOM, _UNITS, strict=True))
_PHASES = tuple(f"{name}_phase_rad" for name in DEGREES_OF_FREEDOM)
COLUMNS = (*_GRID, *(column for pair in zip(_AMPLITUDES, _PHASES, strict=True) for column in pair))


@cache
def shipped_rao() -> ResponseTable:
    """Return the RAOs of the hull form that ships with the package (see the comments in its file)."""
    with resources.as_file(resources.files("wave_vessel_node") / "data" / SHIPPED_TABLE) as path:
        return read_rao_csv(path)


def read_rao(path: str | Path, speeds: Sequence[float] = (0.0,), accept_implausible: bool = False) -> ResponseTable:
    """Read a table.

    Parameters
    ----------
    path : ends in .csv or .nc; empty takes the hull form that ships with the package
    speeds : forward speeds [m/s] of the table that is made of a Capytaine database (.nc); a .csv has its own
    accept_implausible : take implausible figures as they are; they are in the table's warnings

    Raises RaoError when the file is missing, of another kind or broken, or for implausible figures
    (`heave_node.files.plausible`).
    """
    if not str(path):
        return shipped_rao()
    path = Path(path)
    if not path.is_file():
        raise RaoError(f"{path}: no such file")
    found = path.stat()
    return _read_once(path, (found.st_mtime_ns, found.st_size), tuple(speeds), accept_implausible)


@lru_cache(maxsize=8)
def _read_once(path: Path, _: object, speeds: tuple[float, ...], accept_implausible: bool) -> ResponseTable:
    """Return the table of a file, read once for many runs; a file that was changed is another one."""
    if path.suffix.lower() == ".csv":
        return read_rao_csv(path, accept_implausible=accept_implausible)
    if path.suffix.lower() in (".nc", ".nc4"):
        return read_capytaine(path, speeds=speeds, accept_implausible=accept_implausible)
    raise RaoError(f"{path}: expected an RAO table (.csv) or a Capytaine database (.nc)")


def read_rao_csv(path: str | Path, *, accept_implausible: bool = False) -> ResponseTable:
    """Read the CSV table at `path`; see the module for its columns, `read_rao` for `accept_implausible` and errors."""
    path = Path(path)
    try:
        text = read_text(path)
        table = read_columns(text.lines, COLUMNS)
    except TextFileError as error:
        raise RaoError(str(error)) from error
    except ColumnsError as error:
        raise RaoError(f"{path}: {error}") from error
    missing = [name for name in COLUMNS if name not in table.header]
    if missing:
        wrong = f"missing columns {', '.join(missing)}" if len(missing) < len(COLUMNS) else "expected the header "
        header = ",".join(COLUMNS) if len(missing) == len(COLUMNS) else ""
        raise RaoError(f"{path}: line {table.header_line}: {wrong}{header}")
    values = _numbers(path, table)
    response = _grid_table(path, values)
    notes = tuple(f"{path}: {note}" for note in (*text.notes, *table.notes))
    return judged(
        path, replace(response, warnings=notes), _phase_questions(values, table.lines), accept=accept_implausible
    )


def _numbers(path: Path, table: Columns) -> Array:
    """Return the rows of a table as numbers in the order of COLUMNS; raise RaoError with the line."""
    values = np.empty((len(table.rows), len(COLUMNS)))
    positions = [table.header.index(name) for name in COLUMNS]
    for index, (number, row) in enumerate(zip(table.lines, table.rows, strict=True)):
        if len(row) != len(table.header):
            raise RaoError(f"{path}: line {number}: {len(row)} values where the header has {len(table.header)} columns")
        for column, position in enumerate(positions):
            text = row[position].strip()
            value = table.number(text)
            if not math.isfinite(value):
                kind = "finite number" if text.lower().strip("+-") in ("nan", "inf", "infinity") else "number"
                raise RaoError(f"{path}: line {number}: {COLUMNS[column]}: {text!r} is not a {kind}")
            values[index, column] = value
    return values


def _phase_questions(values: Array, lines: Sequence[int]) -> list[str]:
    """Return what is implausible about the phases: of each motion the largest."""
    worst = np.argmax(np.abs(values[:, 4::2]), axis=0)
    largest = values[worst, np.arange(4, values.shape[1], 2)]
    asked = (
        question("phase", float(value), f"line {lines[row]}: {name}")
        for row, value, name in zip(worst, largest, _PHASES, strict=True)
    )
    return [objection for objection in asked if objection]


def _grid_table(path: Path, values: Array) -> ResponseTable:
    """Put the rows on their grid; each point must be there once."""
    axes = [np.unique(values[:, column]) for column in range(3)]
    shape = tuple(axis.size for axis in axes)
    index = [np.searchsorted(axis, values[:, column]) for column, axis in enumerate(axes)]
    count = np.zeros(shape, dtype=int)
    np.add.at(count, tuple(index), 1)
    if (count != 1).any():
        where = np.argwhere(count != 1)[0]
        point = ", ".join(f"{name} {axis[i]:g}" for name, axis, i in zip(_GRID, axes, where, strict=True))
        found = "missing" if count[tuple(where)] == 0 else "repeated"
        raise RaoError(f"{path}: the grid of speeds, headings and frequencies is not complete: {point} is {found}")
    amplitude, phase = values[:, 3::2], values[:, 4::2]
    if (amplitude < 0.0).any():
        raise RaoError(f"{path}: an amplitude is negative ({amplitude.min():g}): shift its phase by pi instead")
    response = np.empty((*shape, 6), dtype=complex)
    response[tuple(index)] = amplitude * np.exp(1j * phase)
    try:
        return ResponseTable(axes[0], axes[1], axes[2], np.ascontiguousarray(np.swapaxes(response, 2, 3)))
    except RaoError as error:
        raise RaoError(f"{path}: {error}") from error


def write_rao_csv(path: str | Path, table: ResponseTable, comments: Iterable[str] = ()) -> None:
    """Write at `path` a `table` that `read_rao_csv` reads; `comments` go before it."""
    lines = [f"# {comment}".rstrip() for comment in comments]
    lines.append(",".join(COLUMNS))
    for s, speed in enumerate(table.speed):
        for h, heading in enumerate(table.heading):
            for f, omega in enumerate(table.frequency):
                motion = table.response[s, h, :, f]
                numbers = [f"{speed:g}", f"{heading:.6f}", f"{omega:g}"]
                for value in motion:
                    numbers += [f"{abs(value):.4e}", f"{np.angle(value):.4f}"]
                lines.append(",".join(numbers))
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")
