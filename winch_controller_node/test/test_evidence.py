"""The likelihood with the noise profiled out, and its best under a correction, against a plain search."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar
from winch_controller_node.adviser.evidence import FACTORS, TIE, Evidence, evidence

STARTS = 1.0 / FACTORS - 1.0


def drawn(seed, measurements, columns, noise):
    """Return evidence of innovations drawn at random, some measurements of which a column explains in part."""
    random = np.random.default_rng(seed)
    grams = []
    for _ in range(measurements):
        basis = random.standard_normal((60, columns)) * random.uniform(0.0, 3.0, columns)
        weights = random.uniform(-3.0, 3.0, columns) * (random.uniform(size=columns) < 0.5)
        basis[:, 0] = basis @ weights + noise * random.standard_normal(60)
        grams.append(basis.T @ basis / 60)
    return Evidence(np.array(grams), random.normal(size=measurements), random.uniform(5.0, 60.0, measurements))


def loss_at(proof, column, weight):
    """Loss as its definition says: N/2 (log max(q, 1) + mean log S), q of the record and `weight` times a column."""
    total = 0.0
    for gram, spread, count in zip(proof.grams, proof.spreads, proof.counts, strict=True):
        w = np.zeros(len(gram))
        w[0], w[column] = 1.0, weight
        total += 0.5 * count * (math.log(max(float(w @ gram @ w), 1.0)) + spread)
    return total


@settings(max_examples=60)
@given(st.integers(0, 2**31), st.integers(1, 4), st.floats(0.1, 3.0))
def test_no_other_weight_explains_a_record_better(seed, measurements, noise):
    """A search over a fine grid, and about its best by Brent's method; losses that differ by TIE are as good."""
    proof = drawn(seed, measurements, 4, noise)
    grid = np.concatenate([STARTS, np.linspace(-12.0, 12.0, 241)])
    for column, fitted in enumerate(proof.fit(np.arange(1, 4), grid), start=1):
        best = min(grid, key=lambda weight: loss_at(proof, column, weight))
        near = (best - 0.1, best + 0.1)
        found = minimize_scalar(
            lambda weight, column=column: loss_at(proof, column, weight), bounds=near, method="bounded"
        )
        assert fitted.loss <= min(found.fun, loss_at(proof, column, best)) + TIE
        assert loss_at(proof, column, fitted.weight) <= fitted.loss + TIE + 1e-9


@given(st.integers(0, 2**31), st.floats(1.5, 3.0), st.floats(-3.0, 3.0))
def test_a_single_measurement_has_its_least_squares_and_their_standard_deviation(seed, noise, weight):
    """The best weight is -b/c; the curvature of the loss there, N c / q, is taken from the loss itself."""
    random = np.random.default_rng(seed)
    columns = random.standard_normal((200, 2))
    columns[:, 0] = -weight * columns[:, 1] + noise * random.standard_normal(200)
    gram = columns.T @ columns / 200
    proof = Evidence(gram[None], np.zeros(1), np.array([40.0]))
    (fitted,) = proof.fit(np.array([1]), STARTS)
    assert fitted.weight == pytest.approx(-gram[0, 1] / gram[1, 1], rel=1e-9)
    h = 1e-3
    curvature = sum(s * loss_at(proof, 1, fitted.weight + d) for s, d in ((1.0, h), (-2.0, 0.0), (1.0, -h))) / h**2
    assert fitted.sigma == pytest.approx(curvature**-0.5, rel=1e-3)
    assert fitted.misfits[0] == pytest.approx(gram[0, 0] - gram[0, 1] ** 2 / gram[1, 1], rel=1e-9)


@given(st.integers(0, 2**31))
def test_the_record_as_it_is_has_no_weight(seed):
    proof = drawn(seed, 3, 3, 1.0)
    plain = proof.plain()
    assert (plain.weight, plain.sigma) == (0.0, 0.0)
    assert plain.loss == pytest.approx(loss_at(proof, 1, 0.0))
    np.testing.assert_array_equal(plain.misfits, proof.grams[:, 0, 0])


def test_a_column_that_tells_nothing_changes_nothing():
    gram = np.diag([4.0, 0.0])
    (fitted,) = Evidence(gram[None], np.zeros(1), np.array([30.0])).fit(np.array([1]), np.array([-1.0, 0.0, 1.0]))
    assert math.isfinite(fitted.weight)
    assert fitted.loss == pytest.approx(15.0 * math.log(4.0))
    assert fitted.sigma > 1e5


def test_a_sensor_better_than_believed_earns_nothing():
    """A mean square below 1 counts as 1: no hypothesis is the better for a sensor that is quieter than assumed."""
    grams = np.array([np.diag([0.2, 1.0]), np.diag([0.9, 1.0])])
    proof = Evidence(grams, np.zeros(2), np.full(2, 50.0))
    assert proof.plain().loss == 0.0
    assert proof.loss(np.array([0.01, 1.0])) == 0.0


def test_evidence_counts_one_value_a_second_of_those_in_which_there_are_any():
    """e = 2, 3 for the first measurement, in variances of 4 and 9; none of the second; six in 4 s of the third."""
    innovations = np.array([[2.0], [3.0], *[[1.0]] * 6])
    variances = np.array([4.0, 9.0, *[1.0] * 6])
    seconds = np.array([7.0, 8.0, 1.0, 1.0, 2.0, 3.0, 30.0, 30.0])
    proof = evidence(innovations, variances, np.array([0, 0, 2, 2, 2, 2, 2, 2]), 3, seconds)
    assert list(proof.counts) == [2.0, 0.0, 4.0]
    assert proof.grams[0, 0, 0] == pytest.approx((4.0 + 9.0) / 2.0)
    assert proof.spreads[0] == pytest.approx(0.5 * (math.log(4.0) + math.log(9.0)))
    assert proof.plain().loss == pytest.approx(0.5 * 2.0 * (math.log(6.5) + proof.spreads[0]))
