"""The form of a shaping filter: a chain of second-order sections, normalised to the peak and the energy of the sea.

Noise convention: see `heave_node.numerics.linear_model` (one-sided spectra in rad/s, so white noise of unit density has
intensity pi). Each section is s^z / (s^2 + 2 zeta omega s + omega^2); zeros at the origin keep energy out of the low
frequencies, where a long cable resonates.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import NOISE_INTENSITY, LinearModel, linear_model


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
