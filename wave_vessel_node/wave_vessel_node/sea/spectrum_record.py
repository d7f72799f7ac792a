"""Measured wave spectra: the records of a file, in order of time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta, timezone
from typing import NoReturn

from heave_node.files.plausible import ACCEPT, sea_question
from heave_node.numerics.arrays import Array

from wave_vessel_node.sea.spectra import TabulatedSpectrum


class SpectrumFileError(ValueError):
    """A spectrum file that cannot be used; the message names file, line and what was expected."""


@dataclass(frozen=True)
class SpectrumRecord:
    """One measured spectrum."""

    time: datetime  # of the observation, UTC
    spectrum: TabulatedSpectrum  # of the elevation


@dataclass(frozen=True)
class SpectrumFile:
    """What a file of spectra holds."""

    path: str  # as given
    records: tuple[SpectrumRecord, ...]  # in order of time
    warnings: tuple[str, ...]  # what was repaired or left out, one line each

    def nearest(self, time: str) -> SpectrumRecord:
        """Return the record nearest to `time`, ISO 8601, UTC where no zone is given.

        Raises SpectrumFileError for text that is not a time, and for a time more than a day before the first or after
        the last record.
        """
        try:
            requested = datetime.fromisoformat(time.replace("Z", "+00:00"))
        except ValueError as error:
            raise SpectrumFileError(f"{self.path}: {time!r} is not a time like 1996-06-14T18:00") from error
        if requested.tzinfo is None:
            requested = requested.replace(tzinfo=timezone.utc)
        record = min(self.records, key=lambda candidate: abs(candidate.time - requested))
        if abs(record.time - requested) > timedelta(days=1):
            first, last = self.records[0].time, self.records[-1].time
            raise SpectrumFileError(
                f"{self.path}: no record within a day of {time}: the file covers {first:%Y-%m-%d} to {last:%Y-%m-%d}"
            )
        return record


def tabulated_from_hertz(frequency: Array, density: Array, *, name: str) -> TabulatedSpectrum:
    """Return the spectrum of densities per hertz: S(omega) = S(f) / (2 pi).

    Parameters
    ----------
    frequency : [Hz], rising, shape (n,)
    density : [m^2/Hz], shape (n,)
    name : opens the message of an error

    Raises SpectrumError for numbers that are not a spectrum.
    """
    return TabulatedSpectrum(2.0 * math.pi * frequency, density / (2.0 * math.pi), name=name)


def objection_to(spectrum: TabulatedSpectrum) -> str:
    """Return what is implausible about a measured `spectrum` of a sea, in one line; "" where it is plausible."""
    return sea_question(spectrum.significant_wave_height, spectrum.zero_crossing_period, spectrum.peak_period)


def refuse_without_records(path: str, warnings: Sequence[str]) -> NoReturn:
    """Raise SpectrumFileError for the file at `path` without a usable record, with the `warnings` that say why."""
    why = "; ".join(warning.removeprefix(f"{path}: ") for warning in warnings) or "the file is empty"
    accept = f"; {ACCEPT} takes the figures as they are" if "plausible is" in why else ""
    raise SpectrumFileError(f"{path}: no usable spectrum: {why}{accept}")
