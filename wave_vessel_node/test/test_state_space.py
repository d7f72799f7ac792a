import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm
from wave_vessel_node.sea.state_space import StateSpace, covariance_factor, discretise, series

LAG = StateSpace(np.array([[-0.5]]), np.array([[2.0]]), np.array([[1.0]]), ("x",))


def oscillator(natural, damping):
    A = np.array([[0.0, 1.0], [-(natural**2), -2.0 * damping * natural]])
    return StateSpace(A, np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]]), ("x", "v"))


def test_white_noise_of_unit_density_has_intensity_pi():
    # x' = -a x + b w: integral over omega > 0 of b^2 / (a^2 + omega^2) = pi b^2 / (2 a)
    assert LAG.output_variance() == pytest.approx(math.pi * 4.0 / (2.0 * 0.5))


def test_the_integral_of_the_spectrum_is_the_variance():
    system = oscillator(0.8, 0.3)
    omega = np.linspace(0.0, 60.0, 600_001)
    # exact: pi / (4 zeta omega_n^3)
    exact = math.pi / (4.0 * 0.3 * 0.8**3)
    assert np.trapezoid(system.spectrum(omega), omega) == pytest.approx(exact, rel=1e-5)
    assert system.output_variance() == pytest.approx(exact, rel=1e-12)


@given(st.floats(0.1, 3.0), st.floats(0.05, 3.0), st.floats(0.01, 20.0))
@settings(max_examples=40, deadline=None)
def test_discretisation_keeps_the_stationary_covariance(natural, damping, period):
    system = oscillator(natural, damping)
    P = system.stationary_covariance()
    transition, noise = discretise(system, period)
    np.testing.assert_allclose(transition, expm(system.A * period), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(transition @ P @ transition.T + noise, P, rtol=1e-8, atol=1e-10 * P.max())


@given(st.floats(0.2, 2.0), st.floats(0.1, 1.0))
@settings(max_examples=20, deadline=None)
def test_two_short_steps_make_one_long_step(natural, damping):
    system = oscillator(natural, damping)
    phi, q = discretise(system, 0.1)
    phi2, q2 = discretise(system, 0.2)
    np.testing.assert_allclose(phi @ phi, phi2, rtol=1e-10, atol=1e-13)
    np.testing.assert_allclose(phi @ q @ phi.T + q, q2, rtol=1e-9, atol=1e-14)


def test_a_series_multiplies_the_frequency_responses():
    first, second = LAG, oscillator(1.0, 0.2)
    omega = np.array([0.1, 0.9, 3.0])
    both = series(first, second).frequency_response(omega)[:, 0, 0]
    single = first.frequency_response(omega)[:, 0, 0] * second.frequency_response(omega)[:, 0, 0]
    np.testing.assert_allclose(both, single, rtol=1e-12)


def test_an_unstable_system_has_no_covariance():
    unstable = StateSpace(np.array([[0.1]]), np.ones((1, 1)), np.ones((1, 1)), ("x",))
    with pytest.raises(ValueError, match="not stable"):
        unstable.stationary_covariance()


def test_matrices_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match=r"A, B, C of 2 states"):
        StateSpace(np.eye(2), np.ones((3, 1)), np.ones((1, 2)), ("a", "b"))


def test_the_factor_of_a_singular_covariance_gives_it_back():
    covariance = np.outer([1.0, 2.0, -1e-4], [1.0, 2.0, -1e-4])
    factor = covariance_factor(covariance)
    np.testing.assert_allclose(factor @ factor.T, covariance, atol=1e-12)
