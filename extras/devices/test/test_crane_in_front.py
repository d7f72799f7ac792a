"""The crane's lift as it is asked for: carried along with the mean payout, within an operator's share of the winch."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from heave_devices.crane.in_front import CraneInFront
from heave_node.crane.pose import CranePose
from heave_node.extras import extra_parts
from heave_node.interface.sensors import MruReading
from heave_node.parameters import ParameterError
from winch_controller_node.core.component import WinchController
from winch_controller_node.core.supervision.modes import Mode
from winch_controller_node.interface.readings import Measurements, Outputs, WinchOrder, WinchReading
from winch_controller_node.motion.operator_speed import OperatorRange
from winch_controller_node.node_parameters import WinchControllerParameters, load_chosen_parts
from winch_controller_node.parameters.model import CraneModelParameters, WinchModelParameters

DT = 0.05
CRANE = CraneModelParameters(boom_length=20.0, largest_extension_rate=5.0, luff=math.pi / 2)
"""A boom that stands upright: what it extends is what it lifts."""


class Behind:
    """A controller whose drum does at once what it is asked for."""

    def __init__(self, highest=50.0, speed=0.5):
        winch = SimpleNamespace(command_delay=0.0)
        sensors = WinchControllerParameters().sensors
        self.parameters = SimpleNamespace(crane=CRANE, winch=winch, sensors=sensors)
        self.mean = SimpleNamespace(point=SimpleNamespace(payout=0.0))
        self.mode, self.carried, self.rates = Mode.COMPENSATING, 0.0, []
        self.range = OperatorRange(speed, 0.3, -50.0, highest, 0.1)

    def carry_mean(self, rate, kept):
        bounds = OperatorRange(self.range.speed, 0.3, -50.0 + kept, self.range.payout_maximum - kept, 0.1)
        taken = bounds.nearest(rate, self.carried)
        self.carried += taken * DT
        self.rates.append(taken)
        return taken, bounds

    def step(self, tick, measurements):
        self.seen = measurements
        return Outputs(WinchOrder(tick, 0.0, 0.0, False), self.mode.value, 1.0, 0.0, lambda: None)


def run(behind, lift, end, start=0.0, source=None, swing=0.0):
    """Have the boom lift its tip by `lift`(t); return what stands in front, and its alarms."""
    source, alarms = source or CraneInFront(behind, DT), []
    for tick in range(round(start / DT) + 1, round(end / DT) + 1):
        t = tick * DT
        rate = (lift(t + 1e-4) - lift(t - 1e-4)) / 2e-4
        pose = CranePose(t, (0.0, math.pi / 2, 0.0, lift(t)), (0.0, 0.0, 0.0, rate))
        winch = WinchReading(t, behind.carried + swing * math.sin(t), 0.0, brake=False)
        alarms += source.step(tick, Measurements((MruReading(t, 0.0, 0.0),), winch=winch), (pose,)).alarms
    return source, [alarm for alarm in alarms if alarm.name != "CRANE_POSE_USED"]


def smooth(height, duration):
    """Return a lift by a `height` in a `duration` [s], at rest before and after: a quintic."""

    def lift(t):
        s = min(max(t / duration, 0.0), 1.0)
        return height * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)

    return lift


@pytest.mark.parametrize("height", [4.0, -4.0])
def test_a_lift_within_the_share_is_made_up_for_to_the_centimetre(height):
    behind = Behind()
    lift, source = smooth(height, 30.0), None
    for end in range(1, 36):
        source, alarms = run(behind, lift, end, start=end - 1.0, source=source)
        assert not alarms
        assert behind.carried == pytest.approx(lift(end + DT), abs=0.01)


def test_a_lift_beyond_the_share_raises_one_alarm_waits_and_is_caught_up():
    behind = Behind(speed=0.4)
    _, alarms = run(behind, smooth(8.0, 12.0), 40.0)
    assert [alarm.name for alarm in alarms] == ["CRANE_TOO_FAST"]
    assert alarms[0].values["limit"] == 0.4
    assert max(behind.rates) == 0.4
    assert behind.carried == pytest.approx(8.0, abs=1e-3)


def test_a_lift_towards_the_end_of_the_range_stops_where_compensation_keeps_its_room():
    behind = Behind(highest=3.0)
    _, alarms = run(behind, smooth(4.0, 30.0), 40.0, swing=1.0)
    assert [alarm.name for alarm in alarms] == ["CRANE_BEYOND_RANGE"]
    assert (alarms[0].values["limit"], alarms[0].values["raise_or_lower"]) == (pytest.approx(2.0, abs=0.1), "raise")
    assert behind.carried <= 2.3


def test_what_the_boom_moves_while_the_winch_stands_comes_back_slowly():
    behind = Behind()
    behind.mode = Mode.STANDBY
    source, _ = run(behind, smooth(2.0, 10.0), 12.0)
    assert behind.rates == []
    behind.mode = Mode.COMPENSATING
    _, alarms = run(behind, smooth(2.0, 10.0), 70.0, start=12.0, source=source)
    assert not alarms
    assert np.max(behind.rates) == pytest.approx(0.05, rel=0.01)
    assert behind.carried == pytest.approx(2.0, abs=1e-3)


def test_the_controller_goes_along_within_its_share_and_its_depth_set_point_stays(monkeypatch):
    """The mean payout moves, by an integral of what was asked; set-point and depth are where they were."""
    parameters = WinchControllerParameters(winch=WinchModelParameters(speed_limit=1.0, acceleration_limit=1.0))
    controller = WinchController(parameters, tick_period=DT)
    estimation = controller._estimation
    taken, bounds = controller.carry_mean(0.2)
    assert (taken, bounds.speed) == (0.0, 0.3), "at standby the drum stays"
    monkeypatch.setattr(WinchController, "mode", Mode.COMPENSATING)
    asked = [controller.carry_mean(rate)[0] for rate in (0.2, 0.9, -0.9)]
    assert asked == [0.2, 0.3, -0.3]
    for _ in range(400):
        controller.carry_mean(0.2)
        estimation.motion.advance(controller.design.model, 0.0, is_braked=False)
    assert controller.carried == pytest.approx(0.2 * 400 * DT, abs=0.2 * 0.2 / (2.0 * 0.035) + 0.05)
    assert estimation.depth_set_point == 0.0
    assert estimation.set_point == controller.carried


def test_without_what_reads_its_pose_a_crane_is_refused_in_one_line(monkeypatch):
    parameters = WinchControllerParameters(crane=CRANE)
    load_chosen_parts(parameters)
    monkeypatch.setattr("winch_controller_node.node_parameters.extra_parts", lambda group: {})
    with pytest.raises(ParameterError, match=r"system.crane needs heave\[devices\]"):
        load_chosen_parts(parameters)
    load_chosen_parts(WinchControllerParameters())
    assert "crane" in extra_parts("heave.motion_sources")
