import math

import numpy as np
import pytest
from heave_node.numerics.linear_model import interconnect, linear_model, output_sigma, output_spectrum
from wave_vessel_node.sea.filter_fit import filter_quality, fit_filter
from wave_vessel_node.sea.shaping_filter import shaping_filter, thesis_filter
from wave_vessel_node.sea.spectra import (
    Bretschneider,
    Jonswap,
    OchiHubble,
    OchiHubbleSystem,
    SpectrumError,
    TabulatedSpectrum,
)
from wave_vessel_node.vessel.second_order import SecondOrderVessel, boom_tip_model

THESIS_SEA = Bretschneider(3.048, 2.0 * math.pi / 0.785)
SEA = Bretschneider(2.0, 9.0)


def elevation_spectrum(system, omega):
    return output_spectrum(system, "wave_elevation", omega)


@pytest.mark.parametrize(
    ("form", "error"),
    # corrections to the thesis, checked numerically: 71 %, 5.34 %, 1.12 % relative L2 error
    [("thesis", 0.709), ("four_state", 0.0534), ("six_state", 0.0112)],
)
def test_the_errors_of_the_known_filters_are_those_of_the_literature(form, error):
    assert filter_quality(shaping_filter(SEA, form), SEA).relative_error == pytest.approx(error, rel=2e-3)


def test_the_thesis_filter_has_the_variance_and_peak_known_of_it():
    # 0.937 of H^2/16, peak at 0.802 omega_m
    system = thesis_filter(SEA)
    assert filter_quality(system, SEA).variance_ratio == pytest.approx(0.937, abs=1e-3)
    omega = np.linspace(0.5, 1.2, 7001) * SEA.peak_frequency
    assert omega[np.argmax(elevation_spectrum(system, omega))] / SEA.peak_frequency == pytest.approx(0.802, abs=1e-3)


def test_the_thesis_filter_has_the_transfer_function_of_eq_6_22():
    s = 1j * np.array([0.3, 0.785, 2.0])
    natural = 0.9538 * 0.785
    density = 1.25 / (4.0 * 0.785) * 3.048**2 * 1.8861
    ratio = s / natural
    expected = math.sqrt(density) * ratio**2 / (1.0 + 1.414 * ratio + ratio**2) ** 3
    np.testing.assert_allclose(elevation_spectrum(thesis_filter(THESIS_SEA), s.imag), np.abs(expected) ** 2, rtol=1e-6)


def test_the_thesis_system_has_the_uncontrolled_response_of_0_2551_m():
    # thesis 6.3.6: a 0.8959, b 0.1658, vessel 0.393 rad/s, 0.6, 0.5; 0.255 m with noise of intensity pi
    a, b = 0.8959, 0.1658
    unit = linear_model(
        [[0.0, 1.0], [-1 / a, -b / a]],
        states=("unit_heave", "unit_heave_rate"),
        inputs={"boom_tip_heave": [0.0, 1 / a]},
        outputs={"unit_heave": [1.0, 0.0]},
    )
    system = interconnect([unit, boom_tip_model(thesis_filter(THESIS_SEA), SecondOrderVessel(0.393, 0.6, 0.5))])
    assert output_sigma(system)["unit_heave"] == pytest.approx(0.2551, abs=5e-5)


def test_scaling_a_filter_keeps_its_shape():
    small, large = shaping_filter(Bretschneider(1.0, 6.0)), shaping_filter(Bretschneider(4.0, 12.0))
    x = np.array([0.7, 1.0, 1.6])
    first = elevation_spectrum(small, x * 2 * math.pi / 6.0) / (1.0 * 6.0)
    second = elevation_spectrum(large, x * 2 * math.pi / 12.0) / (16.0 * 12.0)
    np.testing.assert_allclose(first, second, rtol=1e-9)


@pytest.mark.parametrize(
    ("sea", "states", "error"),
    # best fits known: Bretschneider 6 states 0.0112 with four zeros; JONSWAP 6 states 0.019, here with four zeros
    [
        (SEA, 6, 0.01121),
        (SEA, 8, 0.0013),
        (Jonswap(2.0, 9.0), 6, 0.027),
        (Jonswap(2.0, 9.0), 8, 0.0135),
        (OchiHubble(OchiHubbleSystem(1.5, 8.0), OchiHubbleSystem(1.0, 16.5, 3.0)), 8, 0.02),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, Bretschneider | Jonswap | OchiHubble) else str(value),
)
def test_fits_with_four_zeros_are_good_and_leak_little(sea, states, error):
    fit = fit_filter(sea, states)
    assert fit.form.zeros_at_origin == 4
    assert fit.quality.relative_error < error
    assert fit.quality.leak < 2.1e-3
    assert fit.quality.variance_ratio == pytest.approx(1.0, abs=0.03)
    assert np.linalg.eigvals(fit.system.A).real.max() < 0.0


@pytest.mark.parametrize(
    # unconstrained best fits known of JONSWAP (gamma 3.3): 4 / 6 / 8 / 10 states 0.055 / 0.019 / 0.009 / 0.0024
    ("states", "error"),
    [(4, 0.0556), (6, 0.0196), (8, 0.0091), (10, 0.0025)],
)
def test_fits_without_a_bound_on_the_leak_reach_the_best_known_of_jonswap(states, error):
    fit = fit_filter(Jonswap(2.0, 9.0), states, zeros_at_origin=2, leak_bound=1.0)
    assert fit.quality.relative_error < error


def test_below_the_sea_a_filter_with_four_zeros_falls_with_the_eighth_power():
    system = shaping_filter(SEA, "six_state")
    low = np.array([0.02, 0.04]) * SEA.peak_frequency
    density = elevation_spectrum(system, low)
    assert density[1] / density[0] == pytest.approx(2.0**8, rel=1e-2)


def test_auto_takes_the_constants_for_bretschneider_and_fits_anything_else():
    np.testing.assert_array_equal(shaping_filter(SEA).A, shaping_filter(SEA, "six_state").A)
    table = TabulatedSpectrum(np.linspace(0.3, 2.0, 40), SEA.density(np.linspace(0.3, 2.0, 40)), name="table")
    assert filter_quality(shaping_filter(table), table).relative_error < 0.05


def test_a_fit_is_the_same_each_time():
    first, second = (fit_filter(Jonswap(2.0, 9.0), 6) for _ in range(2))
    assert first.form == second.form


@pytest.mark.parametrize(
    ("arguments", "says"),
    [(("cubic",), "no filter form"), (("fit", 5), "even number"), (("fit", 2), "4 or more")],
)
def test_a_filter_that_cannot_be_is_refused(arguments, says):
    with pytest.raises(SpectrumError, match=says):
        shaping_filter(SEA, *arguments)


def test_a_flat_sea_has_no_filter():
    with pytest.raises(SpectrumError, match="height is 0"):
        shaping_filter(Bretschneider(0.0, 9.0))
