"""Spectra of records against scipy's own Welch, known signals and Gaussian seas of known height."""

import math

import numpy as np
import pytest
from heave_node.numerics.spectral_estimate import (
    RecordTooShortError,
    estimate_spectrum,
    height_and_period,
    peak_frequency,
    resampled_spectra,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import welch

from tests.validation.record_statistics import degrees_of_freedom

DT = 0.5


def bretschneider(omega, height, period):
    """Thesis Eq. 6.20 with omega_m^4, written out."""
    peak = 2.0 * math.pi / period
    ratio = np.divide(peak, omega, out=np.full_like(omega, np.inf), where=omega > 0.0) ** 4
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(omega > 0.1 * peak, 0.3125 * height**2 * ratio / omega * np.exp(-1.25 * ratio), 0.0)


def gaussian_record(height, period, duration, seed):
    """A Gaussian sea by inverse FFT of random lines, shape (n,)."""
    generator = np.random.default_rng(seed)
    count = round(duration / DT)
    omega = 2.0 * math.pi * np.fft.rfftfreq(count, DT)
    sigma = np.sqrt(0.5 * bretschneider(omega, height, period) * omega[1])
    lines = sigma * (generator.standard_normal(omega.size) + 1j * generator.standard_normal(omega.size))
    return np.fft.irfft(lines, count) * count / math.sqrt(2.0)


@settings(max_examples=20)
@given(st.integers(0, 2**31), st.integers(200, 3000), st.floats(20.0, 90.0))
def test_the_density_is_that_of_scipys_welch(seed, count, segment):
    record = np.random.default_rng(seed).standard_normal(count) + 3.0
    if count * DT < 1.6 * segment:
        return
    estimate = estimate_spectrum(record, DT, segment=segment)
    size = 2 * (estimate.omega.size - 1)
    frequency, density = welch(record, fs=1.0 / DT, nperseg=size, detrend="constant")
    np.testing.assert_allclose(estimate.omega, 2.0 * math.pi * frequency, rtol=1e-12)
    np.testing.assert_allclose(estimate.density, density / (2.0 * math.pi), rtol=1e-9)


def test_white_noise_is_flat_with_the_scatter_of_its_degrees_of_freedom():
    estimate = estimate_spectrum(np.random.default_rng(0).standard_normal(200_000), DT, segment=100.0)
    inner = estimate.density[2:-1]  # below, the mean that is taken off each segment is missing
    # white noise of variance 1 over 0 to pi / DT
    assert inner.mean() == pytest.approx(DT / math.pi, rel=0.01)
    freedom = degrees_of_freedom(len(estimate.segments))
    assert inner.std() / inner.mean() == pytest.approx(math.sqrt(2.0 / freedom), rel=0.25)


def test_the_integral_over_a_sine_is_half_its_amplitude_squared():
    time = np.arange(4000) * DT
    estimate = estimate_spectrum(3.0 * np.sin(0.7 * time), DT, segment=200.0)
    assert np.trapezoid(estimate.density, estimate.omega) == pytest.approx(4.5, rel=1e-3)
    assert estimate.omega[np.argmax(estimate.density)] == pytest.approx(0.7, abs=estimate.omega[1])


def test_intervals_of_height_and_period_hold_the_truth_as_often_as_they_say():
    # 120 seas of half an hour, 95 %: 114 is the mean, 106 and 119 are 3.3 and 2 sigma of the binomial about it
    heights = periods = 0
    for seed in range(120):
        sea = height_and_period(gaussian_record(2.0, 8.0, 1800.0, seed), DT)
        low, high = sea.significant_height_interval
        heights += low < 2.0 < high
        low, high = sea.peak_period_interval
        periods += low < 8.0 < high
        assert low < sea.peak_period < high
    assert 106 <= heights <= 119
    assert 106 <= periods <= 119


def test_the_peak_period_has_no_bias():
    # 100 seas of half an hour scatter by 3 %, their mean by 0.3 %; three times that
    periods = [height_and_period(gaussian_record(2.0, 9.0, 1800.0, seed), DT).peak_period for seed in range(100)]
    assert np.mean(periods) == pytest.approx(9.0, rel=0.009)


def test_a_longer_record_says_more():
    widths = [
        np.ptp(height_and_period(gaussian_record(2.0, 8.0, duration, 1), DT).significant_height_interval)
        for duration in (1200.0, 10800.0)
    ]
    assert widths[1] == pytest.approx(widths[0] / 3.0, rel=0.3)


@pytest.mark.parametrize("period", [6.0, 9.0, 14.0])
def test_the_peak_of_a_smooth_spectrum_is_found(period):
    # fits of log S by a parabola were 2.5 % off: the spectrum falls steeper below its peak than above
    omega = np.linspace(0.2, 3.0, 120)
    found = peak_frequency(omega, bretschneider(omega, 2.0, period)[None])[0]
    assert found == pytest.approx(2.0 * math.pi / period, rel=1e-4)


def test_a_spectrum_without_energy_has_no_peak():
    assert math.isnan(peak_frequency(np.linspace(0.2, 3.0, 50), np.zeros((1, 50)))[0])


def test_spectra_drawn_anew_scatter_about_the_estimate_and_are_the_same_each_time():
    segments = np.random.default_rng(1).random((30, 5))
    drawn = resampled_spectra(segments)
    np.testing.assert_array_equal(drawn, resampled_spectra(segments))
    np.testing.assert_allclose(drawn.mean(axis=0), segments.mean(axis=0), rtol=0.05)


def test_a_record_too_short_is_refused_with_what_is_needed():
    with pytest.raises(RecordTooShortError, match=r"a record of 50 s is too short .* 150 s are needed"):
        estimate_spectrum(np.zeros(100), DT, segment=100.0)
    with pytest.raises(RecordTooShortError, match="400 s are needed"):
        height_and_period(np.zeros(700), DT)
