"""The running statistics on which the guard rests, by sums and solutions that are exact."""

import math

import pytest
from winch_controller_node.core.estimation.gates.depth_jumps import largest_step
from winch_controller_node.core.supervision.checks import (
    AmplitudeCheck,
    AmplitudeLimit,
    Countdown,
    DetrendedHeave,
    RunningSigma,
)

DT = 0.5


def test_a_time_that_was_set_runs_out_once():
    countdown = Countdown(DT)
    assert not countdown.step(), "none was set"
    countdown.start(2.0)
    assert [countdown.step() for _ in range(5)] == [True, True, True, False, False]
    countdown.start(1.0)
    assert [countdown.step() for _ in range(2)] == [True, False]


def test_the_first_values_weigh_as_in_a_plain_average():
    """Of 0 and 2 the mean is 1, and the second is off it by 1, the first was by 0; the third is at the mean."""
    sigma = RunningSigma(1e3, DT)
    found = []
    for value in (0.0, 2.0, 1.0):
        sigma.add(value)
        found.append(sigma.sigma**2)
    assert found == pytest.approx([0.0, 1.0 / 2.0, 1.0 / 3.0])


@pytest.mark.parametrize("time", [2.0, 10.0, 30.0, 60.0])
def test_after_a_step_the_deviation_rises_within_its_memory_and_falls_as_the_mean_follows_three_times_more_slowly(time):
    """With T = 10 s, T v' = h^2 e^(-2t/3T) - v from rest gives v = 3 h^2 (e^(-2t/3T) - e^(-t/T))."""
    memory, step, tick = 10.0, 2.0, 0.01
    sigma = RunningSigma(memory, tick)
    for _ in range(round(10.0 * memory / tick)):
        sigma.add(5.0)
    assert sigma.sigma == 0.0
    for _ in range(round(time / tick)):
        sigma.add(5.0 + step)
    solution = 3.0 * step**2 * (math.exp(-2.0 * time / (3.0 * memory)) - math.exp(-time / memory))
    assert sigma.sigma**2 == pytest.approx(solution, rel=0.01)


def test_heave_is_the_sum_of_the_steps_of_which_a_tenth_is_lost_in_half_a_second():
    heave = DetrendedHeave(DT)
    found = []
    for reading in (300.0, 300.25, None, 300.25, 300.0):
        heave.add(reading)
        found.append(heave.value)
    assert found == pytest.approx([0.0, 0.25, 0.225, 0.2025, 0.18225 - 0.25])


@pytest.mark.parametrize("missed", [0, 3])
@pytest.mark.parametrize("noise", [0.0, 0.5])
def test_a_step_that_no_unit_can_have_made_since_the_last_reading_is_none_and_one_up_to_it_is(missed, noise):
    most = largest_step(noise, (missed + 1) * DT)
    for step, is_motion in ((most, True), (-most, True), (most + 2**-10, False)):
        heave = DetrendedHeave(DT)
        heave.add(0.0, noise)
        heave.add(0.0, noise)
        for _ in range(missed):
            heave.add(None, noise)
        heave.add(step, noise)
        assert heave.value == (step if is_motion else 0.0)
        heave.add(step + 0.125, noise)
        assert heave.value == pytest.approx(0.9 * (step if is_motion else 0.0) + 0.125), "it goes on from there"


def checked(*spells, floor=0.0, ratio=1.5):
    """Return a check, with a memory of 2 s and of 20 s for waves, after spells of (ticks, square, its reference)."""
    check = AmplitudeCheck(AmplitudeLimit(time=2.0, ratio=ratio, floor=floor), 20.0, DT)
    for ticks, square, reference in spells:
        for _ in range(ticks):
            check.add(square, reference)
    return check


def test_an_amplitude_is_that_of_the_last_seconds_and_at_first_of_all_that_was_seen():
    assert checked((1, 1.0, 0.0), (1, 3.0, 0.0)).amplitude == pytest.approx(math.sqrt(2.0))
    # a quarter of a difference is made up in a tick of 0.5 s of a memory of 2 s
    assert checked((100, 0.0, 0.0), (2, 16.0, 0.0)).amplitude ** 2 == pytest.approx(16.0 * (1.0 - 0.75**2))


def test_the_reference_is_the_larger_of_now_and_of_the_last_waves():
    assert checked((1, 0.0, 1.0), (1, 0.0, 3.0)).reference == pytest.approx(2.0)
    assert checked((2000, 0.0, 0.0), (4, 0.0, 16.0)).reference == pytest.approx(16.0 * (1.0 - 0.75**4))
    assert checked((2000, 0.0, 16.0), (4, 0.0, 0.0)).reference == pytest.approx(16.0 * (1.0 - 0.025) ** 4)


def test_nothing_is_too_large_before_half_the_time_of_the_waves_was_seen():
    assert not checked((19, 9.0, 1.0)).is_exceeded
    assert checked((20, 9.0, 1.0)).is_exceeded


@pytest.mark.parametrize(("square", "is_exceeded"), [(2.25, False), (2.3, True)])
def test_an_amplitude_is_too_large_beyond_its_ratio_to_the_reference(square, is_exceeded):
    assert checked((50, square, 1.0)).is_exceeded is is_exceeded
    assert not checked((50, square, 1.0), floor=2.0).is_exceeded, "never below its floor"
    assert checked((50, 4.0 * square, 0.0), floor=3.0).is_exceeded is is_exceeded


@pytest.mark.parametrize(("left_over", "is_exceeded"), [(0.9, True), (1.1, False)])
def test_what_is_left_over_counts_as_the_reference_does(left_over, is_exceeded):
    """Of 3 m, where 1.5 times 1 m and what is left over are allowed."""
    check = checked((50, 9.0, 1.0))
    check.allow(left_over)
    assert check.is_exceeded is is_exceeded


def test_noise_that_is_known_is_no_amplitude_and_there_is_none_below_it():
    check = checked((50, 25.0, 0.0))
    check.take_off(3.0)
    assert check.amplitude == pytest.approx(4.0)
    check.take_off(6.0)
    assert check.amplitude == 0.0


def test_a_restart_goes_on_as_if_the_motion_had_been_another_and_keeps_the_reference():
    check = checked((50, 16.0, 1.0))
    check.restart()
    assert (check.amplitude, check.reference) == (0.0, pytest.approx(1.0))
    check.restart(9.0)
    assert check.amplitude == 3.0
    check.add(9.0, 1.0)
    assert check.amplitude == 3.0
