"""Motion under the brake is reported in time, by count and load cell, and what follows of it."""

import math

import numpy as np
import pytest
from heave_node.interface.alarm import Severity
from heave_node.interface.codes import WinchFault
from heave_node.interface.sensors import MruReading
from winch_controller_node.core.envelope import Asked, OrderEnvelope
from winch_controller_node.core.supervision.modes import Mode
from winch_controller_node.core.supervision.proof_design import FALL_WINDOW
from winch_controller_node.interface.readings import Measurements, ScalarReading, WinchOrder, WinchReading
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.motion.trajectory import MeanPayout
from winch_controller_node.node_parameters import WinchControllerParameters

from tests.core_parts import Driven, Proofs

TICK = 0.05
RESOLUTION = 0.001
"""Of the encoder [m]."""
STATIC, STIFFNESS = 98.6e3, 17.5e3
CABLE = CableModel(a=7.2, b=0.05, stiffness=STIFFNESS, static_tension=STATIC)
STILL = CableModel(a=1e9, b=0.0, stiffness=STIFFNESS, static_tension=STATIC)
"""With a load so heavy that it stays where it is."""


class Drum:
    """A drum under the brake, with a watch; `tick` moves it and the load by a tick.

    `heave` is the boom tip's of a load that stays where it is: the cable is longer by it than at rest.
    """

    def __init__(self, *, noise=100.0):
        self.proofs = Proofs(WinchControllerParameters(length=900.0), STILL, TICK)
        self.time = self.way = self.tension = self.heave = 0.0
        self.alarms = []
        self._noise, self._rng = noise, np.random.default_rng(1)

    def tick(self, rate=0.0, *, count=True, brake=True, fault=0, falls=0.0, runs=False, has_mru=True, read=None):
        self.time += TICK
        self.way += rate * TICK
        self.tension += falls * TICK
        counted = round(self.way / RESOLUTION) * RESOLUTION if count else math.nan
        winch = WinchReading(self.time, counted, math.nan, brake, fault)
        noise = self._noise * self._rng.normal()
        force = max(STATIC + STIFFNESS * self.heave, 0.0) + self.tension + noise
        raw = Measurements(
            (MruReading(self.time, self.heave if read is None else read, math.nan),),
            {"load_cell": (ScalarReading(self.time, force),)},
            winch,
        )
        self.proofs.note(WinchOrder(0, 0.0, 0.0, brake))
        driven = Driven(waits=False, hangs=True, taken_over="DRUM_NOT_HELD: count" if runs else "", has_mru=has_mru)
        found = self.proofs.step(raw, driven).alarms
        self.alarms += [(self.time, self.way, alarm) for alarm in found]
        return [alarm.name for alarm in found]

    def rest(self, seconds, **given):
        for _ in range(round(seconds / TICK)):
            self.tick(**given)

    @property
    def codes(self):
        return [alarm.name for _, _, alarm in self.alarms]


@pytest.mark.parametrize(
    ("holds", "fault", "code", "severity"),
    [
        (True, WinchFault.DRIVE, "DRUM_HELD_BY_DRIVE", Severity.HIGH),
        (False, WinchFault.NONE, "DRUM_NOT_HELD: turns", Severity.CRITICAL),
        (False, WinchFault.EMERGENCY_STOP, "DRUM_NOT_HELD: turns", Severity.CRITICAL),
    ],
)
def test_what_follows_is_told_of_a_drive_that_holds_and_of_one_that_does_not(holds, fault, code, severity):
    """The envelope has found the motion by the count, and reports it."""
    drum = Drum()
    drum.rest(5.0)
    drum.rest(0.2, rate=0.5)
    drum.rest(5.0, rate=0.0 if holds else 0.5, runs=True, fault=fault)
    assert drum.codes == [code]
    assert drum.alarms[0][2].severity is severity
    assert drum.alarms[0][2].values["moved"] == pytest.approx(0.1 if holds else 0.6, abs=0.03)
    assert ("emergency stop has taken" in str(drum.alarms[0][2])) is (fault is WinchFault.EMERGENCY_STOP)


@pytest.mark.parametrize("rate", [0.3, 0.5, 1.0])
def test_a_slip_that_the_count_does_not_show_is_told_by_the_load_cell(rate):
    """Wire takes tension off by its stiffness, before a unit of 2.7 rad/s or less has followed."""
    drum = Drum()
    drum.rest(FALL_WINDOW)
    begin = drum.time
    for _ in range(20):
        drum.tick(count=False, falls=-rate * STIFFNESS)
    time, _, alarm = drum.alarms[0]
    assert alarm.name == "DRUM_NOT_HELD: hook load"
    assert alarm.severity is Severity.CRITICAL
    assert time - begin < 0.3 + 0.05 / rate


def test_the_load_falls_by_no_mru_that_is_refused_and_a_slip_is_told_without_it():
    """A reversed one, set aside, made a load that falls of waves."""
    drum = Drum()
    drum.rest(FALL_WINDOW)
    for _ in range(1200):
        drum.heave = 0.1 * math.sin(0.7 * drum.time)
        drum.tick(has_mru=False, read=10.0 * drum.heave)
    assert drum.codes == []
    for _ in range(20):
        drum.tick(has_mru=False, falls=-STIFFNESS)
    assert drum.codes == ["DRUM_NOT_HELD: hook load"]


def test_a_load_that_swings_after_a_stop_is_no_slip():
    """By 0.8 m in 13 s: how it fell under the brake before says nothing of it."""
    drum = Drum()
    drum.rest(FALL_WINDOW)
    drum.rest(10.0, brake=False)
    for _ in range(1200):
        drum.tick(falls=-STIFFNESS * 0.8 * 0.47 * math.sin(0.47 * drum.time))
    assert drum.codes == []


@pytest.mark.parametrize("count", [True, False])
def test_a_drum_whose_count_shows_no_motion_is_not_said_to_have_moved(count):
    drum = Drum()
    drum.rest(FALL_WINDOW)
    for _ in range(40):
        drum.tick(count=count, falls=-0.5 * STIFFNESS)
    assert drum.codes == ["DRUM_NOT_HELD: hook load"]


def test_waves_that_the_mru_shows_and_those_that_it_does_not_are_no_slip():
    """The first are taken off; to the others the load cell is used: it has seen how it falls without a cause."""
    for is_known in (True, False):
        drum = Drum()
        for _ in range(4000):
            drum.heave = 0.3 * math.sin(0.7 * drum.time)
            if not is_known:
                drum.tension, drum.heave = STIFFNESS * drum.heave, 0.0
            drum.tick()
        assert drum.codes == []


def test_a_cable_that_goes_slack_in_waves_and_snaps_taut_is_no_slip():
    """It falls to nothing as the MRU has it, or half a second before or after, and is struck by half of the static."""
    for late in (-0.5, 0.0, 0.5):
        drum = Drum()
        for _ in range(4000):
            lowest = -1.05 * STATIC / STIFFNESS
            drum.heave = 1.2 * lowest * math.sin(0.7 * drum.time)
            shown = max(drum.heave, -STATIC / STIFFNESS)
            real = max(1.2 * lowest * math.sin(0.7 * (drum.time - late)), -STATIC / STIFFNESS)
            snap = 0.5 * STATIC * (real > -STATIC / STIFFNESS) * (math.sin(0.7 * (drum.time - late - 0.2)) > 0.79)
            drum.tension = STIFFNESS * (real - shown) + snap
            drum.tick()
        assert drum.codes == []


def test_a_released_drum_may_move():
    drum = Drum()
    drum.rest(20.0, brake=False, rate=0.5)
    assert drum.codes == []


# by the count: the envelope


class Braked:
    """An envelope before a drum of its own; `tick` moves the drum by a tick."""

    def __init__(self):
        cable = CABLE
        self.envelope = OrderEnvelope(WinchControllerParameters(length=900.0), cable, TICK)
        self.time = self.way = 0.0
        self.number = 0
        self.alarms = []
        self.move = MeanPayout(WinchControllerParameters().move, tick_period=TICK).request

    def tick(self, rate=0.0, *, jump=0.0, order=None, fault=0):
        """Move the drum at a `rate` [m/s]; `order` [m/s]; None: the brake is ordered."""
        self.time += TICK
        self.number += 1
        self.way += rate * TICK + jump
        read = round(self.way / RESOLUTION) * RESOLUTION
        raw = Measurements(
            winch=WinchReading(self.time, read, 0.0, order is None and fault == 0 and not self.stops, fault)
        )
        asked = Asked(Mode.MANUAL if order is not None else Mode.STANDBY, self.move)
        _, news = self.envelope.step(raw, asked, WinchOrder(self.number, 0.0, order or 0.0, order is None))
        self.alarms += [(self.time, self.way, alarm) for alarm in news]

    stops = False

    def rest(self, seconds, **given):
        for _ in range(round(seconds / TICK)):
            self.tick(**given)

    @property
    def codes(self):
        return [alarm.name for _, _, alarm in self.alarms]


@pytest.mark.parametrize("rate", [0.001, 0.02, 0.03, 0.05, 0.1, 0.3, 0.5, -0.03, -0.2, 1.0, 2.0])
def test_a_drum_that_slips_is_told_at_the_highest_severity_within_a_third_of_a_second_and_five_centimetres(rate):
    """0.3 s from 0.03 m/s on; below it within a centimetre. Above 0.5 m/s, within two readings."""
    drum = Braked()
    drum.rest(10.0)
    begin = drum.time
    drum.rest(60.0 if abs(rate) < 0.01 else 3.0, rate=rate)
    time, way, alarm = drum.alarms[0]
    assert alarm.name == "DRUM_NOT_HELD: count"
    assert alarm.severity is Severity.CRITICAL
    assert abs(way) <= max(0.01 if abs(rate) < 0.03 else 0.05, 2.0 * abs(rate) * TICK) + 1e-9
    assert time - begin <= max(0.3, 0.01 / abs(rate)) + 1e-9
    assert "The drive is ordered to hold the drum." in str(alarm)
    assert len(drum.alarms) == 1


def test_a_brake_that_gives_by_five_millimetres_as_it_takes_the_load_and_in_waves_by_two_is_told_of_nothing():
    drum, place = Braked(), 0.0
    drum.rest(5.0)
    for _ in range(2400):
        before, place = place, min(5e-3, 0.02 * (drum.time - 5.0)) + 2e-3 * math.sin(0.7 * (drum.time - 5.0))
        drum.tick((place - before) / TICK)
    assert drum.codes == []


@pytest.mark.parametrize("speed", [0.2, -0.2, 0.1])
@pytest.mark.parametrize(("deceleration", "fault"), [(0.5, 0), (1.5, 0), (1.5, 3), (0.25, 0)])
def test_a_drum_that_comes_to_rest_after_the_brake_was_ordered_is_told_of_nothing(speed, deceleration, fault):
    drum = Braked()
    drum.rest(2.0)
    for k in range(12):
        # the drum is the delay and a lag behind
        drum.tick(min(max(k - 6, 0) / 3.0, 1.0) * speed, order=speed)
    assert drum.codes == []
    drum.stops, rate, late = True, speed, 0.0 if fault else 0.2
    while rate or late > 0.0:
        late -= TICK
        rate = rate if late > 0.0 else math.copysign(max(abs(rate) - deceleration * TICK, 0.0), rate)
        drum.tick(rate, fault=fault)
    drum.stops = False
    drum.rest(5.0, fault=fault)
    assert "DRUM_NOT_HELD: count" not in drum.codes


@pytest.mark.parametrize("gain", [1.0, 2.0, 4.0])
def test_a_drum_that_still_gains_speed_when_the_brake_is_ordered_does_not_run_on_it(gain):
    """What was ordered before the brake acts for the delay of the winch."""
    drum, rate = Braked(), 0.0
    drum.rest(2.0)
    while not drum.codes:
        rate += gain * TICK
        drum.tick(rate, order=0.1)
    for _ in range(3):
        rate += gain * TICK
        drum.tick(rate)
    while rate:
        rate = max(rate - 0.5 * TICK, 0.0)
        drum.tick(rate)
    drum.rest(5.0)
    assert drum.codes == ["DRUM_OFF_ORDER: distance"]


def test_a_brake_that_stays_open_after_a_stop_is_told_within_a_third_of_a_second():
    """The drum never stands: it is slowed down to nothing by its drive and runs on with its load at once."""
    drum = Braked()
    drum.rest(5.0)
    drum.stops, rate = True, 0.3
    while rate > 0.0:
        rate = max(rate - 1.5 * TICK, 0.0)
        drum.tick(rate, fault=WinchFault.EMERGENCY_STOP)
    begin, way = drum.time, drum.way
    drum.alarms.clear()
    drum.envelope.acknowledge()
    drum.rest(2.0, rate=0.5, fault=WinchFault.EMERGENCY_STOP)
    time, at, alarm = drum.alarms[0]
    assert alarm.name == "DRUM_NOT_HELD: count"
    assert time - begin < 0.3
    assert at - way < 0.1
