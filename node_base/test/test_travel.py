"""A drum that goes too far, the wrong way, or says two things of itself; and the sound ones that are let be."""

import math

import numpy as np
import pytest
from heave_node.winch.travel import OrderedTravel, SpeedTravel
from scipy.signal import lsim

STEP, LAG = 0.05, 1.0


def first_found(order_at, drum_at, duration=60.0):
    """Return when something is found [s], how far the drum then is from where it was ordered to be [m], and words."""
    travel, ordered = OrderedTravel(LAG), 0.0
    for step in range(round(duration / STEP)):
        now = STEP * step
        ordered += STEP * order_at(now)
        if words := travel.look(now, drum_at(now), order_at(now)):
            return now, abs(drum_at(now) - ordered), words
    return math.nan, math.nan, ""


def wave(now, amplitude=0.4, period=6.0):
    return amplitude * math.sin(2.0 * math.pi * now / period)


def way(now, amplitude=0.4, period=6.0):
    omega = 2.0 * math.pi / period
    return amplitude / omega * (1.0 - math.cos(omega * now))


@pytest.mark.parametrize("rate", [0.3, -0.3, 0.6])
@pytest.mark.parametrize(("times", "words"), [(3.0, "3.0 times as far"), (-1.0, "turns against the command")])
def test_three_times_as_far_or_the_wrong_way_is_found_within_a_third_of_a_second_and_a_decimetre(rate, times, words):
    """Beyond what is let be: three times as far is beyond it by the rest of its way, the wrong way by all of it."""
    now, _, found = first_found(lambda _: rate, lambda now: times * rate * now)
    assert words in found
    assert now <= 0.3
    beyond = abs(times * rate * now) - max(times, 0.0) * abs(rate) * now / 3.0 * 1.6
    assert beyond <= 0.1 + abs(times * rate) * STEP, "a decimetre, and the reading that confirms it"


@pytest.mark.parametrize("times", [3.0, -1.0, -3.0])
@pytest.mark.parametrize("start", [0.0, 1.0, 2.5])
def test_no_lull_of_the_sea_restarts_it(times, start):
    """The order passes zero every three seconds; drum of a tenth of a second, moved from any point of the wave on."""
    order = lambda now: wave(now + start)  # noqa: E731
    drum = lambda now: times * (way(now - 0.1 + start) - way(start)) if now > 0.1 else 0.0  # noqa: E731
    now, apart, found = first_found(order, drum)
    assert found
    assert apart <= 0.3
    assert now <= 1.6, "a second of it is the lag that a sound drum may have, as the order has just turned"


def test_a_set_point_of_another_unit_is_found_before_the_drum_has_gone_a_decimetre():
    """Register in m/s where mm/s is meant: 0.012 m/s becomes 1.2 m/s, by a drum that speeds up by 2 m/s2."""
    now, apart, found = first_found(lambda _: 0.012, lambda now: min(now, 0.6) ** 2 + 1.2 * max(now - 0.6, 0.0))
    assert "times as far as commanded: check unit and scale" in found
    assert now <= 0.35
    assert apart < 0.1


def test_a_drum_that_moves_without_an_order_is_named_so():
    assert "without a command to move" in first_found(lambda _: 0.0, lambda now: -0.2 * now)[2]


SYSTEMS = {
    "quick": ([1.0], [0.05, 1.0], 1.0),
    "slow": ([1.0], [0.5, 1.0], 1.0),
    "25 % too far": ([1.25], [0.15, 1.0], 1.0),
    "weak": ([0.4], [0.3, 1.0], 1.0),
    "ringing": ([1.0], [1.0 / 2.5**2, 2.0 * 0.4 / 2.5, 1.0], 1.0),
}


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("period", [3.0, 6.0, 12.0])
def test_a_sound_drum_with_its_lag_gain_and_ringing_is_let_be(name, period):
    """Speed by `scipy.signal.lsim`, delayed by 0.2 s; a random sea about the period."""
    numerator, denominator, _ = SYSTEMS[name]
    times = np.arange(0.0, 120.0, STEP)
    rng = np.random.default_rng(1)
    rates = 0.25 * sum(
        np.sin(2.0 * np.pi * times / (period * factor) + rng.uniform(0.0, 6.3)) for factor in (0.8, 1.0, 1.3, 1.9)
    )
    delayed = np.concatenate([np.zeros(4), rates[:-4]])
    _, speeds, _ = lsim((numerator, denominator), delayed, times)
    places = np.concatenate([[0.0], np.cumsum(STEP * speeds)[:-1]])
    travel = OrderedTravel(LAG)
    assert not any(travel.look(t, x, v) for t, x, v in zip(times, places, rates, strict=True))


def servo(orders, gain):
    """Return the speeds of a servo of 0.15 s with limits of 2 m/s and 1.5 m/s2 [m/s]."""
    speeds = [0.0]
    for order in np.clip(gain * orders, -2.0, 2.0):
        change = (order - speeds[-1]) * -math.expm1(-STEP / 0.15)
        speeds.append(speeds[-1] + min(max(change, -1.5 * STEP), 1.5 * STEP))
    return np.array(speeds[1:])


@pytest.mark.parametrize("gain", [0.8, 0.85, 0.9, 1.15])
def test_a_drum_of_another_gain_that_turns_back_sooner_at_its_limits_is_let_be(gain):
    """Under 2.3 m/s a sound servo stays at its 2 m/s for longer: 0.1 m against the command stopped the drive."""
    times = np.arange(0.0, 60.0, STEP)
    orders = np.interp(times % 10.0, [0.0, 3.0, 5.4, 8.0, 10.0], [0.0, -2.3, 2.3, 2.3, 0.0])
    places = np.cumsum(STEP * servo(orders, gain))
    travel = OrderedTravel(LAG)
    found = [travel.look(t, x, v) for t, x, v in zip(times, places, servo(orders, 1.0), strict=True)]
    assert not any(found)


def test_one_reading_that_is_a_spike_is_let_be():
    assert not first_found(lambda _: 0.0, lambda now: 0.2 * (abs(now - 1.0) < 1e-6))[2]


def contradiction(place_at, rate_at, duration=60.0):
    travel = SpeedTravel()
    for step in range(round(duration / STEP)):
        now = STEP * step
        travel.look(now, place_at(now), rate_at(now))
        if travel.words:
            return now, abs(place_at(now) - way(now))
    return math.nan, math.nan


@pytest.mark.parametrize(
    ("place", "rate", "latest"),
    [
        (lambda now: way(min(now, 3.7)), lambda now: wave(min(now, 3.7)), 4.9),
        (lambda now: way(now) + 0.03 * now, wave, 8.0),
        (lambda now: 0.01 * now, lambda _: 0.0, 11.0),
        (lambda now: -way(now), wave, 1.2),
        (way, lambda now: 10.0 * wave(now), 1.2),
        (way, lambda now: 0.1 * wave(now), 1.5),
    ],
    ids=["both frozen in motion", "drift at sea", "drift at rest", "sign", "speed ten times", "speed a tenth"],
)
def test_position_and_speed_that_contradict_each_other_are_found(place, rate, latest):
    assert contradiction(place, rate)[0] <= latest


@pytest.mark.parametrize("late", [-0.3, 0.0, 0.3])
@pytest.mark.parametrize("scale", [0.9, 1.0, 1.1])
def test_a_speed_that_is_filtered_rounded_biased_or_a_tenth_wrong_is_let_be(late, scale):
    rate = lambda now: round(scale * wave(now - late), 2) + 0.002  # noqa: E731
    assert math.isnan(contradiction(way, rate, 300.0)[0])
