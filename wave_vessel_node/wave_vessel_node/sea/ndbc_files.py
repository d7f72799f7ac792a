"""Spectra from NDBC's files: real time and historical spectral density.

A file holds many records (one an hour, say). Missing values (fill values of 99 and 999) and records without energy are
left out or repaired; each kind of repair is a warning. What cannot be repaired is refused with SpectrumFileError;
so are NDBC's files of directions and of r1, r2, which have the same form.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta, timezone
from pathlib import Path

import numpy as np
from heave_node.files.given_files import TextFileError, read_text
from heave_node.numerics.arrays import Array

from wave_vessel_node.sea.spectra import SpectrumError, TabulatedSpectrum
from wave_vessel_node.sea.spectrum_record import (
    SpectrumFile,
    SpectrumFileError,
    SpectrumRecord,
    objection_to,
    refuse_without_records,
    tabulated_from_hertz,
)

_FILL_VALUES = (99.0, 999.0, 9999.0)
_PAIR = re.compile(r"(\S+)\s*\(\s*(\S+?)\s*\)")
_ROUNDING = 1e-3  # [m^2/Hz] a density this little below zero is rounding of the file, not an error


def read_ndbc(path: Path, *, accept_implausible: bool = False) -> SpectrumFile:
    """Read NDBC's text file at `path`, plain or compressed by gzip (.gz).

    Parameters
    ----------
    path : of the file
    accept_implausible : keep implausible records, which else are left out; both are in the warnings

    Raises SpectrumFileError where the file is of another format, truncated within its header, or holds no usable
    record.
    """
    lines = _read_lines(path)
    header = lines[0].split()
    if not header or not header[0].lstrip("#").upper().startswith("YY"):
        raise SpectrumFileError(
            f"{path}: line 1: expected an NDBC header starting with YY or #YY (or NetCDF, or text of a model or buoy "
            f"that wavespectra reads), got {lines[0][:40].strip()!r}"
        )
    findings = _Findings(str(path), accept_implausible)
    real_time = "(freq" in lines[0].replace(" ", "").lower()
    rows = _real_time_rows(path, lines, findings) if real_time else _historical_rows(path, lines, findings)
    records = _records(rows, findings)
    if not records:
        refuse_without_records(str(path), findings.warnings() or (f"no data in {len(lines)} lines",))
    return SpectrumFile(str(path), tuple(records), findings.warnings())


@dataclass
class _Row:
    line: int
    time: datetime
    frequency: Array  # Hz
    density: Array  # m^2/Hz


class _Findings:
    """Counts of each repair, with the line of the first and what is implausible about it."""

    def __init__(self, path: str, accepts: bool) -> None:
        self._path = path
        self.accepts = accepts
        self._counts: dict[str, tuple[int, int, str]] = {}

    def add(self, what: str, line: int, objection: str = "") -> None:
        count, first, why = self._counts.get(what, (0, line, objection))
        self._counts[what] = (count + 1, first, why)

    def warnings(self) -> tuple[str, ...]:
        return tuple(
            f"{self._path}: {what} ({count} times, first on line {line}{why and ': '}{why})"
            for what, (count, line, why) in self._counts.items()
        )


def _read_lines(path: Path) -> list[str]:
    try:
        lines = [line for line in read_text(path).lines if line.strip()]
    except TextFileError as error:
        raise SpectrumFileError(str(error)) from error
    if len(lines) < 2:
        raise SpectrumFileError(f"{path}: has {len(lines)} lines: expected a header and at least one record")
    return lines


def _real_time_rows(path: Path, lines: Sequence[str], findings: _Findings) -> Iterable[_Row]:
    """Rows `YY MM DD hh mm Sep_Freq density (frequency) ...`."""
    if "spec" not in lines[0].lower():
        first = next(word for word in lines[0].split() if "_1" in word or "(" in word)
        raise SpectrumFileError(
            f"{path}: line 1: holds {first.strip('<')}, not densities (spec_1): take NDBC's .data_spec instead"
        )
    expected: int | None = None
    for number, line in enumerate(lines[1:], start=2):
        if line.startswith("#"):
            continue
        fields = line.split(maxsplit=6)
        if len(fields) < 7:
            findings.add("truncated record skipped", number)
            continue
        pairs = _PAIR.findall(fields[6])
        time = _time(path, number, fields[:5])
        rest = _PAIR.sub("", fields[6]).strip()
        expected = len(pairs) if expected is None else expected
        if rest or len(pairs) != expected:
            findings.add("truncated record skipped", number)
            continue
        values = np.array([[_number(path, number, text) for text in pair] for pair in pairs])
        yield _Row(number, time, values[:, 1], values[:, 0])


def _historical_rows(path: Path, lines: Sequence[str], findings: _Findings) -> Iterable[_Row]:
    """Header `YY MM DD hh [mm] f1 f2 ...`, rows of the date and one density for each frequency."""
    names = lines[0].split()
    dates = next((i for i, name in enumerate(names) if re.fullmatch(r"\d*\.\d+", name)), len(names))
    if "WVHT" in names:
        raise SpectrumFileError(
            f"{path}: line 1: holds heights and periods, not spectra: take NDBC's .data_spec or spectral wave density"
        )
    if dates not in (4, 5) or len(names) - dates < 3:
        raise SpectrumFileError(f"{path}: line 1: expected YY MM DD hh [mm] followed by at least 3 frequencies [Hz]")
    frequency = np.array([float(_number(path, 1, name)) for name in names[dates:]])
    if (np.diff(frequency) <= 0.0).any() or frequency[0] <= 0.0:
        raise SpectrumFileError(f"{path}: line 1: frequencies must be above 0 and strictly increasing")
    for number, line in enumerate(lines[1:], start=2):
        if line.startswith("#"):
            continue
        fields = line.split()
        if len(fields) != len(names):
            findings.add(f"record without {len(names)} columns skipped", number)
            continue
        time = _time(path, number, fields[:dates])
        yield _Row(number, time, frequency, np.array([_number(path, number, text) for text in fields[dates:]]))


def _records(rows: Iterable[_Row], findings: _Findings) -> list[SpectrumRecord]:
    records: dict[datetime, SpectrumRecord] = {}
    for row in rows:
        spectrum = _usable(row, findings)
        if spectrum is None:
            continue
        if row.time in records:
            findings.add("second record with the same time skipped", row.line)
            continue
        records[row.time] = SpectrumRecord(row.time, spectrum)
    return [records[time] for time in sorted(records)]


def _usable(row: _Row, findings: _Findings) -> TabulatedSpectrum | None:
    """Repair or leave out one record."""
    missing = np.isin(row.density, _FILL_VALUES) | ~np.isfinite(row.density) | ~np.isfinite(row.frequency)
    if missing.mean() > 0.1:
        findings.add("record with more than a tenth of its densities missing (fill value or NaN) skipped", row.line)
        return None
    if missing.any():
        findings.add("missing density (fill value or NaN) filled from its neighbours", row.line)
    frequency, density = row.frequency[~missing], row.density[~missing]
    if (density < -_ROUNDING).any():
        findings.add("record with negative density skipped", row.line)
        return None
    if (density < 0.0).any():
        findings.add("negative density within rounding set to 0", row.line)
    try:
        spectrum = tabulated_from_hertz(frequency, np.maximum(density, 0.0), name=f"line {row.line}")
    except SpectrumError as error:
        findings.add(f"record skipped: {str(error).split(': ', 1)[-1]}", row.line)
        return None
    objection = objection_to(spectrum)
    if objection:
        findings.add(f"implausible record {'kept' if findings.accepts else 'skipped'}", row.line, objection)
    return spectrum if findings.accepts or not objection else None


def _number(path: Path, line: int, text: str) -> float:
    """Read a number; NaN is allowed here (it counts as missing), anything else that is not a number is refused."""
    if text.upper() in ("NAN", "MM"):
        return math.nan
    if not re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", text):
        raise SpectrumFileError(f"{path}: line {line}: {text!r} is not a number")
    return float(text)


def _time(path: Path, line: int, fields: Sequence[str]) -> datetime:
    """Read year (two or four digits), month, day, hour [, minute]; hour 24 is the next midnight."""
    try:
        year, month, day, hour, *minute = (int(text) for text in fields)
        year += 1900 if 50 <= year < 100 else 2000 if year < 50 else 0
        start = datetime(year, month, day, tzinfo=timezone.utc)
        return start + timedelta(hours=hour, minutes=minute[0] if minute else 0)
    except ValueError as error:
        raise SpectrumFileError(f"{path}: line {line}: {' '.join(fields)!r} is not a date: {error}") from error
