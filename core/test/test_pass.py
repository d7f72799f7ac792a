"""A pass over a record beside filterpy, column by column; drag and slack have a twin in the loop's filter."""

import filterpy.kalman
import numpy as np
import pytest
from heave_core.filter import follow
from hypothesis import given, settings
from hypothesis import strategies as st

N, TICKS = 5, 12


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**16), columns=st.integers(1, 9), each=st.integers(0, 3))
def test_each_column_is_what_a_filter_of_its_own_makes_of_it(seed, columns, each):
    random = np.random.default_rng(seed)
    F, B, root = random.standard_normal((N, N)), random.standard_normal(N), random.standard_normal((N, N))
    F *= 0.95 / np.max(np.abs(np.linalg.eigvals(F)))
    F[random.random((N, N)) < 0.4] = 0.0
    Q, count = 0.1 * root @ root.T, TICKS * each
    which, offsets = random.integers(0, 4, count), random.choice([0.0, -0.3, 0.4], count)
    tables, noise, used = random.standard_normal((3, 4, N)), random.uniform(0.1, 1.0, count), random.random(count) < 0.8
    values, commands = random.standard_normal((count, columns)), random.standard_normal((TICKS, columns))
    ticks = np.column_stack((np.ones(TICKS), np.zeros(TICKS), np.zeros(TICKS), each * np.arange(1, TICKS + 1)))
    state, covariance = np.zeros((N, columns)), np.eye(N)
    made = (state, covariance)
    readings = np.column_stack((which, offsets, noise, used.astype(float)))
    # Newton's formula: row + offset (first difference) + offset (offset - 1)/2 (second difference)
    binomials = np.array([np.ones(count), offsets, offsets * (offsets - 1.0) / 2.0])
    rows = np.einsum("tm,tmn->mn", binomials, tables[:, which])
    innovations, variances = follow((F, B, Q, np.zeros(N), 0), ticks, commands, readings, tables, values, *made)
    for column in range(columns):
        peer = filterpy.kalman.KalmanFilter(dim_x=N, dim_z=1, dim_u=1)
        peer.x, peer.P, peer.F, peer.B, peer.Q = np.zeros((N, 1)), np.eye(N), F, B[:, None], Q
        place = 0
        for tick in range(TICKS):
            peer.predict(u=np.array([[commands[tick, column]]]))
            for _ in range(each):
                row, value = rows[place], values[place, column]
                spread = float(row @ peer.P @ row) + noise[place]
                assert variances[place] == pytest.approx(spread, rel=1e-9)
                expected = (value - float(row @ peer.x[:, 0])) / np.sqrt(spread)
                assert innovations[place, column] == pytest.approx(expected, abs=1e-9)
                if used[place]:
                    peer.update(value, R=noise[place], H=row[None, :])
                place += 1
        np.testing.assert_allclose(state[:, column], peer.x[:, 0], atol=1e-9)
    np.testing.assert_allclose(covariance, peer.P, atol=1e-9)


def test_a_model_that_does_not_fit_is_refused_in_one_line():
    n = 97
    motion = (np.eye(n), np.zeros(n), np.eye(n), np.zeros(n), 0)
    none = np.zeros((0, 1))
    with pytest.raises(ValueError, match=r"^pass: 97 states, and at most 96 fit: use longer ticks"):
        follow(motion, np.zeros((0, 4)), none, np.zeros((0, 4)), np.zeros((3, 0, n)), none, np.zeros((n, 1)), np.eye(n))
