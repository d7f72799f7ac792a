"""The boom tip's motion from that of the sensor, against a rotation matrix and its derivative."""

import math

import numpy as np
import pytest
from heave_devices.live.tip_motion import TipMotion

ARM = (20.0, -8.0, 15.0)
NAN = (math.nan, math.nan)


def attitude(t):
    return 0.08 * math.sin(0.7 * t), 0.05 * math.sin(0.55 * t + 1.0)


def raised(t):
    """Return how much higher than at rest the tip is: R_y(pitch) R_x(roll) arm, its third component."""
    roll, pitch = attitude(t)
    x_turn = np.array([[1, 0, 0], [0, math.cos(roll), -math.sin(roll)], [0, math.sin(roll), math.cos(roll)]])
    y_turn = np.array([[math.cos(pitch), 0, math.sin(pitch)], [0, 1, 0], [-math.sin(pitch), 0, math.cos(pitch)]])
    return float((y_turn @ x_turn @ np.array(ARM))[2]) - ARM[2]


def rate_of(function, t, h=1e-5):
    return (function(t + h) - function(t - h)) / (2.0 * h)


def carried(with_rates, end=900.0, step=0.05):
    tip = TipMotion(ARM)
    found = []
    for n in range(round(end / step)):
        t = n * step
        roll, pitch = attitude(t)
        turning = tuple(rate_of(lambda u, k=k: attitude(u)[k], t) for k in (0, 1)) if with_rates else NAN
        found.append((t, *tip.carry(t, 0.1, 0.2, (roll, pitch), turning)))
    return found[-400:]


def test_heave_and_rate_are_carried_by_the_attitude_and_its_rates():
    mean = np.mean([raised(t) for t in np.arange(0.0, 2000.0, 0.05)])
    for t, heave, rate in carried(with_rates=True):
        # the running mean follows a wave by 1 / (omega tau) of its amplitude of 1.6 m: 1 / (0.55 * 300)
        assert heave == pytest.approx(0.1 + raised(t) - mean, abs=0.015)
        assert rate == pytest.approx(0.2 + rate_of(raised, t), abs=1e-6)


def test_without_turn_rates_the_rate_follows_from_the_attitude():
    for t, _, rate in carried(with_rates=False, end=60.0):
        assert rate == pytest.approx(0.2 + rate_of(raised, t), abs=0.02)


def test_trim_and_list_do_not_lift_the_tip():
    tip = TipMotion(ARM)
    heave = [tip.carry(0.1 * n, 0.0, 0.0, (0.02, -0.03), (0.0, 0.0))[0] for n in range(100)]
    assert heave == pytest.approx([0.0] * 100)


def test_without_an_arm_nothing_changes_and_without_attitude_nothing_is_known():
    assert TipMotion((0.0, 0.0, 0.0)).carry(0.0, 0.5, math.nan, NAN, NAN)[0] == 0.5
    assert all(map(math.isnan, TipMotion(ARM).carry(0.0, 0.5, 0.1, NAN, NAN)))
