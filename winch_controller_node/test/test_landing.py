"""Whether the unit stands, told from depth readings alone."""

import numpy as np
import pytest
from winch_controller_node.supervision.landing import FallRate

NOISE = 0.02
"""Depth sensor of the benchmarks: 2 cm, 10 Hz."""


def watched(depth_of, seed=1, end=3.0):
    watch, noise = FallRate(), np.random.default_rng(seed)
    for time in np.arange(0.0, end, 0.1):
        watch.add(float(time), depth_of(time) + NOISE * noise.standard_normal())
    return watch


@pytest.mark.parametrize("rate", [0.2, 0.5, 1.0])
def test_a_unit_on_the_bottom_stands_and_one_that_is_lowered_does_not(rate):
    for seed in range(20):
        assert watched(lambda time: 600.0, seed).shows_standing(rate)
        assert not watched(lambda time: 600.0 + rate * time, seed).shows_standing(rate)


def test_a_swing_unloads_the_cable_where_the_unit_falls_with_the_winch():
    """x = A cos(w t) about the mean: the cable is least loaded at the top of the swing, where x' = 0 about the mean."""
    amplitude, omega, rate = 1.0, 0.4, 1.0
    for seed in range(20):
        watch = watched(lambda time: rate * time - amplitude * np.cos(omega * (time - 3.0)), seed)
        assert watch.value == pytest.approx(rate, abs=0.3)
        assert not watch.shows_standing(rate)


def test_the_speed_is_that_of_the_last_second_only():
    watch = watched(lambda time: 600.0 + min(time, 1.5), end=3.0)
    assert abs(watch.value) < 0.1


def test_without_readings_nothing_is_known_and_the_tension_decides():
    assert FallRate().shows_standing(0.5)
