"""Three hours of each kind of sea: its spectrum, height and periods against the target, within confidence bands.

The estimate is Welch's (Hann, half overlapping); its expectation is the target seen through the window, its scatter is
chi-square with 36 K^2 / (19 K - 1) degrees of freedom for K segments.
"""

from pathlib import Path

import numpy as np
import pytest
from heave_node.numerics.linear_model import output_spectrum
from heave_node.numerics.randomness import random_stream
from heave_node.numerics.spectral_estimate import estimate_spectrum
from scipy.stats import binom, chi2
from wave_vessel_node.sea.realisation import HarmonicSum, draw_components
from wave_vessel_node.sea.shaping_filter import shaping_filter
from wave_vessel_node.sea.spectra import (
    Bretschneider,
    Jonswap,
    OchiHubble,
    OchiHubbleSystem,
    PiersonMoskowitz,
    WaveSpectrum,
)
from wave_vessel_node.sea.spectrum_files import read_spectra
from wave_vessel_node.sources.filtered import FilterSource

from tests.validation.record_statistics import degrees_of_freedom, record_statistics

ROOT = Path(__file__).parents[2]
SAMPLE = ROOT / "wave_vessel_node" / "test" / "data" / "real_time.data_spec"
MEASURED = ROOT.parent / "shared" / "data" / "waves"
DURATION, DT, SEGMENT = 10800.0, 0.5, 180.0

SEAS = {
    "bretschneider": Bretschneider(3.0, 10.0),
    "pierson_moskowitz": PiersonMoskowitz.of_height(3.0),
    "jonswap": Jonswap(3.0, 10.0),
    "ochi_hubble": OchiHubble(OchiHubbleSystem(1.5, 8.0), OchiHubbleSystem(1.0, 16.5, 3.0)),
    "file": read_spectra(SAMPLE).records[0].spectrum,
}


def elevation(sea: WaveSpectrum, seed: int = 1, count: int = 800) -> np.ndarray:
    components = draw_components(sea, count, random_stream(seed, "validation"))
    harmonics = HarmonicSum(components.frequency, components.amplitude * np.exp(1j * components.phase), DT)
    return harmonics.at(range(1, round(DURATION / DT) + 1))[:, 0, 0]


def through_window(density, omega: np.ndarray) -> np.ndarray:
    """Return the expectation of Welch's estimate at `omega` for a target `density`."""
    size = round(SEGMENT / DT)
    window = np.hanning(size + 1)[:-1]
    offset = np.linspace(-0.15, 0.15, 301)
    kernel = np.abs(np.exp(-1j * np.outer(offset, np.arange(size) * DT)) @ window) ** 2
    kernel /= kernel.sum()
    return density(np.maximum(omega[:, None] - offset, 0.0)) @ kernel


def assert_within_band(record, density, lowest, highest):
    """Most frequencies lie in their 95 % band, none beyond the 1e-6 one."""
    welch = estimate_spectrum(record, DT, segment=SEGMENT)
    omega, estimate, freedom = welch.omega, welch.density, degrees_of_freedom(len(welch.segments))
    band = (omega > lowest) & (omega < highest)
    expected = through_window(density, omega[band])
    band[band], expected = expected > 1e-3 * expected.max(), expected[expected > 1e-3 * expected.max()]
    ratio = estimate[band] / expected
    outside = (ratio < chi2.ppf(0.025, freedom) / freedom) | (ratio > chi2.ppf(0.975, freedom) / freedom)
    # neighbours share a window: of n frequencies about n / 2 are independent, each twice as likely to be doubled
    assert outside.sum() == pytest.approx(0, abs=2 * binom.ppf(0.999, max(1, band.sum() // 2), 0.05))
    assert ratio.min() > chi2.ppf(1e-6, freedom) / freedom
    assert ratio.max() < chi2.ppf(1.0 - 1e-6, freedom) / freedom


@pytest.mark.parametrize("name", list(SEAS))
def test_the_spectrum_of_three_hours_is_the_target(name):
    sea = SEAS[name]
    record = elevation(sea)
    assert_within_band(record, sea.density, 0.6 * sea.peak_frequency, 4.0 * sea.peak_frequency)


@pytest.mark.parametrize("name", list(SEAS))
def test_moments_height_and_periods_of_three_hours_lie_in_their_intervals(name):
    # the intervals are those of a Gaussian sea; a component sum scatters less
    statistics = record_statistics(elevation(SEAS[name], seed=2), DT, SEAS[name], segment=SEGMENT)
    for quantity in ("m0", "m2", "significant_wave_height", "zero_crossing_period", "peak_period"):
        assert getattr(statistics, quantity).is_inside, quantity
    assert statistics.significant_wave_height.value == pytest.approx(SEAS[name].significant_wave_height, rel=0.03)


def test_the_spectrum_of_filtered_noise_is_that_of_its_filter():
    system = shaping_filter(Bretschneider(3.0, 10.0), "six_state")

    def density(omega):
        return output_spectrum(system, "wave_elevation", omega)

    source = FilterSource(system, None, seed=3, tick_period=DT)
    record = source.motions(range(1, round(DURATION / DT) + 1)).elevation
    assert_within_band(record, density, 0.35, 2.5)


def test_a_wrong_spectrum_is_noticed():
    # the band has teeth: the same record against a sea 10 % higher, or one of 5 % longer period, falls out of it
    record = elevation(SEAS["jonswap"])
    for wrong in (Jonswap(3.3, 10.0), Jonswap(3.0, 10.5)):
        with pytest.raises(AssertionError):
            assert_within_band(record, wrong.density, 0.4, 2.5)


@pytest.mark.skipif(not MEASURED.is_dir(), reason=f"the measured spectra are not beside the checkout ({MEASURED})")
@pytest.mark.parametrize(
    ("file", "record"), [("ndbc_41010.data_spec", 100), ("ndbc_46042w1996.txt.gz", 4000)], ids=["atlantic", "pacific"]
)
def test_the_spectrum_of_three_hours_of_a_measured_sea_is_what_the_buoy_measured(file, record):
    sea = read_spectra(MEASURED / file).records[record].spectrum
    heave = elevation(sea)
    low = max(0.3, float(sea.edges[0]) + 0.1)
    assert_within_band(heave, sea.density, low, 2.2)
