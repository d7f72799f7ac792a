"""The filter beside Gaussian conditioning of a whole record at once, and what holds for any input.

It has a second twin, by filterpy, in the controller's tests.
"""

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from heave_core.filter import Drag, FilterModel, Gate, KalmanFilter, check_sizes, no_slack
from heave_core.filter_table import USED
from hypothesis import given, settings
from hypothesis import strategies as st

N, M, KEPT = 4, 3, 6
NO_WEIGHTS = (-1.0, 0.0, -1.0, 0.0)
OPEN = 1e12
"""Gate that refuses nothing."""


def model_of(seed, order=N, measurements=M):
    """Return a random stable model of an `order` with some `measurements`."""
    random = np.random.default_rng(seed)
    F = random.standard_normal((order, order))
    F *= 0.95 / np.max(np.abs(np.linalg.eigvals(F)))
    root = 0.3 * random.standard_normal((order, order))
    rows = random.standard_normal((measurements, order))
    change = rows @ F - rows
    return FilterModel(
        F=F,
        B=random.standard_normal(order),
        Q=root @ root.T,
        drag=Drag(),
        slack=no_slack(order, measurements),
        rows=rows,
        changes=change,
        bends=change @ F - change,
        scale_states=np.full(measurements, -1),
        is_gated=np.ones(measurements, dtype=bool),
    )


def filter_of(model, *, gate=OPEN, kept=KEPT, limit=3):
    n = len(model.B)
    return KalmanFilter(model, Gate(gate, limit, np.eye(n)), kept, np.zeros(n), np.eye(n))


def reading(tick, which=0, value=0.0, variance=0.04):
    return (tick, which, value, 0.0, variance, *NO_WEIGHTS)


record = st.lists(
    st.tuples(
        st.floats(-1.0, 1.0),
        st.lists(st.tuples(st.integers(0, M - 1), st.floats(-3.0, 3.0), st.integers(0, 3)), max_size=5),
    ),
    min_size=1,
    max_size=9,
)
"""Ticks: command, and readings as measurement, value, and by how many ticks they come late."""


def conditioned(model, told):
    """Return mean and covariance of the last state, all that is `told` being jointly normal.

    The states of all ticks are one normal vector; the readings are taken in by one least-squares solution.
    """
    n, count = len(model.B), len(told)
    mean, joint = np.zeros(n * count), np.zeros((n * count, n * count))
    joint[:n, :n] = np.eye(n)
    for k in range(1, count):
        here, before = slice(n * k, n * k + n), slice(n * k - n, n * k)
        mean[here] = model.F @ mean[before] + model.B * told[k][0]
        joint[here, : n * k] = model.F @ joint[before, : n * k]
        joint[: n * k, here] = joint[here, : n * k].T
        joint[here, here] = model.F @ joint[before, before] @ model.F.T + model.Q
    rows, values = [], []
    for k, (_, delivered) in enumerate(told):
        for which, value, late in delivered:
            row, tick = np.zeros(n * count), max(k - late, 0)
            row[n * tick : n * tick + n] = model.rows[which]
            rows.append(row)
            values.append(value)
    if rows:
        H = np.array(rows)
        S = H @ joint @ H.T + 0.04 * np.eye(len(rows))
        K = np.linalg.solve(S, H @ joint).T
        mean, joint = mean + K @ (np.array(values) - H @ mean), joint - K @ H @ joint
    return mean[-n:], joint[-n:, -n:]


@settings(max_examples=100, deadline=None)
@given(told=record, seed=st.integers(0, 2**16))
def test_the_estimate_is_the_conditional_mean_of_all_that_was_read_however_late_it_came(told, seed):
    model = model_of(seed)
    kalman = filter_of(model)
    for k, (command, delivered) in enumerate(told):
        rows = sorted(reading(max(k - late, 0), which, value) for which, value, late in delivered)
        kalman.run([(k, command, len(rows))], rows)
    mean, covariance = conditioned(model, told)
    scale = 1.0 + np.max(np.abs(mean))
    np.testing.assert_allclose(kalman.x, mean, rtol=0.0, atol=1e-9 * scale)
    np.testing.assert_allclose(kalman.P, covariance, rtol=0.0, atol=1e-9)


@settings(max_examples=30, deadline=None)
@given(told=record, seed=st.integers(0, 2**16))
def test_a_covariance_stays_symmetric_to_the_bit_and_has_no_negative_variance(told, seed):
    kalman = filter_of(model_of(seed))
    for k, (command, delivered) in enumerate(told):
        rows = sorted(reading(k - late, which, value, 1e-6) for which, value, late in delivered)
        kalman.run([(k, command, len(rows))], rows)
        np.testing.assert_array_equal(kalman.P, kalman.P.T)
        assert np.all(np.linalg.eigvalsh(kalman.P) > -1e-12)


def test_a_copy_of_the_state_is_the_filter_at_that_tick():
    kalman, random = filter_of(model_of(3)), np.random.default_rng(1)
    ticks = [(k, 0.1 * k, [reading(k - k % 3, k % M, random.standard_normal())]) for k in range(30)]
    for number, command, rows in ticks[:20]:
        kalman.run([(number, command, 1)], rows)
    then, ends = kalman.state.copy(), []
    for _ in range(2):
        kalman.state[:] = then
        said = [kalman.run([(number, command, 1)], rows) for number, command, rows in ticks[20:]]
        ends.append((str(said), kalman.x.tobytes(), kalman.P.tobytes()))
    assert ends[0] == ends[1]


def test_a_reading_that_is_too_old_is_refused_and_changes_nothing():
    kalman, without = filter_of(model_of(5)), filter_of(model_of(5))
    for one, rows in ((kalman, [reading(20 - KEPT)]), (without, [])):
        one.run([(k, 0.1, 0) for k in range(20)], [])
        said = one.run([(20, 0.1, len(rows))], rows)
        assert not rows or (np.isnan(said[0][:3]).all() and said[0][3] == 0.0)
    assert kalman.state.tobytes() == without.state.tobytes()


def test_a_reading_for_which_there_is_no_place_is_refused():
    """The work of a tick is bounded: of one tick no more readings are kept than there are places."""
    room = USED // KEPT
    rows = [reading(20, k % M, 0.1) for k in range(room)]
    runs = []
    for more in ([], [reading(20, 1, 0.5)] * 3):
        kalman = filter_of(model_of(5))
        said = kalman.run([(20, 0.0, room + len(more))], [*rows, *more])
        assert [one[3] for one in said] == [1.0] * room + [0.0] * len(more)
        runs.append(kalman.x)
    np.testing.assert_array_equal(*runs)


def test_ticks_may_have_negative_numbers():
    late, plain = filter_of(model_of(2)), filter_of(model_of(2))
    for kalman, first in ((late, -8), (plain, 100)):
        for k in range(first, first + 12):
            kalman.run([(k, 0.2, 1)], [reading(k - (k - first) % 3, 0, 0.1 * (k - first))])
    np.testing.assert_array_equal(late.x, plain.x)


@pytest.mark.parametrize(
    ("sizes", "words"),
    [
        ((97, 4, 21), r"^estimator: 97 states, and at most 96 fit: .*command_delay"),
        ((17, 17, 21), r"^estimator: 17 measurements, and at most 16 fit: use fewer sensors$"),
        ((40, 4, 1001), r"^estimator: 1001 ticks of 40 states are kept, and at most 256 fit: lower .*largest_age$"),
        ((90, 4, 201), r"^estimator: 201 ticks of 90 states are kept, and at most 125 fit"),
    ],
)
def test_a_model_that_does_not_fit_is_refused_in_one_line(sizes, words):
    with pytest.raises(ValueError, match=words) as error:
        check_sizes(*sizes)
    assert "\n" not in str(error.value)


def test_the_largest_model_that_fits_runs():
    """The estimate of 96 states from 16 sensors, half of the ticks late, stays that of a run in time."""
    model = model_of(7, order=96, measurements=16)
    runs = []
    for late in (0, 2):
        kalman = filter_of(model, kept=48)
        for k in range(12):
            due = k if late == 0 else k - 2
            rows = [reading(due, which, math.sin(which + due)) for which in range(16)] if 0 <= due < 10 else []
            kalman.run([(k, 0.1, len(rows))], rows)
        runs.append((kalman.x, kalman.P))
    np.testing.assert_allclose(runs[0][0], runs[1][0], atol=1e-9)
    np.testing.assert_allclose(runs[0][1], runs[1][1], atol=1e-9)


def test_a_long_record_lets_other_threads_run():
    """ctypes releases the lock: two filters in two threads give what each alone gives."""
    model = model_of(1, order=60)
    ticks = [(k, 0.1, k + 1) for k in range(400)]
    rows = [reading(k, k % M, math.sin(0.1 * k)) for k in range(400)]
    alone = filter_of(model)
    alone.run(ticks, rows)
    several = [filter_of(model) for _ in range(2)]
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda one: one.run(ticks, rows), several))
    for one in several:
        np.testing.assert_array_equal(one.x, alone.x)
