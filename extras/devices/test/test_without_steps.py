"""The simulated ship goes on smoothly where its sensor does not: spikes, a frozen sensor, a new zero."""

import math

import numpy as np
import pytest
from heave_devices.live.without_steps import GLIDE, WithoutSteps

DT = 0.05
TIMES = np.arange(0.0, 60.0, DT)
SHIP = 1.5 * np.sin(0.7 * TIMES)
"""A ship that accelerates by 0.74 m/s^2 at most."""


def moved(readings):
    follower = WithoutSteps()
    return np.array([follower.at(time, value) for time, value in zip(TIMES, readings, strict=True)])


def test_a_sound_sensor_is_followed_to_the_bit():
    assert np.array_equal(moved(SHIP), SHIP)
    noisy = SHIP + np.random.default_rng(1).normal(0.0, 0.02, TIMES.size)
    assert np.array_equal(moved(noisy), noisy)


def test_a_spike_does_not_move_the_ship():
    readings = SHIP.copy()
    readings[600] += 5.0
    assert np.abs(moved(readings) - SHIP).max() < 0.02, "of 5 m"


@pytest.mark.parametrize("kind", ["frozen", "zero"])
def test_after_a_step_the_ship_goes_on_from_where_it_was_and_is_where_it_is_read_after_the_glide(kind):
    readings = SHIP + (TIMES >= 30.0) if kind == "zero" else np.where((TIMES > 30.0) & (TIMES < 34.0), SHIP[600], SHIP)
    ship = moved(readings)
    largest = 1.5 * 0.7**2 + math.pi**2 / (2.0 * GLIDE**2) * 3.0  # of the sea, and of half a cosine of 3 m
    after = np.abs(np.diff(ship, 2))[602 if kind == "frozen" else 1 :] / DT**2
    assert np.abs(np.diff(ship)).max() < 0.1, "no jump"
    assert np.sort(after)[-4] < largest + 0.1
    assert ship[-1] == readings[-1]
