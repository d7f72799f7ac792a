"""The sea that the parameters name: its spectrum, and what is published of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from heave_node.arrays import Array

from wave_vessel_node.parameters import WaveVesselParameters
from wave_vessel_node.sea.spectra import (
    Bretschneider,
    Jonswap,
    OchiHubble,
    OchiHubbleSystem,
    WaveSpectrum,
    pierson_moskowitz,
)
from wave_vessel_node.sea.spectrum_files import read_spectra


def build_spectrum(parameters: WaveVesselParameters, warnings: list[str] | None = None) -> WaveSpectrum:
    """Return the spectrum the parameters name; what was repaired in a file is added to `warnings`.

    Raises SpectrumError or SpectrumFileError when it cannot be (a file that is missing or broken, a record beyond its
    end).
    """
    height, period = parameters.significant_wave_height, parameters.peak_period
    if parameters.spectrum == "bretschneider":
        return Bretschneider(height, period)
    if parameters.spectrum == "pierson_moskowitz":
        return pierson_moskowitz(height)
    if parameters.spectrum == "jonswap":
        return Jonswap(height, period, parameters.peak_enhancement)
    if parameters.spectrum == "ochi_hubble":
        swell = parameters.swell
        return OchiHubble(
            OchiHubbleSystem(height, period, parameters.shape),
            OchiHubbleSystem(swell.significant_wave_height, swell.peak_period, swell.shape),
        )
    file = read_spectra(parameters.spectrum_file)
    if warnings is not None:
        warnings.extend(file.warnings)
    if parameters.spectrum_time:
        return file.nearest(parameters.spectrum_time).spectrum
    return file.select(parameters.spectrum_record).spectrum


@dataclass(frozen=True)
class SeaState:
    """The sea as it is published; see the message of the same name.

    Attributes
    ----------
    spectrum : name of the spectrum or source
    significant_wave_height [m], peak_period, zero_crossing_period [s], peak_enhancement [-]
    heading : direction the waves travel to [rad]; spreading : exponent of cos^2s, 0 long-crested
    angular_frequency [rad/s], spectral_density [m^2 s/rad] : the target, may be empty
    """

    spectrum: str
    significant_wave_height: float
    peak_period: float
    zero_crossing_period: float
    peak_enhancement: float
    heading: float
    spreading: float
    seed: int
    angular_frequency: Array = field(default_factory=lambda: np.empty(0))
    spectral_density: Array = field(default_factory=lambda: np.empty(0))


def describe_sea(parameters: WaveVesselParameters, spectrum: WaveSpectrum | None, seed: int) -> SeaState:
    """Return what is published of the sea; `spectrum` is None for sources that have none (regular, file)."""
    if spectrum is None:
        regular = parameters.boom_tip_source == "regular"
        height = 2.0 * math.sqrt(2.0) * abs(parameters.amplitude[2]) if regular else math.nan
        period = parameters.period if regular else math.nan
        return SeaState(parameters.boom_tip_source, height, period, period, 1.0, parameters.direction, 0.0, seed)
    grid = np.linspace(0.02, 4.0, 200) * spectrum.peak_frequency
    energy = spectrum.moment(0) > 0.0
    name = "measured" if parameters.spectrum == "file" else parameters.spectrum
    return SeaState(
        spectrum=name,
        significant_wave_height=spectrum.significant_wave_height,
        peak_period=spectrum.peak_period,
        zero_crossing_period=spectrum.zero_crossing_period if energy else spectrum.peak_period,
        peak_enhancement=parameters.peak_enhancement if name == "jonswap" else 1.0,
        heading=parameters.direction,
        spreading=parameters.spreading.exponent,
        seed=seed,
        angular_frequency=grid,
        spectral_density=spectrum.density(grid),
    )
