"""The boom tip's motion from that of the sensor, against a rotation matrix and its derivative."""

import math

import numpy as np
import pytest
from heave_devices.live.tip_motion import GLIDE, TipMotion, WithoutSteps
from heave_node.sensing.recent_motion import RecentMotion
from scipy.spatial.transform import Rotation

ARM = (20.0, -8.0, 15.0)
NAN = (math.nan, math.nan)


def attitude(t):
    return 0.08 * math.sin(0.7 * t), 0.05 * math.sin(0.55 * t + 1.0)


def raised(t):
    """Return how much higher than at rest the tip is: R_y(pitch) R_x(roll) arm, its third component."""
    return float(Rotation.from_euler("xy", attitude(t)).apply(ARM)[2]) - ARM[2]


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
    for t, heave, rate, sigma in carried(with_rates=True):
        assert sigma == 0.0, "nothing is added to that of the sensor"
        # the running mean follows a wave by 1 / (omega tau) of its amplitude of 1.6 m: 1 / (0.55 * 300)
        assert heave == pytest.approx(0.1 + raised(t) - mean, abs=0.015)
        assert rate == pytest.approx(0.2 + rate_of(raised, t), abs=1e-6)


@pytest.mark.parametrize("start", np.arange(0.0, 12.0, 1.5))
def test_from_the_start_the_rate_is_the_derivative_of_the_heave(start):
    """A mean that began at the first reading drifted by the roll and pitch of that moment for a minute: 1 m here.

    The rate knew nothing of it, and the controller identified a high-pass filter of 30 s in a sensor that has none.
    """
    tip, step = TipMotion(ARM), 0.05
    times = start + step * np.arange(round(60.0 / step))
    mean = np.mean([raised(t) for t in np.arange(0.0, 2000.0, 0.05)])
    turning = [tuple(rate_of(lambda u, k=k: attitude(u)[k], t) for k in (0, 1)) for t in times]
    heave, rate, _ = np.array([tip.carry(t, 0.0, 0.0, attitude(t), w) for t, w in zip(times, turning, strict=True)]).T
    integral = np.concatenate([[0.0], np.cumsum(0.5 * step * (rate[1:] + rate[:-1]))])
    assert np.ptp((heave - integral)[20:]) < 0.15
    late = times > start + 20.0  # before compensation can start
    assert np.abs(heave - [raised(t) - mean for t in times])[late].max() < 0.2


def test_without_turn_rates_the_rate_follows_from_the_attitude():
    for t, _, rate, _ in carried(with_rates=False, end=300.0):
        assert rate == pytest.approx(0.2 + rate_of(raised, t), abs=0.02)


@pytest.mark.parametrize("noise", [3e-4, 1e-3])
@pytest.mark.parametrize("rate", [10.0, 25.0, 50.0])
def test_the_noise_of_the_attitude_is_in_the_uncertainty_of_the_rate(noise, rate):
    """The slope of a parabola through n readings over T is sqrt(192 / n) s / T uncertain at its end, s their noise."""
    tip, rng = TipMotion(ARM), np.random.default_rng(1)
    found = []
    for t in np.arange(0.0, 420.0, 1.0 / rate):
        read = tuple(np.array(attitude(t)) + rng.normal(0.0, noise, 2))
        _, carried_rate, sigma = tip.carry(t, 0.0, 0.0, read, NAN)
        found.append((carried_rate - rate_of(raised, t), sigma))
    error, sigma = np.array(found[round(300.0 * rate) :]).T  # the mean has settled
    assert np.median(sigma) == pytest.approx(error.std(), rel=0.15)
    size = noise * math.hypot(*ARM[:2])
    assert np.median(sigma) == pytest.approx(math.sqrt(192.0 / (0.6 * rate)) / 0.6 * size, rel=0.25)


def test_a_sensor_that_is_frozen_stays_frozen_at_the_boom_tip():
    """Its running mean went on, and no reading was like the one before: it was never taken for frozen."""
    tip = TipMotion(ARM)
    times = np.arange(0.0, 40.0, 0.04)
    carried = [tip.carry(t, math.sin(min(t, 30.0)), math.cos(min(t, 30.0)), attitude(min(t, 30.0)), NAN) for t in times]
    assert len(set(carried[: np.searchsorted(times, 30.0)])) > 700
    assert len(set(carried[np.searchsorted(times, 30.0) + 1 :])) == 1


def test_trim_and_list_do_not_lift_the_tip():
    tip = TipMotion(ARM)
    heave = [tip.carry(0.1 * n, 0.0, 0.0, (0.02, -0.03), (0.0, 0.0))[0] for n in range(100)]
    assert heave == pytest.approx([0.0] * 100)


def test_without_an_arm_nothing_changes_and_without_attitude_nothing_is_known():
    assert TipMotion((0.0, 0.0, 0.0)).carry(0.0, 0.5, math.nan, NAN, NAN)[0] == 0.5
    assert all(map(math.isnan, TipMotion(ARM).carry(0.0, 0.5, 0.1, NAN, NAN)))


DT = 0.05
TIMES = np.arange(0.0, 60.0, DT)
SHIP = 1.5 * np.sin(0.7 * TIMES)
"""A ship that accelerates by 0.74 m/s^2 at most."""


def moved(readings):
    tip = RecentMotion()
    follower = WithoutSteps(tip)
    ship = []
    for time, value in zip(TIMES, readings, strict=True):
        ship.append(follower.at(time, value) if math.isfinite(value) else math.nan)
        if math.isfinite(value):
            tip.add(time, ship[-1])
    return np.array(ship)


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


@pytest.mark.parametrize("back", [430, 480, 800])
def test_after_a_silence_the_ship_goes_on_from_where_the_boom_tip_stands(back):
    """After a second without readings it stands where they led; the ship may be elsewhere by metres then."""
    readings = SHIP.copy()
    readings[401:back] = math.nan
    ship = moved(readings)
    after = ship[back:]
    assert abs(after[0] - SHIP[420]) < 0.1
    assert np.abs(np.diff(after)).max() < 0.15, "no jump"
    assert ship[-1] == SHIP[-1]
