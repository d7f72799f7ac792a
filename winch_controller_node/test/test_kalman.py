"""The two filters of one step: the compiled one is filterpy's, and can be exchanged for it."""

import numpy as np
import pytest
from heave_bringup.closed_loop import ClosedLoop, loop_parameters
from heave_bringup.scenarios import load_scenario
from hypothesis import given, settings
from hypothesis import strategies as st
from winch_controller_node.model.kalman import CompiledKalmanFilter, ReferenceKalmanFilter
from winch_controller_node.model.kalman_kernel import corrected_covariance, filter_gain


@settings(max_examples=30, deadline=None)
@given(n=st.integers(1, 9), m=st.integers(1, 4), seed=st.integers(0, 2**16))
def test_the_compiled_steps_are_those_of_filterpy(n, m, seed):
    """filterpy takes scalar readings one after the other, the compiled filter all of them at once."""
    rng = np.random.default_rng(seed)
    F, B = 0.4 * rng.standard_normal((n, n)), rng.standard_normal((n, 1))
    root = rng.standard_normal((n, n))
    ours, peer = CompiledKalmanFilter(n), ReferenceKalmanFilter(n)
    for kalman in (ours, peer):
        kalman.set_model(F, B, root @ root.T)
        kalman.set_state(np.ones(n), np.eye(n))
    for _ in range(5):
        H, z, variances = rng.standard_normal((m, n)), rng.standard_normal(m), rng.uniform(0.1, 2.0, m)
        for kalman in (ours, peer):
            kalman.predict(0.7)
            kalman.correct(z, H, variances)
    scale = np.max(np.abs(peer.P))
    np.testing.assert_allclose(ours.x, peer.x, atol=1e-10 * (1.0 + np.max(np.abs(peer.x))))
    np.testing.assert_allclose(ours.P, peer.P, atol=1e-10 * scale)


def test_josephs_form_with_the_optimal_gain_is_the_short_form():
    """P - K H P, true for the optimal gain alone (Simon 2006, Eq. 5.19)."""
    rng = np.random.default_rng(4)
    root, H, variances = rng.standard_normal((6, 6)), rng.standard_normal((2, 6)), np.array([0.3, 0.7])
    P = root @ root.T
    K = filter_gain(P, H, variances)
    np.testing.assert_allclose(corrected_covariance(P, K, H, variances), P - K @ H @ P, atol=1e-12 * np.max(P))


def test_a_state_that_was_given_is_never_changed():
    """The estimator keeps what it was given, to go back to when a reading comes late."""
    for kalman in (CompiledKalmanFilter(3), ReferenceKalmanFilter(3)):
        x, P = np.ones(3), np.eye(3)
        kalman.set_model(0.5 * np.eye(3), np.ones((3, 1)), np.eye(3))
        kalman.set_state(x, P)
        kept = kalman.x, kalman.P
        copies = kalman.x.copy(), kalman.P.copy()
        kalman.predict(1.0)
        kalman.correct(np.array([2.0]), np.array([[1.0, 0.0, 0.0]]), np.array([0.1]))
        for array, copy in zip((*kept, x, P), (*copies, np.ones(3), np.eye(3)), strict=True):
            np.testing.assert_array_equal(array, copy)


def test_the_loop_of_the_thesis_runs_on_filterpy_as_on_the_compiled_filter():
    """B1, the system of thesis 6.3.6: 60 s closed loop, commands equal within what rounding makes of them."""
    orders = {}
    for implementation in ("compiled", "filterpy"):
        changes = ["all.seed=3", "all.duration=60.0", f"winch_controller.estimator.implementation={implementation}"]
        given = []
        ClosedLoop(loop_parameters(load_scenario("b1_thesis", settings=changes))).run(
            lambda tick, outputs, given=given: given.append(outputs.order.payout)
        )
        orders[implementation] = np.array(given)
    assert np.std(orders["compiled"]) > 0.05, "the winch moves, once two waves have been seen"
    np.testing.assert_allclose(orders["filterpy"], orders["compiled"], atol=1e-6)


@pytest.mark.parametrize("filter_type", [CompiledKalmanFilter, ReferenceKalmanFilter])
def test_a_filter_starts_at_zero_with_the_unit_covariance(filter_type):
    kalman = filter_type(4)
    np.testing.assert_array_equal(kalman.x, np.zeros(4))
    np.testing.assert_array_equal(kalman.P, np.eye(4))
