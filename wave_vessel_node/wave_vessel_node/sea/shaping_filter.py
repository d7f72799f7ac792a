"""Shaping filters: white noise in, wave elevation out, as state space (thesis 6.3.1)."""

from __future__ import annotations

import math

import numpy as np
from heave_node.numerics.linear_model import LinearModel

from wave_vessel_node.sea.filter_form import FilterForm, Section, wave_model
from wave_vessel_node.sea.spectra import Bretschneider, SpectrumError, WaveSpectrum
from wave_vessel_node.sea_registry import AUTO, FILTER_FORMS

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
