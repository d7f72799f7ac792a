import math

import numpy as np
import pytest
from heave_node.numerics.constants import STANDARD_GRAVITY
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import gamma
from wave_vessel_node.sea.spectra import (
    Bretschneider,
    Jonswap,
    OchiHubble,
    OchiHubbleSystem,
    PiersonMoskowitz,
    SpectrumError,
    TabulatedSpectrum,
)

HEIGHTS = st.floats(0.1, 20.0)
PERIODS = st.floats(2.0, 25.0)


def test_the_thesis_sea_has_a_sixteenth_of_its_height_squared_as_variance():
    # thesis example, 3.048 m and 0.785 rad/s; the right exponent gives exactly H^2 / 16
    sea = Bretschneider(3.048, 2 * math.pi / 0.785)
    assert sea.moment(0) == pytest.approx(0.580644, rel=1e-6)


@given(HEIGHTS, PERIODS)
@settings(max_examples=25, deadline=None)
def test_every_spectrum_has_the_height_it_is_given(height, period):
    for sea in (Bretschneider(height, period), Jonswap(height, period), Jonswap(height, period, 7.0)):
        assert sea.significant_wave_height == pytest.approx(height, rel=1e-6)
        assert sea.peak_period == pytest.approx(period)


@given(HEIGHTS, HEIGHTS, st.floats(1.0, 8.0), st.floats(1.0, 8.0))
@settings(max_examples=25, deadline=None)
def test_the_energies_of_wind_sea_and_swell_add(wind, swell, wind_shape, swell_shape):
    sea = OchiHubble(OchiHubbleSystem(wind, 8.0, wind_shape), OchiHubbleSystem(swell, 16.0, swell_shape))
    assert sea.moment(0) == pytest.approx((wind**2 + swell**2) / 16.0, rel=1e-5)


def test_moments_of_bretschneider_equal_the_closed_form():
    # integral of omega^n S = (Hs^2/16) omega_m^n 1.25^(n/4) Gamma(1 - n/4)
    sea = Bretschneider(2.0, 9.0)
    for order in (-1, 0, 1, 2, 3):
        exact = 0.25 * sea.peak_frequency**order * 1.25 ** (order / 4) * gamma(1 - order / 4)
        # m_3 converges as 1/omega: beyond 400 omega_m lies 5 m_0 omega_m^3 / 400, 0.3 % of it
        assert sea.moment(order) == pytest.approx(exact, rel=3.5e-3 if order == 3 else 1e-4)


def test_the_zero_crossing_period_of_bretschneider_is_071_of_its_peak_period():
    # T_z / T_p = (1.25 pi)^(-1/4), from m_2 = m_0 omega_m^2 sqrt(1.25 pi)
    sea = Bretschneider(2.0, 10.0)
    assert sea.zero_crossing_period == pytest.approx(10.0 * (1.25 * math.pi) ** -0.25, rel=1e-4)


def test_jonswap_without_enhancement_is_bretschneider():
    omega = np.linspace(0.2, 3.0, 50)
    np.testing.assert_allclose(Jonswap(3.0, 9.0, 1.0).density(omega), Bretschneider(3.0, 9.0).density(omega), rtol=1e-6)


def test_ochi_hubble_with_shape_one_and_no_swell_is_bretschneider():
    omega = np.linspace(0.2, 3.0, 50)
    sea = OchiHubble(OchiHubbleSystem(3.0, 9.0), OchiHubbleSystem(0.0, 16.0))
    np.testing.assert_allclose(sea.density(omega), Bretschneider(3.0, 9.0).density(omega), rtol=1e-12)


def test_the_tail_of_pierson_moskowitz_is_alpha_g2_over_omega5():
    sea = PiersonMoskowitz.of_height(4.0)
    omega = 40.0 * sea.peak_frequency
    assert sea.density(omega) == pytest.approx(0.0081 * STANDARD_GRAVITY**2 / omega**5, rel=1e-5)


def test_a_table_is_linear_between_its_points_and_exact_in_its_moments():
    sea = TabulatedSpectrum([1.0, 2.0, 4.0], [0.0, 3.0, 0.0], name="triangle")
    assert sea.moment(0) == pytest.approx(0.5 * 3.0 * 3.0, rel=1e-12)
    # first moment of a triangle: area times the mean of its corners
    assert sea.moment(1) == pytest.approx(4.5 * 7.0 / 3.0, rel=1e-12)
    assert sea.density(1.5) == 1.5
    assert sea.density([0.5, 5.0]).tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    ("frequency", "values", "says"),
    [
        ([1.0, 2.0], [1.0, 1.0], "3 or more"),
        ([1.0, 2.0, 2.0], [1.0, 1.0, 1.0], "strictly increasing"),
        ([1.0, 2.0, 3.0], [1.0, -1.0, 1.0], "negative"),
        ([1.0, 2.0, 3.0], [1.0, math.nan, 1.0], "finite"),
        ([1.0, 2.0, 3.0], [0.0, 0.0, 0.0], "above 0"),
        ([0.0, 2.0, 3.0], [1.0, 1.0, 1.0], "above 0"),
    ],
)
def test_a_table_that_cannot_be_a_spectrum_is_refused(frequency, values, says):
    with pytest.raises(SpectrumError, match=says):
        TabulatedSpectrum(frequency, values, name="buoy")


def test_the_fourth_moment_is_refused_since_it_is_infinite():
    with pytest.raises(SpectrumError, match="orders -1 to 3"):
        Bretschneider(1.0, 8.0).moment(4)
