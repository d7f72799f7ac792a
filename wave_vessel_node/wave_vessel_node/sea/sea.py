"""The sea that the parameters name: its spectrum, and what is published of it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from heave_node.numerics.arrays import Array

from wave_vessel_node.parameters import SeaParameters, WaveVesselParameters
from wave_vessel_node.registries import SPECTRA, SPECTRUM_FILE
from wave_vessel_node.sea.spectra import WaveSpectrum
from wave_vessel_node.sea.spectrum_files import read_spectra


def named_spectrum(sea: SeaParameters) -> WaveSpectrum:
    """Return the spectrum of SPECTRA that `sea` names, with its numbers. Raises SpectrumError where it cannot be."""
    spectrum: WaveSpectrum = SPECTRA[sea.spectrum].load().from_parameters(sea)
    return spectrum


def build_spectrum(parameters: WaveVesselParameters, warnings: list[str]) -> WaveSpectrum:
    """Return the spectrum that the parameters name, measured ones included.

    Parameters
    ----------
    parameters : name the spectrum, or its file and record
    warnings : what was repaired in a file is added here

    Raises SpectrumError or SpectrumFileError where it cannot be: a file that is missing or broken.
    """
    if parameters.spectrum != SPECTRUM_FILE:
        return named_spectrum(parameters)
    file = read_spectra(parameters.spectrum_file, accept_implausible=parameters.accept_implausible)
    warnings.extend(file.warnings)
    record = file.nearest(parameters.spectrum_time) if parameters.spectrum_time else file.records[0]
    return record.spectrum


@dataclass(frozen=True)
class SeaState:
    """The sea as it is published; see the message of the same name."""

    spectrum: str  # name of the spectrum or source
    significant_wave_height: float  # [m]
    peak_period: float  # [s]
    zero_crossing_period: float  # [s]
    peak_enhancement: float  # gamma of JONSWAP, 1 for other spectra [-]
    heading: float  # direction the waves travel to, from world x, anticlockwise [rad]
    spreading: float  # exponent s of cos^2s [-]; 0 is long-crested
    seed: int  # of the realisation
    angular_frequency: Array = field(default_factory=lambda: np.empty(0))  # [rad/s], may be empty
    spectral_density: Array = field(default_factory=lambda: np.empty(0))  # target at these frequencies [m^2 s/rad]


def describe_sea(
    parameters: WaveVesselParameters, spectrum: WaveSpectrum | None, nominal: tuple[float, float], seed: int
) -> SeaState:
    """Return what is published of the sea.

    Parameters
    ----------
    parameters : name the spectrum and where it comes from
    spectrum : None for sources that have none
    nominal : significant wave height [m] and period [s] of a source without a spectrum, NaN where not known
    seed : of the realisation
    """
    if spectrum is None:
        height, period = nominal
        return SeaState(parameters.boom_tip_source, height, period, period, 1.0, parameters.direction, 0.0, seed)
    grid = np.linspace(0.02, 4.0, 200) * spectrum.peak_frequency
    has_energy = spectrum.moment(0) > 0.0
    return SeaState(
        spectrum="measured" if parameters.spectrum == SPECTRUM_FILE else parameters.spectrum,
        significant_wave_height=spectrum.significant_wave_height,
        peak_period=spectrum.peak_period,
        zero_crossing_period=spectrum.zero_crossing_period if has_energy else spectrum.peak_period,
        peak_enhancement=spectrum.peak_enhancement,
        heading=parameters.direction,
        spreading=parameters.spreading.exponent,
        seed=seed,
        angular_frequency=grid,
        spectral_density=spectrum.density(grid),
    )
