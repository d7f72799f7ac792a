"""The Kalman filter: late, missing and wrong readings; consistency."""

import math

import numpy as np
import pytest
import scipy.linalg
from heave_node.numerics.linear_model import linear_model, state_covariance
from heave_node.numerics.linear_sampling import discretise
from winch_controller_node.model.estimator import KalmanEstimator, Measurement, MeasurementModel

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


def test_a_late_reading_gives_the_estimate_it_would_have_given_in_time():
    _, readings, commands = simulate(30)
    in_time, late = make(), make()
    for k in range(30):
        before = commands[k - 1] if k else 0.0
        in_time.step(k, before, [Measurement("position", readings[k], k)] if k <= 25 else [])
        late.step(k, before, [Measurement("position", readings[k - 4], k - 4)] if k >= 4 else [])
    assert late.estimate == pytest.approx(in_time.estimate, rel=1e-9)
    assert late.covariance == pytest.approx(in_time.covariance, rel=1e-9)


def test_readings_out_of_order_give_the_same_estimate():
    _, readings, commands = simulate(12)
    ordered, mixed = make(), make()
    for k in range(12):
        before = commands[k - 1] if k else 0.0
        ordered.step(k, before, [Measurement("position", readings[k], k)])
        given = {5: [], 6: [6], 7: [5, 7]}.get(k, [k])
        mixed.step(k, before, [Measurement("position", readings[i], i) for i in given])
    assert mixed.estimate == pytest.approx(ordered.estimate, rel=1e-9)


def test_ticks_left_out_are_predicted_over():
    whole, gap = make(), make()
    whole.step(0, 0.0, [Measurement("position", 0.5, 0)])
    gap.step(0, 0.0, [Measurement("position", 0.5, 0)])
    for k in range(1, 6):
        whole.step(k, 0.2, [])
    gap.step(5, 0.2, [])
    assert gap.estimate == pytest.approx(whole.estimate, rel=1e-12)
    assert gap.covariance == pytest.approx(whole.covariance, rel=1e-12)


@pytest.mark.parametrize("wrong", [math.nan, math.inf, 50.0])
def test_a_reading_outside_the_gate_changes_nothing_and_is_named(wrong):
    estimator, clean = make(), make()
    for k in range(20):
        clean.step(k, 0.0, [Measurement("position", 0.0, k)] if k < 19 else [])
        estimator.step(k, 0.0, [Measurement("position", 0.0 if k < 19 else wrong, k)])
    assert estimator.estimate == pytest.approx(clean.estimate, rel=1e-12)
    assert not estimator.innovations["position"].accepted
    assert estimator.refusals["position"] == 1


def test_a_reading_older_than_the_memory_is_refused():
    estimator = make(largest_age=3)
    for k in range(10):
        estimator.step(k, 0.0, [])
    before = estimator.estimate.copy()
    estimator.step(10, 0.0, [Measurement("position", 0.3, 6)])
    assert not estimator.innovations["position"].accepted
    assert estimator.estimate == pytest.approx(estimator.model.A @ before)


def test_a_plant_that_was_thrown_off_is_found_again():
    estimator = make(gate_limit=10)
    truth = np.zeros(2)
    for k in range(60):
        estimator.step(k, 0.0, [Measurement("position", float(truth[0]), k)])
        truth = estimator.model.A @ truth + (30.0 if k == 20 else 0.0) * np.array([1.0, 0.0])
    assert estimator.innovations["position"].accepted
    assert estimator.estimate == pytest.approx(truth_before(truth, estimator), abs=1.0)


def truth_before(truth, estimator):
    return np.linalg.solve(estimator.model.A, truth)


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


def test_a_scale_error_is_found_when_another_sensor_tells_the_truth():
    base, P = swing()
    A = np.block([[base.A, np.zeros((2, 1))], [np.zeros((1, 2)), np.eye(1)]])
    model = linear_model(
        A,
        states=("x", "v", "scale"),
        inputs={"u": [*base.B[:, 0], 0.0]},
        outputs={"x": [1.0, 0.0, 0.0]},
        noises={f"w{i}": [*base.G[:, i], 0.0] for i in range(base.G.shape[1])},
        dt=DT,
    )
    start = np.zeros((3, 3))
    start[:2, :2], start[2, 2] = P, 0.1**2
    row = model.row("x")
    estimator = KalmanEstimator(
        model, [MeasurementModel("scaled", "a", row, 0.05, 2), MeasurementModel("plain", "b", row, 0.2)], start
    )
    states, _, commands = simulate(3000, seed=5)
    rng = np.random.default_rng(9)
    for k in range(3000):
        scaled = 1.08 * states[k][0] + 0.05 * rng.standard_normal()
        plain = states[k][0] + 0.2 * rng.standard_normal()
        estimator.step(
            k, commands[k - 1] if k else 0.0, [Measurement("scaled", scaled, k), Measurement("plain", plain, k)]
        )
    sigma = math.sqrt(estimator.covariance[2, 2])
    assert sigma < 0.01
    assert abs(estimator.estimate[2] - 0.08) < 4.0 * sigma


def test_a_sensor_with_a_gate_of_its_own_is_never_refused_by_the_estimate():
    """The model is far more wrong than it thinks: an ungated reading takes the estimate along, a gated one does not."""
    model, P = swing()
    left = {}
    for is_gated in (True, False):
        estimator = KalmanEstimator(
            model, [MeasurementModel("position", "sensor", model.row("x"), 0.01, is_gated=is_gated)], P
        )
        for k in range(20):
            estimator.step(k, 0.0, [Measurement("position", 0.0, k)])
        for k in range(20, 40):
            estimator.step(k, 0.0, [Measurement("position", 5.0, k)])
        left[is_gated] = abs(float(estimator.estimate[0]) - 5.0)
        assert estimator.innovations["position"].accepted is not is_gated
    assert left[True] > 4.0
    assert left[False] < 0.5
    estimator.step(40, 0.0, [Measurement("position", math.nan, 40)])
    assert np.all(np.isfinite(estimator.estimate))


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
    kalman.reset(np.array([1.0, 2.0]))
    row = kalman.row_of(Measurement("position", 0.0, 0, offset=offset))
    later = scipy.linalg.fractional_matrix_power(kalman.model.A, offset).real
    assert row @ [1.0, 2.0] == pytest.approx(float(kalman.measurements["position"].row @ later @ [1.0, 2.0]), abs=1e-3)
