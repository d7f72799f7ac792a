"""The MRU's motion at a boom tip that moves, against a rotation matrix and its differences."""

import math
from dataclasses import replace

import numpy as np
import pytest
from heave_devices.crane.in_front import CraneInFront
from heave_devices.crane.tip_carry import APPROACH, TipCarry
from heave_node.crane.kinematics import Crane
from heave_node.crane.pose import CranePose
from heave_node.interface.sensors import MruReading
from scipy.spatial.transform import Rotation
from winch_controller_node.core.component import WinchController
from winch_controller_node.interface.readings import Measurements, ScalarReading
from winch_controller_node.interface.sensors import MruModelParameters
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import CraneModelParameters

DT = 0.05
CRANE = CraneModelParameters(boom_length=22.0, jib_length=8.0, offset=1.5, slew=1.5, luff=0.8, knuckle=-0.6)


def carry_of(crane, mru=None):
    return TipCarry(crane, mru or MruModelParameters())


def joints(t):
    return (1.5 + 0.02 * t, 0.8 + 0.05 * math.sin(0.1 * t), -0.6, 0.0)


def rates(t):
    return (0.02, 0.005 * math.cos(0.1 * t), 0.0, 0.0)


def attitude(t):
    return 0.05 * math.sin(0.7 * t), 0.03 * math.sin(0.6 * t + 1.0)


def raised(t):
    """Return how high the tip is above where it is in the reference pose: the third component of R_y R_x arm."""
    return float(Rotation.from_euler("xy", attitude(t)).apply(Crane(CRANE).tip(joints(t)).arm)[2])


def by_ship(t):
    """Return the part of that height which roll and pitch make: the crane's own lift is the winch's to make up for."""
    return raised(t) - Crane(CRANE).tip(joints(t)).arm[2]


def delivered(t, pose=True, still=False):
    roll, pitch = (0.0, 0.0) if still else attitude(t)
    poses = (CranePose(t, joints(t), rates(t)),) if pose else ()
    return Measurements(mru=(MruReading(t, 0.3, 0.1, roll, pitch),)), poses


def carried(carry, times, **given):
    """Return the readings of the tip at `times`."""
    return [carry.carried(t, *delivered(t, **given)).mru[0] for t in times]


def test_heave_and_rate_are_those_of_the_tip():
    times = np.arange(0.0, 40.0, DT).tolist()
    found = carried(carry_of(CRANE), times)
    for t, reading in list(zip(times, found, strict=True))[20:]:
        assert reading.heave == pytest.approx(0.3 + by_ship(t), abs=1e-9)
        rate = (by_ship(t + 1e-5) - by_ship(t - 1e-5)) / 2e-5
        # roll and pitch rates are a parabola's of 0.6 s: 1 % of 0.7 rad/s times 0.05 rad, on an arm of 20 m
        assert reading.heave_rate == pytest.approx(0.1 + rate, abs=0.01)
        assert math.isnan(reading.heave_acceleration)


def test_without_a_pose_what_was_delivered_stays_the_same_object():
    carry = carry_of(CRANE)
    given, poses = delivered(1.0, pose=False)
    assert carry.carried(1.0, given, poses) is given
    assert carry.pose.news() == []


def test_an_mru_without_rate_has_none_at_the_tip_either():
    carry = carry_of(CRANE)
    given, poses = delivered(1.0)
    alone = replace(given, mru=(given.mru[0]._replace(heave_rate=math.nan),))
    assert math.isnan(carry.carried(1.0, alone, poses).mru[0].heave_rate)


def test_a_stale_pose_holds_the_tip_and_one_that_is_back_elsewhere_does_not_step():
    """The tip is up to 0.3 m higher by pitch after a minute of slewing: a step would be that of the arm at once."""
    carry = carry_of(CRANE)
    carried(carry, np.arange(0.0, 5.0, DT).tolist())
    lost = carried(carry, np.arange(5.0, 65.0, DT).tolist(), pose=False)
    assert carry.pose.fault == "CRANE_POSE_STALE"
    back = carried(carry, np.arange(65.0, 90.0, DT).tolist())
    heave = [reading.heave for reading in (*lost, *back)]
    rate = [reading.heave_rate for reading in (*lost, *back)]
    # heave has no step that its own rate does not say: 0.05 s of the rate's error of 0.01 m/s, and of its changes
    error = np.diff(heave) - 0.5 * DT * (np.array(rate[1:]) + rate[:-1])
    assert np.abs(error).max() < 0.01
    # at last the arm is where the pose says, and no height was added for what moved unseen
    carry_now = carry.place.arm
    assert carry_now == pytest.approx(Crane(CRANE).tip(joints(89.95)).arm)
    assert APPROACH < 25.0


def test_what_the_ship_adds_passes_the_high_pass_of_the_mru():
    """A boom slewed by 60 degrees on a ship that rolls by a sine: gain and phase are those of the formula."""
    period, omega = 40.0, 2.0 * math.pi / 10.0
    crane = CraneModelParameters(boom_length=22.0, slew=1.5, luff=0.8)
    carry = carry_of(crane, MruModelParameters(high_pass_period=period))
    pose, times, heave = (1.5 + math.pi / 3.0, 0.8, 0.0, 0.0), np.arange(0.0, 400.0, DT), []
    for t in times.tolist():
        reading = MruReading(t, 0.0, 0.0, roll=0.01 * math.sin(omega * t))
        heave.append(carry.carried(t, Measurements(mru=(reading,)), (CranePose(t, pose),)).mru[0].heave)
    cut = 2.0 * math.pi / period
    response = -(omega**2) / (cut**2 - omega**2 + 2j * 0.7071 * cut * omega)
    last = times > 200.0
    phasor = 2.0 * np.mean(np.array(heave)[last] * np.exp(-1j * omega * times[last]))
    y = Crane(crane).tip(pose).arm[1]
    # the phasor of sin is -i; a parabola over 0.6 s has a slope at its end that errs by 0.1 (omega 0.6 s)^2 = 1.4 %, of
    # the share 2 zeta cut / omega = 0.35 that is taken off: 0.005; trapezoids err by (omega h)^2 / 12 = 8e-5
    assert phasor / (-1j * 0.01 * y) == pytest.approx(response, abs=6e-3)


def test_what_a_boom_lifts_is_no_heave_and_readings_are_those_below_the_place_that_it_has_moved():
    """A unit that keeps its depth while the jib extends upwards by 0.2 m/s: by geometry it is so much further down."""
    carry, up, seen = carry_of(CRANE), math.sin(0.2), []  # of the jib at 0.8 - 0.6 rad
    for n in range(41):
        t = n * DT
        pose = CranePose(t, (1.5, 0.8, -0.6, 0.2 * t), (0.0, 0.0, 0.0, 0.2))
        scalar = {"depth": (ScalarReading(t - 0.1, 100.0),), "velocity": (ScalarReading(t, 0.0),)}
        taken = carry.carried(t, Measurements((MruReading(t, 0.0, 0.0),), scalar), (pose,))
        seen.append((taken.mru[0].heave, taken.of("depth")[0].value, taken.of("velocity")[0].value))
    assert [heave for heave, _, _ in seen] == pytest.approx([0.0] * 41, abs=1e-9)
    assert [depth for _, depth, _ in seen] == pytest.approx([100.0 + 0.2 * up * (n * DT - 0.1) for n in range(41)])
    assert [rate for _, _, rate in seen] == pytest.approx([-0.2 * up] * 41)


def test_a_pose_for_a_crane_without_lengths_is_told_once_and_not_used():
    behind = WinchController(WinchControllerParameters(), tick_period=DT)
    source = CraneInFront(behind, DT)
    given, poses = delivered(1.0)
    codes = [alarm.name for tick in (1, 2) for alarm in source.step(tick, given, poses).alarms]
    assert [code for code in codes if code.startswith("CRANE")] == ["CRANE_LENGTHS_MISSING"]
    assert source.carry.place is None
    assert source.health() == {}


def test_the_alarms_of_the_pose_are_those_of_the_tick():
    source = CraneInFront(WinchController(WinchControllerParameters(crane=CRANE), tick_period=DT), DT)
    codes = [alarm.name for tick in range(1, 4) for alarm in source.step(tick, *delivered(tick * DT)).alarms]
    assert codes == ["CRANE_POSE_USED"]
    assert source.health()["crane"][0]
