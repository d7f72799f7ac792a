import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from wave_vessel_node.sea.realisation import HarmonicSum, draw_components
from wave_vessel_node.sea.spectra import Bretschneider, Jonswap, OchiHubble, OchiHubbleSystem, TabulatedSpectrum

SEAS = [
    Bretschneider(2.0, 9.0),
    Jonswap(3.0, 11.0),
    OchiHubble(OchiHubbleSystem(1.5, 8.0), OchiHubbleSystem(1.0, 16.5, 3.0)),
    TabulatedSpectrum([0.2, 0.5, 0.6, 0.9, 2.0], [0.0, 1.0, 0.0, 0.5, 0.0], name="gap"),
]


@pytest.mark.parametrize("sea", SEAS, ids=lambda sea: type(sea).__name__)
def test_the_components_carry_exactly_the_energy_of_the_spectrum(sea):
    components = draw_components(sea, 500, np.random.default_rng(3))
    assert 0.5 * (components.amplitude**2).sum() == pytest.approx(sea.moment(0), rel=1e-9)


@pytest.mark.parametrize("sea", SEAS, ids=lambda sea: type(sea).__name__)
def test_the_energy_in_any_band_is_that_of_the_spectrum_to_one_component(sea):
    components = draw_components(sea, 500, np.random.default_rng(4))
    cumulative = np.cumsum(0.5 * components.amplitude**2)
    for omega in np.linspace(0.6, 2.0, 15) * sea.peak_frequency:
        below = float(np.interp(omega, components.frequency, cumulative))
        grid = np.linspace(1e-6, omega, 20001)
        target = np.trapezoid(sea.density(grid), grid)
        assert below == pytest.approx(target, abs=1.5 * (0.5 * components.amplitude**2).max())


def test_no_component_lies_where_the_spectrum_has_no_energy():
    sea = TabulatedSpectrum([0.3, 0.5, 0.6, 1.2, 1.3, 1.5], [0.0, 1.0, 0.0, 0.0, 1.0, 0.0], name="two")
    frequency = draw_components(sea, 300, np.random.default_rng(0)).frequency
    assert not ((frequency > 0.601) & (frequency < 1.199)).any()


def test_the_sea_does_not_repeat_within_three_hours():
    # autocorrelation at all lags from 5 min to 3 h: equal spacing would bring it back to 1; for 800 independent lines
    # the
    # mean square is sum a^4 / (2 (sum a^2)^2), here 0.03 rms, and 5 sigma of it is the most to expect among 1e5 lags
    components = draw_components(Bretschneider(2.0, 9.0), 800, np.random.default_rng(5))
    energy = components.amplitude**2
    rms = math.sqrt(0.5 * float((energy**2).sum())) / energy.sum()
    lags = np.arange(300.0, 10800.0, 0.37)
    correlation = np.array([energy @ np.cos(components.frequency * lag) for lag in lags]) / energy.sum()
    assert np.abs(correlation).max() < 6.0 * rms


def test_the_mean_autocorrelation_of_many_seas_is_that_of_the_spectrum():
    # frequencies drawn within their cells make the ensemble exact, also at lags where fixed ones would come round again
    sea = Bretschneider(2.0, 9.0)
    grid = np.linspace(0.2, 12.0, 60001)
    lags = np.array([2.0, 5.0, 11.0, 60.0, 400.0])
    exact = np.array([np.trapezoid(sea.density(grid) * np.cos(grid * lag), grid) for lag in lags])
    drawn = []
    for seed in range(200):
        components = draw_components(sea, 50, np.random.default_rng(seed))
        drawn.append(0.5 * components.amplitude**2 @ np.cos(np.outer(components.frequency, lags)))
    error = np.array(drawn).std(axis=0) / math.sqrt(200)
    assert (np.abs(np.mean(drawn, axis=0) - exact) < 4.0 * error + 1e-3 * sea.moment(0)).all()


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_a_seed_fixes_the_sea(seed):
    first, second = (draw_components(SEAS[0], 40, np.random.default_rng(seed)) for _ in range(2))
    np.testing.assert_array_equal(first.phase, second.phase)
    np.testing.assert_array_equal(first.frequency, second.frequency)


def test_directions_spread_as_cos_2s():
    # mean of cos(angle) of cos^2s(angle/2) is s / (s + 1)
    components = draw_components(SEAS[0], 4000, np.random.default_rng(1), direction=0.7, spreading_exponent=6.0)
    angle = components.direction - 0.7
    assert np.cos(angle).mean() == pytest.approx(6.0 / 7.0, abs=2e-3)
    assert np.sin(angle).mean() == pytest.approx(0.0, abs=2e-2)
    assert abs(np.corrcoef(angle, components.frequency)[0, 1]) < 0.05


def test_a_sea_without_waves_is_flat():
    components = draw_components(Bretschneider(0.0, 9.0), 10, np.random.default_rng(0))
    assert (components.amplitude == 0.0).all()
    assert np.isfinite(components.frequency).all()


def test_a_harmonic_sum_equals_the_sum_written_out_at_any_tick():
    generator = np.random.default_rng(2)
    omega = generator.uniform(-1.0, 3.0, 30)
    c = generator.standard_normal((3, 30)) + 1j * generator.standard_normal((3, 30))
    harmonics = HarmonicSum(omega, c, 0.05)
    for tick in (1, 63, 64, 65, 7, 1_000_003):
        z = np.exp(1j * omega * (tick * 0.05))
        expected = np.stack(((c @ z).real, (c @ (1j * omega * z)).real, (c @ (-(omega**2) * z)).real))
        np.testing.assert_allclose(harmonics.at(range(tick, tick + 1))[0], expected, rtol=0, atol=1e-9)


def test_what_a_tick_gives_does_not_depend_on_what_was_asked_before():
    omega, c = np.array([0.3, 1.1]), np.array([[1.0 + 1.0j, 0.5]])
    one, other = HarmonicSum(omega, c, 0.05), HarmonicSum(omega, c, 0.05)
    whole = one.at(range(1, 201))
    np.testing.assert_array_equal(whole[-1], other.at(range(200, 201))[0])
