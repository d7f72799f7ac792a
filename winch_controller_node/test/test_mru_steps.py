"""An MRU whose heave steps away from its own rate, on a swell of 1 m and 9 s."""

import math

import numpy as np
import pytest
from heave_node.interface.sensors import MruReading
from hypothesis import given
from hypothesis import strategies as st
from winch_controller_node.core.estimation.sense_design import STEPS

from tests.gates import MruSteps

DT = 0.05
BEFORE = 120.0
"""Time for which it reads well at first [s]: twice what its mean is taken over."""

TURNED = 0.7
"""Phase of the swell at which something happens [rad]: its heave is 0.64 m."""

LITTLE = 1e-3


def swell(time):
    """Return heave [m] and rate [m/s] at a `time` after BEFORE [s]."""
    phase = 2.0 * math.pi / 9.0 * (time - BEFORE) + TURNED
    return math.sin(phase), 2.0 * math.pi / 9.0 * math.cos(phase)


def read(steps, start, end, change=lambda heave, rate: (heave, rate), noise=0.0):
    """Give the readings from `start` to `end` [s] as they are `change`d; return off and unproved of each."""
    found = []
    for k in range(round(start / DT), round(end / DT)):
        heave, rate = change(*swell(k * DT))
        off = steps.is_off(MruReading(k * DT, heave, rate), noise)
        found.append((off, steps.is_unproved))
    return found


def well_read():
    """Return the steps of an MRU that has read well BEFORE."""
    steps = MruSteps()
    assert set(read(steps, 0.0, BEFORE)) == {(False, False)}
    return steps


def moved(size):
    return lambda heave, rate: (heave + size, rate)


def turned_over(heave, rate):
    return -heave, -rate


@pytest.mark.parametrize("size", [0.5, -0.5, 3.0, -100.0])
def test_a_step_is_off_at_once_and_for_as_long_as_it_stays(size):
    """Its mean is off by the step: two minutes of it are no proof that the ship floats higher."""
    assert set(read(well_read(), BEFORE, BEFORE + 120.0, moved(size))) == {(True, False)}


@pytest.mark.parametrize(
    ("noise", "least"), [(0.0, STEPS["mru_step"]), (0.03, STEPS["mru_step"]), (0.1, STEPS["sigmas"] * 0.1)]
)
def test_a_step_is_more_than_the_noise_makes(noise, least):
    for size, off in (
        (least - LITTLE, False),
        (least + LITTLE, True),
        (LITTLE - least, False),
        (-LITTLE - least, True),
    ):
        # one reading, judged from one that is right
        found = read(well_read(), BEFORE, BEFORE + DT, moved(size), noise)
        assert found == [(off, False)]


def test_noise_of_5_cm_never_steps():
    """From one reading to the next it is 7 cm, 1 sigma: a threshold of 8 of 5 cm is 5.6 of those."""
    random = np.random.default_rng(1)
    steps = MruSteps()

    def noisy(heave, rate):
        return heave + 0.05 * random.standard_normal(), rate + 0.05 * random.standard_normal()

    assert set(read(steps, 0.0, 900.0, noisy, noise=0.05)) == {(False, False)}
    # and a step of 1 m is found in it
    assert all(off for off, _ in read(steps, 900.0, 930.0, lambda *swelling: moved(1.0)(*noisy(*swelling)), 0.05))


@pytest.mark.parametrize("lasting", [DT, 3.0, 20.0, 59.0])
def test_a_jump_that_ends_is_good_at_once(lasting):
    steps = well_read()
    assert set(read(steps, BEFORE, BEFORE + lasting, moved(1.5))) == {(True, False)}
    assert set(read(steps, BEFORE + lasting, BEFORE + lasting + 60.0)) == {(False, False)}


def test_a_signal_that_is_turned_over_is_good_by_its_mean_only_and_then_unproved():
    """It stays off by twice the heave at which it turned; its mean is right, as that of any other scale."""
    found = read(well_read(), BEFORE, BEFORE + STEPS["mean_time"] + 9.0, turned_over)
    off = [is_off for is_off, _ in found]
    first = off.index(False)
    # its mean is that of the ship to a tenth of a metre or a quarter of 0.7 m throughout
    assert STEPS["mean_time"] - 2 * DT < first * DT < STEPS["mean_time"] + 9.0
    assert found[first] == (False, True)
    # it is reported once, and what comes next goes on from there
    assert set(found[first + 1 :]) == {(False, False)}


@pytest.mark.parametrize(("scale", "size"), [(-1.0, 0.5), (1.0, 0.5), (0.2, -0.3)])
def test_a_mean_that_is_another_is_no_proof(scale, size):
    """Near is a quarter of what is read now, 1 sigma, or a tenth of a metre: 0.18 m of a swell of 1 m."""
    assert max(STEPS["near_mean"] * abs(scale) * math.sqrt(0.5), STEPS["least_near"]) < abs(size)
    found = read(
        well_read(), BEFORE, BEFORE + 2.0 * STEPS["mean_time"], lambda heave, rate: (scale * heave + size, scale * rate)
    )
    assert set(found) == {(True, False)}


@pytest.mark.parametrize("gap", [STEPS["longest_gap"] + DT, 30.0])
def test_after_a_gap_or_while_it_settles_it_begins_anew(gap):
    steps = well_read()
    assert not any(off for off, _ in read(steps, BEFORE + gap, BEFORE + gap + 60.0, moved(2.0)))
    steps = well_read()
    steps.restart()
    assert not any(off for off, _ in read(steps, BEFORE, BEFORE + 60.0, moved(2.0)))


def test_a_short_gap_is_bridged_by_its_rate():
    """A trapezium of 0.5 s of a swell of 9 s and 0.7 m/s is off by 0.5^3 / 12 of 0.34 m/s^3: 4 mm."""
    gap = STEPS["longest_gap"] - DT
    assert not any(off for off, _ in read(well_read(), BEFORE + gap, BEFORE + 60.0))
    assert read(well_read(), BEFORE + gap, BEFORE + gap + DT, moved(0.5)) == [(True, False)]


def test_a_stamp_that_does_not_go_on_begins_anew():
    steps = well_read()
    last = BEFORE - DT
    assert not steps.is_off(MruReading(last, 5.0, 0.0), 0.0)
    assert not steps.is_off(MruReading(last - 1.0, -5.0, 0.0), 0.0)
    assert steps.is_off(MruReading(last - 1.0 + DT, 0.0, 0.0), 0.0)


LARGE = st.floats(-1e100, 1e100)
READINGS = st.lists(st.tuples(st.sampled_from([0.0, DT, -DT, 0.4, 1.0]), LARGE, LARGE), max_size=40)


@given(READINGS, st.floats(0.0, 1e6))
def test_whatever_is_read_it_is_off_or_not(readings, noise):
    steps, time = MruSteps(), 0.0
    for elapsed, heave, rate in readings:
        time += elapsed
        off = steps.is_off(MruReading(time, heave, rate), noise)
        assert off in (True, False)
        assert not (off and steps.is_unproved)


@pytest.mark.parametrize("heave", [1e155, -1e308])
def test_a_heave_that_is_hardly_a_number_is_off(heave):
    assert read(well_read(), BEFORE, BEFORE + DT, lambda *_: (heave, 0.0)) == [(True, False)]


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_a_unit_that_measures_no_rate_is_taken_at_that_of_its_readings_before(noise):
    """A swell that it reads is no step, with its noise; one of 1 m is, as long as it stays; and back again is none."""
    random = np.random.default_rng(1)

    def heave_alone(heave, _):
        return heave + noise * random.standard_normal(), math.nan

    def stepped(heave, _):
        return heave_alone(heave + 1.0, 0.0)

    steps = MruSteps()
    assert not any(off for off, _ in read(steps, 0.0, BEFORE, heave_alone, noise))
    assert all(off for off, _ in read(steps, BEFORE, BEFORE + 20.0, stepped, noise))
    assert not any(off for off, _ in read(steps, BEFORE + 20.0, BEFORE + 40.0, heave_alone, noise))


def test_a_unit_of_4_hz_without_rate_makes_no_step_at_its_start():
    """At 2.1 m/s two readings are 0.5 m apart."""
    steps = MruSteps()
    heaves = [3.0 * swell(0.25 * k)[0] for k in range(200)]
    assert not any(steps.is_off(MruReading(0.25 * k, heave, math.nan), 0.01) for k, heave in enumerate(heaves))


@pytest.mark.parametrize("late", [0.04, 0.15])
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_a_unit_without_rate_or_time_is_judged_by_arrivals_that_a_busy_machine_scatters(late, noise):
    """Heave of 3 m and 9 s, up to 2.1 m/s, each sample handed over late by a time that differs; 1 m is a step."""
    random = np.random.default_rng(2)
    steps, arrival, off = MruSteps(), 0.0, []
    for k in range(round(BEFORE / DT)):
        arrival = max(arrival + 1e-4, k * DT + late * random.random())
        heave = 3.0 * swell(k * DT)[0] + noise * random.standard_normal() + (1.0 if k * DT >= 100.0 else 0.0)
        off.append(steps.is_off(MruReading(arrival, heave, math.nan), noise))
    stepped = round(100.0 / DT)
    assert not any(off[:stepped])
    assert all(off[stepped : stepped + 200])
