"""Samples without a time, taken at a known rate: true times made here, delays and losses on the way."""

import math

import numpy as np
import pytest
from heave_devices.live.counted_time import JUDGED, CountedTime, DeviceClock

RATE = 20.0


def counted(taken, delay):
    """Times that the count gives for samples `taken` at these times, each arriving after a delay and in order."""
    clock = CountedTime(RATE)
    arrivals = np.maximum.accumulate(taken + delay)
    return np.array([clock.time(now) for now in arrivals])


def test_what_a_busy_machine_hands_over_late_gets_a_tenth_of_the_error_of_its_arrival():
    rng = np.random.default_rng(3)
    taken = 100.0 + np.arange(2400) / RATE
    late = np.where(rng.random(2400) < 0.15, rng.exponential(0.08, 2400), 0.0)
    by_arrival = (np.maximum.accumulate(taken + late) - taken)[40:]
    error = (counted(taken, late) - taken)[40:]
    assert np.max(np.abs(error)) < 0.1 * np.max(by_arrival)
    assert np.sqrt(np.mean(error**2)) < 0.1 * np.sqrt(np.mean(by_arrival**2))


def test_a_burst_gets_the_times_at_which_its_samples_were_taken():
    taken = 100.0 + np.arange(200) / RATE
    delay = np.zeros(200)
    delay[100:115] = taken[115] - taken[100:115]  # 0.75 s of them arrive at once
    assert counted(taken, delay) == pytest.approx(taken, abs=1e-9)


@pytest.mark.parametrize("lost", [1, 3, 12])
def test_lost_samples_are_made_up_for_within_half_a_second(lost):
    taken = 100.0 + np.delete(np.arange(400), np.arange(200, 200 + lost)) / RATE
    error = counted(taken, np.zeros(taken.size)) - taken
    assert error[:200] == pytest.approx(0.0, abs=1e-9)
    assert error[200] == pytest.approx(-lost / RATE), "the line might as well be late"
    assert error[200 + JUDGED :] == pytest.approx(0.0, abs=1e-9)


def test_a_line_that_was_silent_begins_the_count_again():
    taken = np.concatenate((100.0 + np.arange(100) / RATE, 125.0 + np.arange(100) / RATE))
    assert counted(taken, np.zeros(200)) == pytest.approx(taken, abs=1e-9)


@pytest.mark.parametrize("true_rate", [19.9, 20.1])
def test_a_device_half_a_percent_off_its_stated_rate_is_followed(true_rate):
    taken = 100.0 + np.arange(6000) / true_rate
    assert np.max(np.abs(counted(taken, np.zeros(6000)) - taken)) < 0.1 / RATE


def test_times_always_go_on():
    rng = np.random.default_rng(5)
    taken = 100.0 + np.sort(rng.integers(0, 2000, 1500)) / RATE  # some twice, some missing
    assert np.all(np.diff(counted(taken, rng.exponential(0.2, 1500))) > 0.0)


def test_a_counter_that_begins_anew_goes_on_and_is_counted():
    clock = DeviceClock()
    times = [clock.time(own, now) for own, now in ((100.0, 0.0), (100.02, 0.03), (0.5, 3.03), (0.52, 3.05))]
    assert times == [pytest.approx(want, abs=1e-3) for want in (100.0, 100.02, 103.02, 103.05)], "the least delay is 0"
    assert clock.restarts == 1


def test_after_a_restart_no_sample_is_stamped_before_it_was_taken():
    """Delays of 0 to 0.1 s: a sample that was late before the restart made all after it seem late for a minute."""
    rng = np.random.default_rng(2)
    for _ in range(20):
        clock, taken = DeviceClock(), 50.0 + np.arange(400) / RATE
        arrivals = np.maximum.accumulate(taken + rng.uniform(0.0, 0.1, 400))
        own = np.where(taken < 60.0, taken, taken - 59.0)
        times = np.array([clock.time(o, a) for o, a in zip(own, arrivals, strict=True)])
        assert clock.restarts == 1
        errors = np.delete(times - taken, 200)  # but the first after it, which is not confirmed
        assert -0.02 < min(errors) <= max(errors) < 0.11


@pytest.mark.parametrize("delay", [0.0, 0.9, 5.0])
def test_a_delay_is_no_restart(delay):
    """Samples of 50 Hz that a link holds back, and then hands over all at once."""
    clock = DeviceClock()
    for k in range(200):
        own = 7.0 + 0.02 * k
        assert clock.time(own, max(own, 8.0 + delay) if own > 8.0 else own) == own
    assert clock.restarts == 0


def test_while_a_clock_of_whole_seconds_stands_the_arrivals_count():
    """20 Hz, delays of up to 20 ms: no time is off by more than a step of the samples and their delay."""
    rng = np.random.default_rng(7)
    taken = 100.013 + np.arange(1200) / RATE
    clock = DeviceClock()
    times = np.array([clock.time(float(np.floor(t)), t + rng.uniform(0.0, 0.02)) for t in taken])
    assert np.all(np.diff(times) > 0.0), "none is refused for a time that came before"
    assert np.ptp(times - taken) < 1.0 / RATE + 0.02
    assert clock.standing == 1200 - np.unique(np.floor(taken)).size


@pytest.mark.parametrize(("scale", "restart"), [(1.0, 0.0), (1000.0, 0.0), (1e-3, 0.0), (1.0, 50.0), (0.0, 0.0)])
def test_a_clock_of_another_unit_is_known_by_its_rate_and_one_that_restarts_is_not(scale, restart):
    clock = DeviceClock()
    for k in range(300):
        now = 60.0 + 0.05 * k
        clock.time(scale * (now - (restart if k > 100 else 0.0)), now)
    assert clock.rate == pytest.approx(scale, abs=1e-9)


def test_a_program_that_halts_for_a_while_has_no_other_rate():
    """A counter of cycles that stands for 4 s, and goes on from there."""
    clock = DeviceClock()
    for k in range(600):
        now = 60.0 + 0.05 * k
        clock.time(now - min(max(now - 75.0, 0.0), 4.0), now)
        assert math.isnan(clock.rate) or clock.rate == pytest.approx(1.0, abs=0.01)
