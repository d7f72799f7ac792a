"""The Kalman filter: late, missing and wrong readings; consistency."""

import math

import numpy as np
import pytest
import scipy.linalg
from heave_node.numerics.linear_model import linear_model, state_covariance
from heave_node.numerics.linear_sampling import discretise
from winch_controller_node.model.estimator import (
    KalmanEstimator,
    Measurement,
    MeasurementModel,
    row_with_differences,
)

DT = 0.1


def swing(noise=0.5):
    model = discretise(
        linear_model(
            [[0.0, 1.0], [-1.0, -0.2]],
            states=("x", "v"),
            inputs={"u": [0.0, 1.0]},
            outputs={"x": [1.0, 0.0]},
            noises={"w": [0.0, noise]},
        ),
        DT,
    )
    return model, state_covariance(model)


def measured(model, sigma=0.1):
    return MeasurementModel("position", "sensor", model.row("x"), sigma)


def make(**options):
    model, P = swing()
    return KalmanEstimator(model, [measured(model)], P, **options)


def simulate(ticks, seed=3):
    """Return states, readings of the position and commands of a run."""
    model, P = swing()
    rng = np.random.default_rng(seed)
    x = np.linalg.cholesky(P) @ rng.standard_normal(2)
    states, readings, commands = [], [], []
    for k in range(ticks):
        states.append(x)
        readings.append(float(x[0] + 0.1 * rng.standard_normal()))
        commands.append(math.sin(0.3 * k))
        x = model.A @ x + model.B[:, 0] * commands[-1] + model.G @ rng.standard_normal(model.G.shape[1])
    return np.array(states), readings, commands


@pytest.mark.parametrize("wrong", [math.nan, math.inf, 50.0])
def test_a_reading_outside_the_gate_changes_nothing_and_is_named(wrong):
    estimator, clean = make(), make()
    for k in range(20):
        clean.step(k, 0.0, [Measurement("position", 0.0, k)] if k < 19 else [])
        estimator.step(k, 0.0, [Measurement("position", 0.0 if k < 19 else wrong, k)])
    assert estimator.estimate == pytest.approx(clean.estimate, rel=1e-12)
    assert not estimator.innovations["position"].accepted
    assert estimator.refusals["position"] == 1


def test_a_step_back_in_time_is_refused():
    estimator = make()
    estimator.step(5, 0.0, [])
    with pytest.raises(ValueError, match="tick 5 is not after"):
        estimator.step(5, 0.0, [])


def test_errors_and_innovations_have_the_covariance_the_filter_states():
    # 4000 ticks: mean NIS of one reading is 1 +- 3 sqrt(2/4000); NEES of two states is 2
    states, readings, commands = simulate(4000, seed=11)
    estimator = make()
    nis, nees = [], []
    for k in range(4000):
        estimate = estimator.step(k, commands[k - 1] if k else 0.0, [Measurement("position", readings[k], k)])
        nis.append(estimator.innovations["position"].nis)
        error = estimate - states[k]
        nees.append(error @ np.linalg.solve(estimator.covariance, error))
    assert np.mean(nis) == pytest.approx(1.0, abs=3.0 * math.sqrt(2.0 / 4000))
    # the errors are correlated over about 10 ticks
    assert np.mean(nees) == pytest.approx(2.0, abs=3.0 * 2.0 * math.sqrt(10.0 / 4000))


def test_a_stream_that_the_model_does_not_foresee_is_followed_and_a_lone_outlier_in_it_is_not():
    """A position that runs away steadily: each reading continues what the last one said against the prediction."""
    kalman = make(gate=9.0)
    for k in range(1, 80):
        value = 0.02 * k * k * DT
        kalman.step(k, 0.0, [Measurement("position", value + (5.0 if k == 60 else 0.0), k)])
        assert kalman.innovations["position"].accepted == (k != 60), k
    assert kalman.estimate[0] == pytest.approx(0.02 * 79**2 * DT, rel=0.2)


def test_a_sensor_that_jumps_is_not_a_stream():
    kalman = make()
    for k in range(1, 60):
        kalman.step(k, 0.0, [Measurement("position", 5.0 if k > 30 else 0.0, k)])
        assert kalman.innovations["position"].accepted == (k <= 30)


@pytest.mark.parametrize("offset", [-0.5, -0.2, 0.3, 0.5])
def test_a_reading_between_two_ticks_is_compared_with_the_state_at_its_own_time(offset):
    """What is left of a wave of 1 rad/s at ticks of 0.1 s is its third difference, 1e-3; rounded off, it were 0.1."""
    kalman = make()
    row, change, bend = row_with_differences(kalman.measurements["position"].row, kalman.model)
    row = row + offset * change + 0.5 * offset * (offset - 1.0) * bend
    later = scipy.linalg.fractional_matrix_power(kalman.model.A, offset).real
    assert row @ [1.0, 2.0] == pytest.approx(float(kalman.measurements["position"].row @ later @ [1.0, 2.0]), abs=1e-3)


def test_an_estimator_that_is_reset_goes_on_as_a_new_one_and_works_on_the_same_memory():
    used, new, random = make(), make(), np.random.default_rng(4)
    kalman = used.kalman
    for tick in range(1, 30):
        used.step(tick, 0.0, [Measurement("position", float(random.standard_normal()), tick - tick % 3)])
    used.reset()
    assert used.kalman is kalman
    for tick in range(40, 60):
        reading = [Measurement("position", float(random.standard_normal()), tick - tick % 3)]
        np.testing.assert_array_equal(used.step(tick, 0.1, reading), new.step(tick, 0.1, reading))
        np.testing.assert_equal(used.innovations, new.innovations)
    np.testing.assert_array_equal(used.covariance, new.covariance)
    assert used.refusals == new.refusals
