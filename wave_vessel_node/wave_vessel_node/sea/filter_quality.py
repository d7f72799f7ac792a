"""How well a shaping filter models a spectrum."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel, output_sigma, output_spectrum

from wave_vessel_node.sea.spectra import WaveSpectrum, cell_integrals

LEAK_QUANTILE = 1e-4
"""The leak of a filter is its energy below the frequency under which the spectrum has this fraction of its own
(Bretschneider: 0.61 omega_m).
"""


@dataclass(frozen=True)
class FilterQuality:
    """How well a filter models a spectrum."""

    relative_error: float  # sqrt(integral (S_filter - S)^2 / integral S^2) [-]
    variance_ratio: float  # m_0 of the filter over that of the spectrum [-]
    # energy of the filter below the spectrum's own band (see `low_band_edge`) over m_0; the spectrum itself has 1e-4
    leak: float


def filter_quality(system: LinearModel, spectrum: WaveSpectrum) -> FilterQuality:
    """Compare the spectrum of a filter with the one that it models.

    Parameters
    ----------
    system : shaping filter with the output wave_elevation
    spectrum : of the sea

    By quadrature; the variance by the Lyapunov equation.
    """
    edges = spectrum.edges

    def density(omega: Array) -> Array:
        return output_spectrum(system, "wave_elevation", omega)

    def squared_error(omega: Array) -> Array:
        return np.asarray((density(omega) - spectrum.density(omega)) ** 2)

    error = cell_integrals(squared_error, edges).sum()
    norm = cell_integrals(lambda omega: spectrum.density(omega) ** 2, edges).sum()
    low = np.linspace(1e-4, 1.0, 600) * low_band_edge(spectrum)
    m0 = spectrum.moment(0)
    return FilterQuality(
        relative_error=math.sqrt(error / norm),
        variance_ratio=output_sigma(system)["wave_elevation"] ** 2 / m0,
        leak=float(cell_integrals(density, low).sum()) / m0,
    )


def low_band_edge(spectrum: WaveSpectrum) -> float:
    """Return the frequency [rad/s] below which the spectrum has 1e-4 of its energy."""
    cumulative = np.cumsum(cell_integrals(spectrum.density, spectrum.edges))
    return float(spectrum.edges[1:][np.searchsorted(cumulative, LEAK_QUANTILE * cumulative[-1])])
