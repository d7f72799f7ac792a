"""Shaping filters: white noise in, wave elevation out, as state space (thesis 6.3.1).

Noise convention: see `heave_node.linear_model` (one-sided spectra in rad/s, so white noise of unit density has
intensity pi). A filter is a chain of second-order sections, each s^z / (s^2 + 2 zeta omega s + omega^2); zeros at the
origin keep energy out of the low frequencies, where a long cable resonates.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from heave_node.arrays import Array
from heave_node.linear_model import NOISE_INTENSITY, LinearModel, linear_model, output_sigma, output_spectrum
from numpy.typing import ArrayLike

from wave_vessel_node.sea.spectra import Bretschneider, SpectrumError, WaveSpectrum, cell_integrals

LEAK_QUANTILE = 1e-4
"""The leak of a filter is its energy below the frequency under which the spectrum has this fraction of its own
(Bretschneider: 0.61
omega_m)."""


@dataclass(frozen=True)
class Section:
    """One pair of poles: natural frequency [rad/s, or of the peak where normalised] and damping ratio."""

    frequency: float
    damping: float


@dataclass(frozen=True)
class FilterForm:
    """H(s) = gain s^zeros N(s) / product of (s^2 + 2 zeta omega s + omega^2), normalised to omega_m = 1 and m_0 = 1.

    `numerator` are free zero pairs, written like poles; N(s) is their product (1 if none).
    """

    gain: float
    zeros_at_origin: int
    sections: tuple[Section, ...]
    numerator: tuple[Section, ...] = ()

    def __post_init__(self) -> None:
        if self.zeros_at_origin + 2 * len(self.numerator) >= 2 * len(self.sections):
            raise ValueError("a shaping filter needs fewer zeros than poles")

    def density(self, omega: ArrayLike) -> Array:
        """Return |H(i omega)|^2."""
        s = 1j * np.asarray(omega, dtype=float)
        response = self.gain * s**self.zeros_at_origin
        for zero in self.numerator:
            response = response * (s**2 + 2.0 * zero.damping * zero.frequency * s + zero.frequency**2)
        for pole in self.sections:
            response = response / (s**2 + 2.0 * pole.damping * pole.frequency * s + pole.frequency**2)
        return np.asarray(np.abs(response) ** 2)

    def model(self, peak: float, significant_wave_height: float) -> LinearModel:
        """Return the filter at physical scale: s divided by `peak` [rad/s], gain (Hs/4) / sqrt(peak)."""
        numerator = np.zeros(2 * len(self.sections))
        polynomial = np.array([self.gain])
        for zero in self.numerator:
            polynomial = np.polymul(polynomial, _quadratic(zero))
        polynomial = np.concatenate((polynomial, np.zeros(self.zeros_at_origin)))
        numerator[: polynomial.size] = polynomial[::-1]  # ascending powers
        denominator = np.array([1.0])
        for pole in self.sections:
            denominator = np.polymul(denominator, _quadratic(pole))
        n = denominator.size - 1
        A = np.diag(np.ones(n - 1), 1)
        A[-1] = -denominator[:0:-1]
        B = np.zeros(n)
        B[-1] = 1.0
        # time in units of 1/peak: dx/dt = peak A x + peak B w', and white noise of unit density scales as sqrt(time)
        scale = 0.25 * significant_wave_height / math.sqrt(peak)
        return wave_model(peak * A, peak * B, scale * numerator)


def wave_model(A: Array, B: Array, C: Array) -> LinearModel:
    """Return the model of a shaping filter: states wave_0, wave_1, ..., output wave_elevation [m], noise waves.

    Parameters
    ----------
    A : shape (n, n)
    B : shape (n,); the noise that drives it has unit one-sided density in rad/s
    C : shape (n,)
    """
    return linear_model(
        A,
        states=tuple(f"wave_{index}" for index in range(len(A))),
        outputs={"wave_elevation": C},
        noises={"waves": math.sqrt(NOISE_INTENSITY) * B},
    )


def _quadratic(section: Section) -> Array:
    return np.array([1.0, 2.0 * section.damping * section.frequency, section.frequency**2])


def _sections(*pairs: tuple[float, float]) -> tuple[Section, ...]:
    return tuple(Section(*pair) for pair in pairs)


FOUR_STATE = FilterForm(0.8545, 2, _sections((0.9165, 0.2209), (1.4669, 0.3879)))
"""Four states, two zeros at the origin, fitted to Bretschneider's spectrum: relative L2 error 0.053."""

SIX_STATE = FilterForm(0.9334, 4, _sections((1.0549, 0.3116), (1.6703, 0.5113), (0.8031, 0.1952)))
"""Six states, four zeros at the origin, fitted to Bretschneider's spectrum: relative L2 error 0.011."""


def thesis_filter(spectrum: WaveSpectrum) -> LinearModel:
    """Return the thesis's filter, Eq. 6.22-6.23, with its constants (poor: 71 % relative L2 error; kept to reproduce
    its numbers).

    S_0 = 1.25 / (4 omega_m) Hs^2 1.8861, omega_0 = 0.9538 omega_m. The matrices are the printed ones; their transfer
    function is
    sqrt(S_0) (s/omega_0)^2 / (1 + 1.414 s/omega_0 + (s/omega_0)^2)^3.
    """
    peak = spectrum.peak_frequency
    natural = 0.9538 * peak
    density = 1.25 / (4.0 * peak) * spectrum.significant_wave_height**2 * 1.8861
    pair = np.array([[0.0, 1.0], [-(natural**2), -1.414 * natural]])
    A = np.zeros((6, 6))
    for first in (0, 2, 4):
        A[first : first + 2, first : first + 2] = pair
    A[1, 3] = A[3, 5] = natural**2
    B, C = np.zeros(6), np.zeros(6)
    B[5] = 1.0
    C[0] = math.sqrt(density)
    return wave_model(A, B, C)


def shaping_filter(spectrum: WaveSpectrum, form: str = "auto", states: int = 6) -> LinearModel:
    """Return a filter whose output under unit white noise (intensity pi) has about the spectrum of `spectrum`.

    Parameters
    ----------
    form : `thesis` (Eq. 6.22), `four_state`, `six_state` (constants for Bretschneider), `fit` (fitted to `spectrum`,
    four zeros at the
        origin), or `auto`: `six_state` for a Bretschneider spectrum, else `fit`.
    states : number of states of a fit, even, 6 or more

    Raises SpectrumError for an unknown form, or a spectrum without energy.
    """
    if spectrum.significant_wave_height <= 0.0:
        raise SpectrumError("a shaping filter needs a spectrum with energy: its significant wave height is 0")
    if form == "auto":
        form = "six_state" if isinstance(spectrum, Bretschneider) and states == 6 else "fit"
    if form == "thesis":
        return thesis_filter(spectrum)
    fixed = {"four_state": FOUR_STATE, "six_state": SIX_STATE}
    if form in fixed:
        return fixed[form].model(spectrum.peak_frequency, spectrum.significant_wave_height)
    if form != "fit":
        raise SpectrumError(f"there is no filter form {form!r}: use auto, thesis, four_state, six_state or fit")
    from wave_vessel_node.sea.filter_fit import fit_filter  # noqa: PLC0415

    return fit_filter(spectrum, states).system


@dataclass(frozen=True)
class FilterQuality:
    """How well a filter stands for a spectrum.

    Attributes
    ----------
    relative_error : sqrt(integral (S_filter - S)^2 / integral S^2)
    variance_ratio : m_0 of the filter over that of the spectrum
    leak : energy of the filter below the spectrum's own band (see `low_band_edge`) over m_0; the spectrum itself has
    1e-4
    """

    relative_error: float
    variance_ratio: float
    leak: float


def filter_quality(system: LinearModel, spectrum: WaveSpectrum) -> FilterQuality:
    """Compare the spectrum of `system` with `spectrum`, by quadrature and (variance) the Lyapunov equation."""
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


def sections_of(values: Sequence[float] | Array) -> tuple[Section, ...]:
    """Read sections from a flat list frequency, damping, frequency, damping, ..."""
    return tuple(Section(float(values[i]), float(values[i + 1])) for i in range(0, len(values), 2))
