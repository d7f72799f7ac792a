"""Measured wave spectra from files: NDBC's text files, and what the library `wavespectra` reads."""

from __future__ import annotations

from pathlib import Path

from wave_vessel_node.sea.ndbc_files import read_ndbc
from wave_vessel_node.sea.spectrum_record import SpectrumFile, SpectrumFileError
from wave_vessel_node.sea.wavespectra_files import is_for_wavespectra, read_with_wavespectra


def read_spectra(path: str | Path, *, accept_implausible: bool = False) -> SpectrumFile:
    """Read the spectra of the file at `path`: NetCDF and SWAN's text by `wavespectra`, any other as NDBC's text.

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
