"""Shaping filters: white noise in, wave elevation out, as state space (thesis 6.3.1).

A form is a chain of second-order sections, normalised to the peak and the energy of the sea. Noise convention: see
`heave_node.numerics.linear_model` (one-sided spectra in rad/s, so white noise of unit density has intensity pi). Each
section is s^z / (s^2 + 2 zeta omega s + omega^2); zeros at the origin keep energy out of the low frequencies, where a
long cable resonates.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import NOISE_INTENSITY, LinearModel, linear_model

from wave_vessel_node.registries import AUTO, FILTER_FORMS
from wave_vessel_node.sea.spectra import Bretschneider, SpectrumError, WaveSpectrum


@dataclass(frozen=True)
class Section:
    """One pair of poles."""

    frequency: float  # natural frequency over that of the peak [-]
    damping: float  # damping ratio [-]


@dataclass(frozen=True)
class FilterForm:
    """H(s) = gain s^zeros N(s) / product of (s^2 + 2 zeta omega s + omega^2), normalised to omega_m = 1 and m_0 = 1."""

    gain: float  # of the normalised filter [-]
    zeros_at_origin: int  # number of zeros at s = 0
    sections: tuple[Section, ...]  # pairs of poles
    # free pairs of zeros, written like poles; N(s) is their product, 1 if there are none
    numerator: tuple[Section, ...] = ()

    def __post_init__(self) -> None:
        if self.zeros_at_origin + 2 * len(self.numerator) >= 2 * len(self.sections):
            raise ValueError("a shaping filter needs fewer zeros than poles")

    def model(self, peak: float, significant_wave_height: float) -> LinearModel:
        """Return the filter at the scale of a sea: s divided by the peak, gain (Hs/4) / sqrt(peak).

        Parameters
        ----------
        peak : peak frequency [rad/s]
        significant_wave_height : Hs [m]
        """
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


def sections_of(values: Sequence[float] | Array) -> tuple[Section, ...]:
    """Return the sections of a flat list of `values`: frequency, damping, frequency, damping, ..."""
    return tuple(Section(float(values[i]), float(values[i + 1])) for i in range(0, len(values), 2))


def _quadratic(section: Section) -> Array:
    return np.array([1.0, 2.0 * section.damping * section.frequency, section.frequency**2])


FOUR_STATE = FilterForm(0.8545, 2, (Section(0.9165, 0.2209), Section(1.4669, 0.3879)))
"""Four states, two zeros at the origin, fitted to Bretschneider's spectrum: relative L2 error 0.053."""

SIX_STATE = FilterForm(0.9334, 4, (Section(1.0549, 0.3116), Section(1.6703, 0.5113), Section(0.8031, 0.1952)))
"""Six states, four zeros at the origin, fitted to Bretschneider's spectrum: relative L2 error 0.011."""


def shaping_filter(spectrum: WaveSpectrum, form: str = AUTO, states: int = 6) -> LinearModel:
    """Return a filter whose output wave_elevation has about the given spectrum.

    Parameters
    ----------
    spectrum : of the sea
    form : one of FILTER_FORMS, or `auto`: `six_state` for a Bretschneider spectrum, else `fit`
    states : number of states of a fit, even, 4 or more

    Raises SpectrumError for an unknown form, or a spectrum without energy.
    """
    if spectrum.significant_wave_height <= 0.0:
        raise SpectrumError("a shaping filter needs a spectrum with energy: its significant wave height is 0")
    if form == AUTO:
        form = "six_state" if isinstance(spectrum, Bretschneider) and states == 6 else "fit"
    if form not in FILTER_FORMS:
        raise SpectrumError(f"there is no filter form {form!r}: use {', '.join((AUTO, *FILTER_FORMS))}")
    model: LinearModel = FILTER_FORMS[form].load()(spectrum, states)
    return model


def thesis_filter(spectrum: WaveSpectrum, _states: int = 6) -> LinearModel:
    """Return the filter of thesis Eq. 6.22-6.23 at the peak and height of `spectrum`, with the thesis's constants.

    Its relative L2 error is 71 %; it is kept to reproduce the thesis's numbers.

    S_0 = 1.25 / (4 omega_m) Hs^2 1.8861, omega_0 = 0.9538 omega_m. The matrices are the printed ones; their transfer
    function is sqrt(S_0) (s/omega_0)^2 / (1 + 1.414 s/omega_0 + (s/omega_0)^2)^3.
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


def four_state_filter(spectrum: WaveSpectrum, _states: int = 4) -> LinearModel:
    """Return FOUR_STATE at the peak and height of `spectrum`."""
    return FOUR_STATE.model(spectrum.peak_frequency, spectrum.significant_wave_height)


def six_state_filter(spectrum: WaveSpectrum, _states: int = 6) -> LinearModel:
    """Return SIX_STATE at the peak and height of `spectrum`."""
    return SIX_STATE.model(spectrum.peak_frequency, spectrum.significant_wave_height)
