"""Extremes against distributions that are known exactly: Rayleigh waves, and the families that are fitted."""

import math

import numpy as np
import pytest
from heave_studies.extremes.largest import (
    Largest,
    Peaks,
    block_maxima,
    cycle_maxima,
    fit_blocks,
    fit_peaks,
    from_blocks,
    from_peaks,
    peaks_over_threshold,
)
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

PERIOD = 8.0
"""Wave period [s]."""
THREE_HOURS = 10_800.0


def rayleigh_waves(count, seed=1):
    """Return crests of a narrow-banded Gaussian process of standard deviation 1."""
    return np.random.default_rng(seed).rayleigh(1.0, count)


def test_the_most_probable_crest_of_rayleigh_waves_is_sigma_sqrt_2_ln_n_by_either_method():
    """Longuet-Higgins 1952; the 90th percentile of the largest of n is where 1 - exp(-x^2/2) to the nth is 0.9."""
    crests = rayleigh_waves(20_000)
    n = THREE_HOURS / PERIOD
    exact = math.sqrt(2.0 * math.log(n))
    exact_p90 = math.sqrt(-2.0 * math.log(1.0 - 0.9 ** (1.0 / n)))
    blocks = crests.reshape(-1, 100).max(axis=1)
    of_blocks = from_blocks(blocks, 100 * PERIOD, THREE_HOURS)
    of_peaks = from_peaks(peaks_over_threshold(crests, crests.size * PERIOD), THREE_HOURS)
    # the shape is fitted to the 2,500 peaks, which is worth 4 % of a percentile far beyond them (their bootstrap)
    for found, tolerance in ((of_blocks, 0.02), (of_peaks, 0.06)):
        assert found.most_probable == pytest.approx(exact, rel=tolerance)
        assert found.p90 == pytest.approx(exact_p90, rel=tolerance)
        assert found.most_probable_range[0] < found.most_probable < found.most_probable_range[1]
        assert found.warnings == ()


@pytest.mark.parametrize("shape", [-0.2, 0.0, 0.15])
def test_a_known_distribution_is_found_again_and_its_percentiles_are_scipys(shape):
    """Within what 3,000 values say: 0.05 of the shape, 0.02 of a percentile that lies inside the sample."""
    law = stats.genextreme(-shape, 5.0, 0.7)
    found = fit_blocks(law.rvs(3000, random_state=2), 60.0)
    assert found.shape == pytest.approx(shape, abs=0.05)
    ten = found.within(600.0)
    assert ten.percentile(0.9) == pytest.approx(law.ppf(0.9 ** (1 / 10)), rel=0.02)
    grid = np.linspace(5.0, 9.0, 40_001)
    density = stats.genextreme(-ten.shape, ten.location, ten.scale).pdf(grid)
    assert ten.most_probable == pytest.approx(grid[np.argmax(density)], abs=2e-4)


def test_a_fit_is_that_of_scipy_by_maximum_likelihood_within_what_a_sample_says():
    """Of 500 values; both are estimates, and the standard error of a percentile in the sample is about 2 %."""
    maxima = stats.genextreme(0.1, 5.0, 0.7).rvs(500, random_state=6)
    likely = stats.genextreme(*stats.genextreme.fit(maxima))
    assert fit_blocks(maxima, 1.0).percentile(0.99) == pytest.approx(likely.ppf(0.99), rel=0.02)
    excess = stats.genpareto(-0.1, scale=0.5).rvs(500, random_state=7)
    likely = stats.genpareto(*stats.genpareto.fit(excess, floc=0.0))
    one_peak = fit_peaks(Peaks(excess, 0.0, 500.0)).within(1.0)
    assert one_peak.percentile(0.95) == pytest.approx(likely.isf(-math.log(0.95)), rel=0.04)


@pytest.mark.parametrize("shape", [-0.2, 0.15])
def test_peaks_of_a_known_distribution_give_the_maximum_of_their_poisson_process(shape):
    law = stats.genpareto(shape, scale=0.5)
    found = fit_peaks(Peaks(law.rvs(3000, random_state=3), 2.0, 3000 * 60.0)).within(600.0)
    # ten peaks are expected: the largest stays below x with exp(-10 (1 - F(x)))
    assert found.percentile(0.9) == pytest.approx(2.0 + law.isf(-math.log(0.9) / 10.0), rel=0.04)


@given(st.floats(-0.4, 0.4), st.floats(0.1, 5.0), st.floats(10.0, 1e4), st.floats(10.0, 1e4))
def test_two_steps_to_a_time_are_one(shape, scale, middle, end):
    law = Largest(1.0, scale, shape, 100.0)
    straight, detour = law.within(end), law.within(middle).within(end)
    assert detour.percentile(0.7) == pytest.approx(straight.percentile(0.7), rel=1e-6, abs=1e-6)
    # F to the power of the ratio of times
    x = straight.percentile(0.7)
    share = stats.genextreme.cdf(x, -shape, law.location, law.scale)
    assert share ** (end / 100.0) == pytest.approx(0.7, rel=1e-4)


def test_nine_intervals_in_ten_hold_the_truth():
    """Thirty samples of 40 maxima with Gumbel squares: fewer than 22 hits have a probability of 0.2 % at 90 %."""
    truth = math.sqrt(Largest(9.0, 0.8, 0.0, 60.0).within(3600.0).most_probable)
    samples = np.sqrt(stats.gumbel_r(9.0, 0.8).rvs((30, 40), random_state=4))
    intervals = [from_blocks(sample, 60.0, 3600.0).most_probable_range for sample in samples]
    assert sum(low < truth < high for low, high in intervals) >= 22


def test_a_small_sample_and_a_long_extrapolation_are_warned_of_and_a_seed_fixes_all():
    maxima = stats.gumbel_r(3.0, 0.4).rvs(8, random_state=5)
    found = from_blocks(maxima, 60.0, THREE_HOURS)
    assert "only 8 values" in found.warnings[0]
    assert found.warnings[1] == "3 h from 8 min of records: run longer, or more seeds"
    assert found == from_blocks(maxima, 60.0, THREE_HOURS)
    assert from_blocks(maxima[:2], 60.0, THREE_HOURS) is None


def test_cycles_blocks_and_groups_of_a_record_are_what_they_are():
    time = np.arange(0.0, 100.0, 0.05)
    height = np.where(time < 50.0, 1.0, 2.0)
    wave = 7.0 + height * np.sin(2.0 * np.pi * time / 10.0)
    maxima = cycle_maxima(wave)
    assert maxima[1:4] == pytest.approx(1.0, rel=1e-3)
    assert maxima[-3:] == pytest.approx(2.0, rel=1e-3)
    assert block_maxima(wave, 12) == pytest.approx([1.0, 2.0], rel=1e-3)
    # two groups of cycles above the threshold are two peaks
    peaks = peaks_over_threshold(np.array([1.0, 5.0, 6.0, 5.5, 1.0, 1.0, 7.0, 1.0, *[0.5] * 20]), 100.0)
    assert peaks.excess + peaks.threshold == pytest.approx([6.0, 7.0])
    assert cycle_maxima(np.zeros(10)).size == 0
    assert block_maxima(np.zeros(0), 0).size == 0
