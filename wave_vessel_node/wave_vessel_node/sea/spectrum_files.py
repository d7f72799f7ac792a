"""Measured wave spectra from files: NDBC's text files, and what the library `wavespectra` reads."""

from __future__ import annotations

from pathlib import Path

from wave_vessel_node.sea.ndbc_files import read_ndbc
from wave_vessel_node.sea.spectrum_record import SpectrumFile, SpectrumFileError
from wave_vessel_node.sea.wavespectra_files import ENDINGS, read_with_wavespectra


def read_spectra(path: str | Path) -> SpectrumFile:
    """Read the spectra of the file at `path`, by its ending: .nc, .spec and .swn by `wavespectra`, any other as NDBC's.

    Raises SpectrumFileError when the file is missing, of no known format, truncated within its header, or holds no
    usable record.
    """
    path = Path(path)
    if not path.is_file():
        raise SpectrumFileError(f"{path}: no such file")
    return read_with_wavespectra(path) if path.suffix.lower() in ENDINGS else read_ndbc(path)
