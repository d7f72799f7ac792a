"""Heave from a height and from a velocity: the transfer function, to the theory's gain and phase."""

import cmath
import math

import numpy as np
import pytest
from heave_node.devices.live.high_pass import HighPass

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
