"""Named models: connection, stationary covariance, spectra."""

import math

import numpy as np
import pytest
from heave_node.numerics.linear_model import (
    NOISE_INTENSITY,
    ModelError,
    covariance_factor,
    interconnect,
    linear_model,
    output_sigma,
    output_spectrum,
    spectral_abscissa,
    state_covariance,
    with_feedback,
)
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays


def oscillator(natural=2.0, damping=0.1, noise=0.0, names=("x", "v")):
    """x'' + 2 zeta w x' + w^2 x = u + noise w."""
    return linear_model(
        [[0.0, 1.0], [-(natural**2), -2.0 * damping * natural]],
        states=names,
        inputs={"u": [0.0, 1.0]},
        outputs={names[0]: [1.0, 0.0]},
        noises={"w": [0.0, noise]},
    )


def test_a_name_that_does_not_exist_is_named_with_those_that_do():
    with pytest.raises(ModelError, match="no state y; it has x, v"):
        oscillator().state("y")
    with pytest.raises(ModelError, match="no output y; it has x"):
        oscillator().row("y")


def test_a_matrix_of_the_wrong_shape_is_refused():
    with pytest.raises(ValueError, match=r"reshape|shape"):
        linear_model([[0.0, 1.0]], states=("x", "v"))


def test_a_value_that_is_not_finite_is_refused():
    with pytest.raises(ModelError, match="matrix A holds a value that is not finite"):
        linear_model([[math.nan]], states=("x",))


def test_two_states_of_one_name_are_refused():
    with pytest.raises(ModelError, match="names must be unique"):
        interconnect([oscillator(), oscillator()])


def test_blocks_in_a_loop_without_a_state_are_refused():
    through = {"feedthrough": {("y", "u"): 1.0}, "inputs": {"u": []}, "outputs": {"y": []}}
    back = {"feedthrough": {("u", "y"): 1.0}, "inputs": {"y": []}, "outputs": {"u": []}}
    blocks = [linear_model(np.zeros((0, 0)), states=(), **side) for side in (through, back)]
    with pytest.raises(ModelError, match="algebraic loop"):
        interconnect(blocks)


def test_a_series_multiplies_the_frequency_responses():
    # |H|^2 of a lag 2 / (s + 0.5) and of an oscillator 1 / (s^2 + 0.4 s + 1), written out
    lag = linear_model([[-0.5]], states=("y",), outputs={"u": [1.0]}, noises={"w": [2.0 * math.sqrt(NOISE_INTENSITY)]})
    omega = np.array([[0.1, 0.9], [1.0, 3.0]])
    s = 1j * omega
    exact = np.abs(2.0 / (s + 0.5) / (s**2 + 0.4 * s + 1.0)) ** 2
    series = interconnect([oscillator(1.0, 0.2), lag])
    np.testing.assert_allclose(output_spectrum(series, "x", omega), exact, rtol=1e-12)
    assert series.input_names == ()


def test_outputs_are_given_by_rows_or_by_weights_of_states():
    model = oscillator().with_outputs({"rate": {"v": 1.0}, "acceleration": np.array([-4.0, -0.4])})
    assert model.output_names == ("x", "rate", "acceleration")
    np.testing.assert_array_equal(model.C[1:], [[0.0, 1.0], [-4.0, -0.4]])


def test_white_noise_of_unit_spectral_density_has_the_intensity_pi():
    # x' = -a x + b w: integral over omega > 0 of b^2 / (a^2 + omega^2) = pi b^2 / (2 a)
    lag = linear_model([[-0.5]], states=("x",), outputs={"x": [1.0]}, noises={"w": [2.0 * math.sqrt(NOISE_INTENSITY)]})
    assert output_sigma(lag)["x"] ** 2 == pytest.approx(math.pi * 4.0 / (2.0 * 0.5))


def test_the_integral_of_the_spectrum_is_the_variance():
    # x'' + 2 z w x' + w^2 x = s white of intensity q: variance q / (4 z w^3)
    system = oscillator(0.8, 0.3, noise=0.7)
    omega = np.linspace(0.0, 60.0, 600_001)
    exact = 0.49 / (4.0 * 0.3 * 0.8**3)
    assert np.trapezoid(output_spectrum(system, "x", omega), omega) == pytest.approx(exact, rel=1e-5)
    assert output_sigma(system)["x"] ** 2 == pytest.approx(exact, rel=1e-12)


def test_the_variance_of_a_discrete_lag_is_the_sum_of_its_series():
    # x[k+1] = a x[k] + s w[k]: s^2 (1 + a^2 + a^4 + ...) = s^2 / (1 - a^2)
    lag = linear_model([[0.9]], states=("x",), outputs={"x": [1.0]}, noises={"w": [0.3]}, dt=0.05)
    assert output_sigma(lag)["x"] ** 2 == pytest.approx(0.09 / (1.0 - 0.81), rel=1e-12)


def test_an_unstable_model_has_no_stationary_covariance():
    with pytest.raises(ModelError, match="not stable"):
        state_covariance(linear_model([[0.1]], states=("x",), noises={"w": [1.0]}))


def test_feedback_moves_the_poles_where_the_gain_says():
    # x'' + 0.4 x' + 4 x = u, u = -(5 x + 3.6 x'): x'' + 4 x' + 9 x = 0, both poles at real part -2
    assert spectral_abscissa(with_feedback(oscillator(), np.array([5.0, 3.6]))) == pytest.approx(-2.0)


@given(arrays(float, (4, 2), elements=st.floats(-1e3, 1e3)))
def test_the_factor_of_a_singular_covariance_gives_it_back(columns):
    covariance = columns @ columns.T
    factor = covariance_factor(covariance)
    scale = np.sqrt(np.outer(np.diag(covariance), np.diag(covariance))) + 1e-280
    assert np.abs(factor @ factor.T - covariance).max(where=scale > 1e-200, initial=0.0) <= 1e-12 * scale.max()
