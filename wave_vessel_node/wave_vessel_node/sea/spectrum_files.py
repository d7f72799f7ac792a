"""Measured wave spectra from files: NDBC's text files, and what the library `wavespectra` reads.

That is NetCDF, and text of models and buoys. Which reader a file needs is known by the names of its variables, or by
how it begins; what comes out is checked. Wave models end at a frequency beyond which they count on a tail of f^-5 (as
in their own significant wave heights); it is added here. Measured spectra (NDBC, buoys) have none.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Collection
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from heave_node.extras import how_to_install
from heave_node.numerics.arrays import Array

from wave_vessel_node.sea.ndbc_files import read_ndbc
from wave_vessel_node.sea.spectra import SpectrumError, TabulatedSpectrum
from wave_vessel_node.sea.spectrum_record import (
    SpectrumFile,
    SpectrumFileError,
    SpectrumRecord,
    objection_to,
    refuse_without_records,
    tabulated_from_hertz,
)

_NETCDF = (b"\x89HDF", b"CDF\x01", b"CDF\x02", b"CDF\x05")
_ENDINGS = (".nc", ".nc4")
_CONVENTIONS = (
    ("WAVEWATCH III", "read_ww3", {"efth", "frequency"}),
    ("wavespectra", "read_wavespectra", {"efth", "freq"}),
    ("SWAN", "read_ncswan", {"density", "frequency"}),
    ("ERA5", "read_era5", {"d2fd"}),
    ("WWM", "read_wwm", {"AC", "SPSIG"}),
    ("NDBC", "read_ndbc", {"spectral_wave_density"}),
    ("NDBC (CDIP)", "read_ndbc", {"waveEnergyDensity"}),
)
"""Maker of the files, the library's reader, and the variables by which they are known."""
_ANGLES = {
    "read_ww3": ("efth", "rad"),
    "read_wavespectra": ("efth", "deg"),
    "read_ncswan": ("density", "rad"),
    "read_era5": ("d2fd", "rad"),
}
"""Variable of the densities, and the unit of angle that the reader takes them to be over, whatever the file says."""
_TEXTS = (
    ("read_swan", ("SWAN",), ""),
    ("read_ww3_station", ("'WAVEWATCH III SPECTRA'",), ""),
    ("read_triaxys", ("TRIAXYS BUOY DATA REPORT", "TRIAXYS BUOY REPORT"), ""),
    ("read_spotter", ('"spotterId"', '"varianceDensity"', "varianceDensity_"), ""),
    ("read_datawell", (), ".spt"),
)
"""The library's reader of each text, words of which one is in its first bytes, and the ending that it is known by."""
_FIRST_BYTES = 65536
"""Of a text, in which those words stand: a Spotter's headings name all its frequencies."""
_OPTIONS: dict[str, dict[str, Any]] = {
    "read_ndbc": {"directional": False},
    "read_spotter": {"dd": None},
    "read_datawell": {"dd": None},
}
_MEASURED = ("read_ndbc", "read_triaxys", "read_spotter", "read_datawell")
"""Readers of what was measured, which has no tail."""
_OWN_HEIGHTS = ("hs", "HS", "hsig")
"""Variables in which a file states its own significant wave heights [m]."""
_LARGEST_DIFFERENCE = 0.3
"""Heights of the spectra and of the file may differ by this share: the file's count what is beyond its frequencies."""
_TAIL_FROM, _TAIL = 0.333, np.geomspace(1.0, 3.0, 25)[1:]
"""A model's spectrum that ends above the one [Hz] goes on as f^-5 to these multiples of its end."""
_MISSING = 0.1
"""Share of a record's densities that may be missing, which its neighbours then fill."""


@dataclass(frozen=True)
class _Table:
    """The spectra of one site."""

    frequency: Array  # rising [Hz], shape (f,)
    density: Array  # [m^2/Hz], shape (t, f); NaN where it is missing
    times: Array  # of the spectra, shape (t,)
    has_tail: bool  # they go on beyond their frequencies, as those of a wave model

    def spectrum(self, number: int) -> TabulatedSpectrum:
        """Return spectrum `number`, missing densities filled from their neighbours; raise SpectrumError."""
        good = np.isfinite(self.density[number])
        if good.mean() < 1.0 - _MISSING:
            raise SpectrumError(f"record {number}: {int((~good).sum())} of {good.size} densities are missing")
        frequency, density = self.frequency[good], self.density[number, good]
        if self.has_tail and frequency[-1] > _TAIL_FROM:
            density = np.append(density, density[-1] * _TAIL**-5.0)
            frequency = np.append(frequency, frequency[-1] * _TAIL)
        return tabulated_from_hertz(frequency, density, name=f"record {number}")


def is_for_wavespectra(path: Path) -> bool:
    """Return whether the file at `path` is NetCDF, or a text that the library knows, by its first bytes or its name."""
    return _is_netcdf(path) or path.suffix.lower() in _ENDINGS or bool(_text_reader(path))


def _text_reader(path: Path) -> str:
    """Return the name of the library's reader for the text at `path`; "": none."""
    with path.open("rb") as file:
        begin = file.read(_FIRST_BYTES).decode("ascii", "replace").lstrip()
    for name, words, ending in _TEXTS:
        is_swan = name == "read_swan"
        has_word = begin.upper().startswith(words) if is_swan else any(word in begin for word in words)
        if has_word or (ending and path.suffix.lower() == ending):
            return name
    return ""


def read_with_wavespectra(path: Path, *, accept_implausible: bool = False) -> SpectrumFile:
    """Read the file at `path` by `wavespectra`; directions are summed, of several sites the first is taken and said.

    Parameters
    ----------
    path : of the file
    accept_implausible : keep implausible records, which else are left out; both are in the warnings

    Raises SpectrumFileError when the library is not installed, cannot read the file, or finds no usable spectrum.
    """
    try:
        import wavespectra  # noqa: PLC0415  an extra: only needed for these files
        import xarray  # noqa: PLC0415
    except ImportError as error:
        raise SpectrumFileError(f"{path}: reading it needs wavespectra; {how_to_install('wavespectra')}") from error
    heights, angle = None, 1.0
    try:
        _refuse_cut(path)
        if path.suffix.lower() in _ENDINGS or _is_netcdf(path):
            with xarray.open_dataset(path) as opened:
                name = _reader_of(path, set(opened.variables) | set(opened.dims))
                angle = _angle_factor(name, opened)
                heights = next((opened[own].load() for own in _OWN_HEIGHTS if own in opened), None)
        else:
            name = _text_reader(path)
        with tempfile.TemporaryDirectory() as folder:
            whole, left_out = _with_spectra(path, name, Path(folder))
            dataset = getattr(wavespectra, name)(str(whole), **_options(path, name))
            frequency, density, times, warnings = _one_site(path, dataset)
        warnings += left_out
        if angle != 1.0:
            warnings.append(f"{path}: densities taken per {'degree' if angle > 1.0 else 'radian'}, as their unit says")
    except SpectrumFileError:
        raise
    except Exception as error:  # the library and its backends raise what they like
        first = (str(error) or type(error).__name__).splitlines()[0]
        raise SpectrumFileError(f"{path}: wavespectra cannot read it: {first}") from error
    table = _Table(frequency, angle * density, times, has_tail=name not in _MEASURED)
    records = _records(path, table, warnings, accept_implausible)
    _compare(path, records, heights, warnings)
    return SpectrumFile(str(path), tuple(sorted(records, key=lambda record: record.time)), tuple(warnings))


def _with_spectra(path: Path, name: str, folder: Path) -> tuple[Path, list[str]]:
    """Return the file of a reader, `name`, and what was left out: of a Spotter's table at `path` a copy in a `folder`.

    Its records of heights alone have a dash for each frequency, which the library refuses.
    """
    if name != "read_spotter":
        return path, []
    rows = path.read_bytes().splitlines(keepends=True)
    kept = [row for row in rows if b",-,-," not in row]
    if len(kept) == len(rows):
        return path, []
    (folder / path.name).write_bytes(b"".join(kept))
    return folder / path.name, [f"{path}: {len(rows) - len(kept)} records without a spectrum left out"]


def _options(path: Path, name: str) -> dict[str, Any]:
    """Return the options of a reader, by its `name`, for the file at `path`."""
    if name != "read_spotter":
        return _OPTIONS.get(name, {})
    with path.open("rb") as file:
        is_json = file.read(64).lstrip().startswith(b"{")
    return {**_OPTIONS[name], "filetype": "json" if is_json else "csv"}


def _is_netcdf(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(4).startswith(_NETCDF)


def _refuse_cut(path: Path) -> None:
    """Raise SpectrumFileError for a classic NetCDF file that ends too early: its library reads zeros from there on."""
    with path.open("rb") as file:
        if file.read(4) not in (b"CDF\x01", b"CDF\x02"):
            return
    try:
        with scipy.io.netcdf_file(str(path), mmap=False):
            pass
    except Exception as error:  # it has no class of its own for a file without an end
        raise SpectrumFileError(f"{path}: is cut short or damaged: copy it again") from error


def _angle_factor(reader: str, dataset: Any) -> float:
    """Return by what the densities that a `reader` makes of a `dataset` are multiplied to be per degree."""
    variable, taken = _ANGLES.get(reader, ("", ""))
    unit = str(dataset[variable].attrs.get("units", "")).lower() if variable else ""
    stated = "rad" if "rad" in unit else "deg" if "deg" in unit else taken
    if stated == taken:
        return 1.0
    return math.degrees(1.0) if stated == "deg" else math.radians(1.0)


def _reader_of(path: Path, names: Collection[Any]) -> str:
    """Return the name of the library's reader for a file with the variables `names`."""
    for _, reader, needed in _CONVENTIONS:
        if needed <= set(names):
            return reader
    found = ", ".join(sorted(map(str, names))) or "none"
    makers = "; ".join(f"{maker}: {', '.join(sorted(needed))}" for maker, _, needed in _CONVENTIONS)
    raise SpectrumFileError(
        f"{path}: has no wave spectra of a known kind: its variables are {found}, expected ({makers})"
    )


def _one_site(path: Path, dataset: Any) -> tuple[Array, Array, Array, list[str]]:
    """Return frequency [Hz], density [m^2/Hz] (time, frequency), times and warnings of the first site."""
    if "efth" not in dataset or "freq" not in dataset["efth"].dims:
        raise SpectrumFileError(f"{path}: wavespectra finds no density over frequency in it")
    warnings: list[str] = []
    density = dataset["efth"]
    for dimension in [name for name in density.dims if name not in ("time", "freq", "dir")]:
        if density.sizes[dimension] > 1:
            warnings.append(f"{path}: has {density.sizes[dimension]} entries along {dimension}: the first is used")
        density = density.isel({dimension: 0})
    if "time" not in density.dims:
        density = density.expand_dims("time")
    if "dir" in density.dims:
        values = density.transpose("time", "freq", "dir").to_numpy().astype(float)
        values = values @ _direction_weights(path, density["dir"].to_numpy().astype(float))
    else:
        values = density.transpose("time", "freq").to_numpy().astype(float)
    frequency = density["freq"].to_numpy().astype(float)
    order = np.argsort(frequency)
    order = order[frequency[order] > 0.0]  # a density at frequency 0 is no wave
    times = density["time"].to_numpy() if "time" in density.coords else np.zeros(len(values), "datetime64[s]")
    return frequency[order], values[:, order], times, warnings


def _direction_weights(path: Path, direction: Array) -> Array:
    """Return the width of each direction of a rose [deg]: half the way to both neighbours.

    A direction that is there twice counts once; a rose that is not closed has no width across its gap.
    """
    unique, first = np.unique(np.round(np.mod(direction, 360.0), 6), return_index=True)
    if unique.size < 2 or not np.isfinite(direction).all():
        raise SpectrumFileError(f"{path}: has {unique.size} directions: a spectrum over direction needs 2 at least")
    gaps = np.diff(np.append(unique, unique[0] + 360.0))
    usual = float(np.median(gaps))
    gaps = np.where(gaps > 1.9 * usual, usual, gaps)
    weights = np.zeros(direction.size)
    weights[first] = 0.5 * (gaps + np.roll(gaps, 1))
    return weights


def _records(path: Path, table: _Table, warnings: list[str], accept: bool) -> list[SpectrumRecord]:
    """Return the usable records of a table; what is left out goes into the warnings."""
    records, implausible = [], []
    for number, time in enumerate(table.times):
        try:
            spectrum = table.spectrum(number)
        except SpectrumError as error:
            warnings.append(f"{path}: skipped: {error}")
            continue
        objection = objection_to(spectrum)
        if objection:
            implausible.append(f"record {number}: {objection}")
        if accept or not objection:
            seconds = np.datetime64(time, "s").astype(int) if np.issubdtype(table.times.dtype, np.datetime64) else 0
            records.append(SpectrumRecord(datetime.fromtimestamp(int(seconds), tz=timezone.utc), spectrum))
    if implausible:
        what = "kept" if accept else "skipped"
        warnings.append(f"{path}: {len(implausible)} implausible records {what}, the first {implausible[0]}")
    if not records:
        refuse_without_records(str(path), warnings)
    return records


def _compare(path: Path, records: list[SpectrumRecord], heights: Any, warnings: list[str]) -> None:
    """Warn where the height of the first record is not the one that the file itself states."""
    stated = np.asarray(heights, dtype=float).ravel() if heights is not None else np.empty(0)
    first = records[0].spectrum.significant_wave_height
    if stated.size and stated[0] > 0.05 and abs(first / stated[0] - 1.0) > _LARGEST_DIFFERENCE:
        warnings.append(
            f"{path}: the first spectrum has a significant wave height of {first:.3g} m, the file states "
            f"{stated[0]:.3g} m: another unit or convention of directions?"
        )


def read_spectra(path: str | Path, *, accept_implausible: bool = False) -> SpectrumFile:
    """Read the spectra of the file at `path`: NetCDF and known text by `wavespectra`, any other as NDBC's text.

    Parameters
    ----------
    path : of the file; what it is shows in its first bytes, not in its name
    accept_implausible : keep implausible records (`heave_node.files.plausible`), which else are left out

    Raises SpectrumFileError when the file is missing, of no known format, truncated within its header, or holds no
    usable record.
    """
    path = Path(path)
    if not path.is_file():
        raise SpectrumFileError(f"{path}: no such file")
    reader = read_with_wavespectra if is_for_wavespectra(path) else read_ndbc
    return reader(path, accept_implausible=accept_implausible)
