"""Motion under the brake is told in time by the count or the load cell, and nothing else is."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from heave_node.interface.alarm import Severity
from heave_node.interface.codes import WinchFault
from hypothesis import given
from hypothesis import strategies as st
from winch_controller_node.core.supervision.watch.brake_watch import FALL_WINDOW, BrakeWatch
from winch_controller_node.interface.readings import ScalarReading, WinchReading
from winch_controller_node.model.blocks import CableModel

TICK = 0.05
RESOLUTION = 0.001
"""Of the encoder [m]."""
STATIC, STIFFNESS = 98.6e3, 17.5e3


@dataclass
class Load:
    """A nominal load whose stretch is given."""

    stretch: float = 0.0
    is_known: bool = True
    cable: CableModel = CableModel(a=7.2, b=0.05, stiffness=STIFFNESS, static_tension=STATIC)


class Drum:
    """A drum under the brake, with a watch; `tick` moves it and the load by a tick."""

    def __init__(self, *, noise=100.0):
        self.watch, self.load = BrakeWatch(TICK), Load()
        self.time = self.way = self.tension = 0.0
        self.alarms = []
        self._noise, self._rng = noise, np.random.default_rng(1)

    def tick(self, rate=0.0, *, count=True, jump=0.0, brake=True, engaged=True, fault=0, falls=0.0):
        self.time += TICK
        self.way += rate * TICK + jump
        self.tension += falls * TICK
        read = round(self.way / RESOLUTION) * RESOLUTION if count else math.nan
        winch = WinchReading(self.time, read, 0.0, engaged, fault)
        noise = self._noise * self._rng.normal()
        force = STATIC + STIFFNESS * self.load.stretch + self.tension + noise
        found = self.watch.step(self.load, is_braked=brake, winch=winch, tensions=(ScalarReading(self.time, force),))
        self.alarms += [(self.time, self.way, alarm) for alarm in found]
        return [alarm.code for alarm in found]

    def rest(self, seconds, **given):
        for _ in range(round(seconds / TICK)):
            self.tick(**given)

    @property
    def codes(self):
        return [alarm.code for _, _, alarm in self.alarms]


@pytest.mark.parametrize("rate", [0.001, 0.02, 0.1, 0.3, 0.5, -0.2, 1.0, 2.0])
def test_a_drum_that_slips_is_told_at_the_highest_severity_within_a_third_of_a_second_and_five_centimetres(rate):
    """Both, up to the speed at which 0.05 m are two readings; above it within two of them."""
    drum = Drum()
    drum.rest(10.0)
    begin = drum.time
    drum.rest(60.0 if abs(rate) < 0.01 else 3.0, rate=rate)
    time, way, alarm = drum.alarms[0]
    assert alarm.code == "BRAKE_DOES_NOT_HOLD"
    assert alarm.severity is Severity.CRITICAL
    assert abs(way) < max(0.05, 2.0 * abs(rate) * TICK) + 1e-9
    assert time - begin < max(0.3, 0.032 / abs(rate)) + 1e-9
    assert alarm.values["moved"] == pytest.approx(way, abs=2.0 * RESOLUTION)


@given(st.floats(-5.0, 5.0).filter(lambda jump: abs(jump) > 0.02))
def test_a_jump_of_the_count_is_no_motion(jump):
    drum = Drum()
    drum.rest(5.0)
    drum.tick(jump=jump)
    drum.rest(5.0)
    assert drum.codes == []


def test_a_drum_that_comes_to_rest_after_the_brake_was_ordered_is_told_of_nothing():
    """Its order goes on for the delay of 0.2 s; then it is slowed down by 0.5 m/s2, or by its own 1.5 m/s2 at once."""
    for deceleration, delay, given in ((0.5, 0.2, {}), (1.5, 0.0, {"fault": 3}), (0.2, 0.2, {})):
        for speed in (1.2, -0.6, 0.05, 0.0):
            drum = Drum()
            drum.rest(5.0, brake=False, engaged=False, rate=speed)
            late, rate = delay, speed
            while late > 0.0 or rate:
                late -= TICK
                rate = rate if late > 0.0 else math.copysign(max(abs(rate) - deceleration * TICK, 0.0), rate)
                drum.tick(rate, engaged=False, **given)
            drum.rest(5.0, **given)
            assert drum.codes == [], (deceleration, speed)


def test_a_brake_that_stays_open_after_a_stop_is_told_within_a_third_of_a_second():
    """The drum never stands: it is slowed down to nothing by its drive and runs on with its load at once."""
    drum = Drum()
    drum.rest(5.0, brake=False, engaged=False, rate=0.3)
    rate = 0.3
    while rate > 0.0:
        rate = max(rate - 1.5 * TICK, 0.0)
        drum.tick(rate, engaged=False, fault=WinchFault.EMERGENCY_STOP)
    begin, way = drum.time, drum.way
    drum.rest(2.0, rate=0.5, engaged=False, fault=WinchFault.EMERGENCY_STOP)
    time, at, alarm = drum.alarms[0]
    assert alarm.code == "BRAKE_DOES_NOT_HOLD"
    assert time - begin < 0.3
    assert at - way < 0.1
    assert "taken the drive's power" in str(alarm)
    assert drum.codes == ["BRAKE_DOES_NOT_HOLD", "DRUM_NOT_HELD"]


def test_what_follows_is_told_of_a_drive_that_holds_and_of_one_that_does_not():
    for holds, code, severity in (
        (True, "DRUM_HELD_BY_DRIVE", Severity.HIGH),
        (False, "DRUM_NOT_HELD", Severity.CRITICAL),
    ):
        drum = Drum()
        drum.rest(5.0)
        drum.rest(0.2, rate=0.5)
        drum.rest(5.0, rate=0.0 if holds else 0.5)
        assert drum.codes == ["BRAKE_DOES_NOT_HOLD", code]
        assert drum.alarms[-1][2].severity is severity
        assert drum.watch.gate
        drum.watch.acknowledge()
        assert drum.watch.gate == ""


@pytest.mark.parametrize("rate", [0.3, 0.5, 1.0])
def test_a_slip_that_the_count_does_not_show_is_told_by_the_load_cell(rate):
    """Wire takes tension off by its stiffness, before a unit of 2.7 rad/s or less has followed."""
    drum = Drum()
    drum.rest(FALL_WINDOW)
    begin = drum.time
    for _ in range(20):
        drum.tick(count=False, falls=-rate * STIFFNESS)
    time, _, alarm = drum.alarms[0]
    assert alarm.code == "BRAKE_DOES_NOT_HOLD"
    assert alarm.values["witness"] == "load cell"
    assert time - begin < 0.3 + 0.05 / rate


def test_waves_that_the_mru_shows_and_those_that_it_does_not_are_no_slip():
    """The first are taken off; to the others the load cell is used: it has seen how it falls without a cause."""
    for is_known in (True, False):
        drum = Drum()
        for _ in range(4000):
            drum.load.stretch = 0.3 * math.sin(0.7 * drum.time)
            if not is_known:
                drum.tension, drum.load.stretch = STIFFNESS * drum.load.stretch, 0.0
            drum.tick()
        assert drum.codes == []


def test_a_cable_that_goes_slack_is_no_slip():
    drum = Drum()
    drum.rest(FALL_WINDOW)
    for _ in range(8):
        drum.tick(falls=-STATIC / 0.4)
    drum.rest(3.0)
    assert "load cell" not in [alarm.values.get("witness") for _, _, alarm in drum.alarms]


def test_a_released_drum_may_move():
    drum = Drum()
    drum.rest(20.0, brake=False, engaged=False, rate=0.5)
    assert drum.codes == []
