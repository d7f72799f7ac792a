import math

import numpy as np
import pytest
from heave_node.interface.codes import MruStatus, SensorLevel
from heave_node.interface.sensors import MruReading
from hypothesis import given
from hypothesis import strategies as st
from winch_controller_node.estimation.reading_record import Surprise
from winch_controller_node.estimation.sensor_health import (
    REMEDIES,
    UNKNOWN_STATUS,
    DepthJumps,
    EncoderGate,
    SensorGate,
    SensorTiming,
    judge_mru,
    remedy,
)
from winch_controller_node.interface.readings import ScalarReading
from winch_controller_node.model.estimator import Innovation
from winch_controller_node.parameters.laws import HealthParameters

DT = 0.05
OK, SUSPECT, LOST = SensorLevel


def make_gate(**timing):
    return SensorGate("depth", SensorTiming(DT, **timing), HealthParameters())


def feed(gate, values, start=1):
    """Give one reading per tick; None: none comes. Return the level after each tick."""
    levels = []
    for k, value in enumerate(values, start=start):
        if value is not None:
            gate.judge(k * DT, k * DT, (value,))
        gate.tick(k * DT)
        levels.append(gate.level)
    return levels


@pytest.mark.parametrize(
    ("fault", "reason"),
    [([math.nan] * 3, "nan"), ([7.0] * 3, "frozen"), ([None] * 4, "stale")],
)
def test_a_fault_raises_the_alarm_within_three_samples_and_is_named(fault, reason):
    """Stale is noticed when the fourth reading is overdue: three samples are missing then."""
    gate = make_gate()
    feed(gate, [0.1 * k for k in range(10)])
    assert gate.level == OK
    levels = feed(gate, fault, start=11)
    assert levels[-1] == LOST
    assert gate.reason == reason


@pytest.mark.parametrize("stamp", [0.05, 99.0])
@pytest.mark.parametrize("value", [math.nan, 7.0])
@pytest.mark.parametrize("status", ["", "status settling"])
def test_whatever_a_reading_is_refused_for_has_a_remedy(stamp, value, status):
    gate = make_gate()
    feed(gate, [7.0] * 2)
    gate.judge(3 * DT, stamp, (value,), status)
    assert gate.reason in REMEDIES


def test_a_sensor_that_calls_itself_wrong_is_to_be_looked_at():
    assert remedy("status invalid") == remedy("status 7") == UNKNOWN_STATUS


def test_one_bad_reading_makes_a_sensor_suspect_and_good_ones_make_it_well_again():
    gate = make_gate()
    feed(gate, [0.1, 0.2, math.nan])
    assert gate.level == SUSPECT
    feed(gate, [0.1 * k for k in range(4, 16)], start=4)
    assert (gate.level, gate.reason) == (OK, "")
    assert gate.state(1.0).refused == 1


@pytest.mark.parametrize(("stamp", "reason"), [(99.0, "wrong stamp"), (0.05, "late"), (math.nan, "wrong stamp")])
def test_a_stamp_from_the_future_or_the_past_or_none_at_all_is_refused(stamp, reason):
    gate = make_gate()
    feed(gate, [0.1, 0.2, 0.3])
    assert not gate.judge(4 * DT, stamp, (0.4,))
    assert gate.reason == reason


def test_a_late_sensor_is_not_stale_while_its_usual_latency_lasts():
    gate = make_gate(latency=0.1)
    for k in range(3, 30):
        gate.judge(k * DT, (k - 2) * DT, (0.1 * k,))
        gate.tick(k * DT)
        assert gate.level == OK


@pytest.mark.parametrize(("is_spike", "level"), [(True, SUSPECT), (False, OK)])
def test_a_reading_outside_a_gate_is_a_spike_only_where_those_before_were_foreseen(is_spike, level):
    """A unit whose cable goes slack is not foreseen: that is told once, and the depth sensor is not to blame for it."""
    gate = make_gate()
    for k in range(3, 9):
        gate.judge(k * DT, k * DT, (0.1 * k,))
        gate.take_back(is_spike=is_spike)
        assert gate.level == level
    assert (gate.state(1.0).accepted, gate.state(1.0).refused) == (0, 6)


def test_surprise_is_of_the_measurement_that_has_been_foreseen_badly():
    surprise = Surprise(DT)
    for nis in 400 * [9.0]:
        surprise.add({"unit_heave": Innovation(0.3, 0.1, nis, True), "mru_heave": Innovation(0.1, 0.1, 1.0, True)})
    assert surprise.is_surprised_by("unit_heave")
    assert not surprise.is_surprised_by("mru_heave")
    assert not surprise.is_surprised_by("tension")


def test_an_mru_that_says_it_is_settling_is_not_used():
    gate = SensorGate("mru", SensorTiming(DT), HealthParameters())
    assert not judge_mru(gate, DT, MruReading(DT, 0.1, 0.0, status=MruStatus.SETTLING))
    assert gate.reason == "status settling"


def encoder_after(steps, rate=0.5):
    """Feed an encoder that moves at `rate`, with extra `steps` by tick; return payouts taken and the gate."""
    gate = EncoderGate(SensorTiming(DT, DT), HealthParameters(), tick_period=DT)
    position, taken = 0.0, []
    for k in range(1, 40):
        position += rate * DT + steps.get(k, 0.0)
        taken.append(gate.judge(k * DT, ScalarReading(k * DT, round(position, 3)), rate))
    return taken, gate


def test_an_encoder_jump_is_noticed_at_once_and_taken_off():
    """The drum turned on at 0.5 m/s: 39 ticks are 0.975 m, whatever the encoder says."""
    taken, gate = encoder_after({20: 0.2})
    assert taken[19] is None
    assert gate.offset == pytest.approx(0.2, abs=2e-3)
    assert taken[-1] == pytest.approx(0.975, abs=3e-3)


def test_a_drum_that_follows_the_sea_through_a_gap_of_the_encoder_has_not_jumped():
    """0.8 s without readings, in which the drum turns round; then an old one comes, and in the next tick the newest."""
    gate = EncoderGate(SensorTiming(DT, DT), HealthParameters(), tick_period=DT)
    times = DT * np.arange(1, 200)
    payouts, rates = 0.6 * np.sin(times), 0.6 * np.cos(times)
    for tick, now in enumerate(times):
        expected = rates[max(tick - 1, 0)]
        gate.pass_tick(now, expected)
        if not 86 <= tick < 102:
            late = 9 if tick == 102 else 0
            gate.judge(now, ScalarReading(now - late * DT, payouts[tick - late]), expected)
    assert gate.offset == 0.0


def test_a_drum_that_turns_unseen_is_a_frozen_encoder():
    gate = EncoderGate(SensorTiming(DT, DT), HealthParameters(), tick_period=DT)
    for k in range(1, 6):
        gate.judge(k * DT, ScalarReading(k * DT, 1.0), 0.5)
    assert gate.gate.level == LOST
    assert gate.gate.reason == "frozen"


def test_an_encoder_with_play_in_its_gear_is_not_frozen_where_the_drum_turns_round():
    """A play of 1 cm, and a drum that is believed to be a quarter faster and to answer 0.1 s sooner than it does."""
    gate, reading, play = EncoderGate(SensorTiming(DT, DT), HealthParameters(), tick_period=DT), 0.0, 0.005
    for time in DT * np.arange(1, round(40.0 / DT)):
        reading = min(max(reading, 0.6 * math.sin(0.7 * time) - play), 0.6 * math.sin(0.7 * time) + play)
        believed = 1.25 * 0.42 * math.cos(0.7 * (time + 0.1))
        gate.judge(time, ScalarReading(time, 1e-3 * round(1e3 * reading)), believed)
        assert gate.gate.level == OK


def test_a_braked_drum_is_not_a_frozen_encoder():
    gate = EncoderGate(SensorTiming(DT, DT), HealthParameters(), tick_period=DT)
    for k in range(1, 10):
        gate.judge(k * DT, ScalarReading(k * DT, 1.0), 0.5, is_driven=False)
    assert gate.gate.level == OK


def test_a_jump_that_was_taken_off_is_shown_until_diagnostics_have_told_it():
    """Diagnostics come once a second; the reading after the jump is good again."""
    gate = EncoderGate(SensorTiming(DT, DT), HealthParameters(), tick_period=DT)
    levels = []
    for k in range(1, 80):
        gate.judge(k * DT, ScalarReading(k * DT, 0.2 if k >= 20 else 0.0), 0.0)
        levels.append(gate.gate.level)
    assert levels[18] == OK
    assert levels[19 : 19 + round(1.5 / DT)] == [SUSPECT] * round(1.5 / DT)
    assert levels[-1] == OK
    assert gate.jump == pytest.approx(0.2)


def heave(time):
    """Depth of a unit that swings by 1 m in 9 s [m]."""
    return 900.0 + math.sin(0.7 * time)


@pytest.mark.parametrize("jump", [3.0, -0.8, 50.0])
def test_a_jump_of_the_depth_is_taken_off_and_one_back_leaves_nothing(jump):
    jumps, times = DepthJumps(), 0.1 * np.arange(300)
    read = [jumps.take_off(time, heave(time) + (jump if 10.0 <= time < 20.0 else 0.0)) for time in times]
    assert read.count(None) <= 2
    errors = [depth - heave(time) for time, depth in zip(times, read, strict=True) if depth is not None]
    # what the unit itself has moved between two readings is counted to the jump
    assert max(np.abs(errors)) < 0.08
    assert jumps.offset == 0.0
    assert errors[-1] == 0.0


def test_a_spike_of_the_depth_is_left_out_and_nothing_else():
    jumps, times = DepthJumps(), 0.1 * np.arange(100)
    read = [jumps.take_off(time, heave(time) + (3.0 if k == 50 else 0.0)) for k, time in enumerate(times)]
    assert [k for k, depth in enumerate(read) if depth is None] == [50]
    assert read[51:] == [heave(time) for time in times[51:]]


@given(st.lists(st.floats(-0.4, 0.4), min_size=1, max_size=100))
def test_steps_that_a_unit_can_make_are_never_taken_off(steps):
    jumps = DepthJumps()
    depths = 900.0 + np.cumsum([0.0, *steps])
    assert [jumps.take_off(0.1 * k, depth) for k, depth in enumerate(depths)] == list(depths)
