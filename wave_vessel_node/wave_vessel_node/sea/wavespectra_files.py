"""Spectra from files that the library `wavespectra` reads (extra `wavespectra`): SWAN, WW3, ERA5, its own NetCDF."""

from __future__ import annotations

from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import numpy as np
from heave_node.extras import how_to_install

from wave_vessel_node.sea.spectra import SpectrumError
from wave_vessel_node.sea.spectrum_record import SpectrumFile, SpectrumFileError, SpectrumRecord, tabulated_from_hertz

_READERS = {
    ".swn": ("read_swan",),
    ".spec": ("read_swan",),
    ".nc": ("read_wavespectra", "read_ww3", "read_ncswan", "read_era5"),
    ".nc4": ("read_wavespectra", "read_ww3", "read_ncswan", "read_era5"),
}
ENDINGS = tuple(_READERS)


def read_with_wavespectra(path: Path) -> SpectrumFile:
    """Read the file at `path` by `wavespectra`; directions are summed, of several sites the first is taken and said.

    Raises SpectrumFileError when the library is not installed, cannot read the file, or finds no usable spectrum.
    """
    try:
        import wavespectra  # noqa: PLC0415  an extra: only needed for these files
    except ImportError as error:
        raise SpectrumFileError(f"{path}: reading it needs wavespectra; {how_to_install('wavespectra')}") from error
    dataset, refusals = None, []
    for name in _READERS[path.suffix.lower()]:
        try:
            dataset = getattr(wavespectra, name)(str(path))
            break
        except Exception as error:
            refusals.append(f"{name}: {str(error).splitlines()[0] if str(error) else type(error).__name__}")
    if dataset is None:
        raise SpectrumFileError(f"{path}: wavespectra cannot read it ({'; '.join(refusals)})")
    return _records(path, dataset)


def _records(path: Path, dataset: Any) -> SpectrumFile:
    warnings: list[str] = []
    density = dataset.efth.spec.oned() if "dir" in dataset.efth.dims else dataset.efth
    for dimension in [name for name in density.dims if name not in ("time", "freq")]:
        if density.sizes[dimension] > 1:
            warnings.append(f"{path}: has {density.sizes[dimension]} entries along {dimension}: the first is used")
        density = density.isel({dimension: 0})
    if "time" not in density.dims:
        density = density.expand_dims("time")
    values = density.transpose("time", "freq").to_numpy()
    frequency = density["freq"].to_numpy().astype(float)
    times = density["time"].to_numpy() if "time" in density.coords else np.zeros(len(values), "datetime64[s]")
    records = []
    for number, (time, row) in enumerate(zip(times, values, strict=True)):
        try:
            spectrum = tabulated_from_hertz(frequency, np.asarray(row, dtype=float), name=f"record {number}")
        except SpectrumError as error:
            warnings.append(f"{path}: skipped: {error}")
            continue
        seconds = np.datetime64(time, "s").astype(int) if np.issubdtype(times.dtype, np.datetime64) else 0
        records.append(SpectrumRecord(datetime.fromtimestamp(int(seconds), tz=timezone.utc), spectrum))
    if not records:
        raise SpectrumFileError(f"{path}: no usable spectrum: {'; '.join(warnings) or 'the file is empty'}")
    return SpectrumFile(str(path), tuple(sorted(records, key=lambda record: record.time)), tuple(warnings))
