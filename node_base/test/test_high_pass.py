"""Heave from a height and from a velocity: the transfer function, to the theory's gain and phase."""

import cmath
import math

import numpy as np
import pytest
from heave_node.numerics.high_pass import HighPass

PERIOD, SWELL, STEP = 200.0, 10.0, 0.05
TIME = STEP * np.arange(round(1000.0 / STEP))
OMEGA = 2.0 * math.pi / SWELL


def response(values):
    """Return amplitude and phase of the last swells as a complex number."""
    last = slice(-round(20 * SWELL / STEP), None)
    return 2.0 * np.mean(np.asarray(values)[last] * np.exp(-1j * OMEGA * TIME[last]))


def expected():
    s, w = 1j * OMEGA, 2.0 * math.pi / PERIOD
    return s * s / (s * s + 2.0 * 0.7 * w * s + w * w)


def test_a_height_about_any_datum_becomes_heave():
    filtered = HighPass(PERIOD)
    heave = [filtered.add(t, 47.3 + math.cos(OMEGA * t)) for t in TIME]
    found = response(heave)
    assert abs(found) == pytest.approx(abs(expected()), rel=2e-3)
    assert cmath.phase(found) == pytest.approx(cmath.phase(expected()), abs=2e-3)
    assert np.mean(heave[-round(SWELL / STEP) :]) == pytest.approx(0.0, abs=1e-3)


def test_a_velocity_with_a_constant_error_becomes_heave():
    filtered = HighPass(PERIOD)
    heave = [filtered.add_rate(t, 0.03 - OMEGA * math.sin(OMEGA * t)) for t in TIME]
    found = response(heave)
    assert abs(found) == pytest.approx(abs(expected()), rel=5e-3)
    assert cmath.phase(found) == pytest.approx(cmath.phase(expected()), abs=5e-3)
    assert np.mean(heave[-round(SWELL / STEP) :]) == pytest.approx(0.0, abs=1e-3)


def test_it_says_when_it_has_settled_and_begins_anew_after_a_gap():
    filtered = HighPass(30.0)
    filtered.add(0.0, 5.0)
    assert not filtered.is_settled
    for n in range(1, 120):
        filtered.add(0.1 * n, 5.0)
    assert filtered.is_settled
    assert filtered.add(100.0, 80.0) == 0.0
    assert not filtered.is_settled


def test_a_late_or_repeated_sample_changes_nothing():
    with_late, without = HighPass(30.0), HighPass(30.0)
    for n in range(200):
        t, height = 0.1 * n, math.sin(0.1 * n)
        expected_heave = without.add(t, height)
        with_late.add(t, height)
        assert with_late.add(t - 0.5 * (n % 2), height + 3.0) == expected_heave


@pytest.mark.parametrize("starts_whole", [True, False])
def test_the_first_value_passes_whole_or_is_the_datum_and_the_rate_of_both_fits(starts_whole):
    """From any start the rate that passes is the derivative of what passes, to the second order of the step."""
    filtered, step = HighPass(30.0, 0.5, starts_whole=starts_whole), 0.01
    passed = [(filtered.add(step * n, 2.0 + math.sin(step * n)), filtered.rate_taken_off) for n in range(1000)]
    assert passed[0] == ((2.0, 0.0) if starts_whole else (0.0, 0.0))
    heave, off = np.array(passed).T
    rate = np.cos(step * np.arange(1000)) - off
    assert np.diff(heave) == pytest.approx(0.5 * step * (rate[1:] + rate[:-1]), abs=1e-6)
