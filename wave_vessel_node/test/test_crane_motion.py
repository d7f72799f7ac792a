"""The simulated crane: the boom tip moves with it, the MRU stays where it is, the pose is what the joints are."""

import math
from dataclasses import replace

import numpy as np
import pytest
from heave_msgs.msg import CranePose
from heave_node.crane.kinematics import Crane
from heave_node.crane.pose import pose_message, pose_to_wire
from heave_node.interface.faults import FaultParameters
from heave_node.parameters import ParameterError, build_parameters
from rclpy.serialization import deserialize_message
from wave_vessel_node.component import WaveVessel
from wave_vessel_node.parameters import (
    CraneMotionParameters,
    PoseSensorParameters,
    PreviewParameters,
    VesselParameters,
    WaveVesselParameters,
)
from wave_vessel_node.vessel.crane_motion import CraneMotion

DT = 0.05
ARM = (-20.0, 10.0, 15.0)
SLEWED = CraneMotionParameters(
    boom_length=24.0, luff=0.6, slew=1.5, move_times=(2.0,), move_slew=(2.5,), move_luff=(0.5,), turn_rate=0.2
)
"""Slew by 1 rad and luff by -0.1 from 2 s on: the longer takes 1.875 / 0.2 = 9.4 s."""
SHIP = WaveVesselParameters(
    vessel=VesselParameters(model="rao"), ramp=1.0, direction=2.0, components=60, boom_tip_height=4.0
)


def outputs_of(parameters, ticks=400):
    vessel = WaveVessel(parameters, seed=1, tick_period=DT)
    return [vessel.step(tick) for tick in range(1, ticks + 1)]


def test_after_the_move_the_tip_moves_as_that_of_a_ship_whose_boom_is_there():
    """The arm of the moved tip is given to a ship without a crane: heave is then the same, to rounding."""
    place = Crane(SLEWED).tip((2.5, 0.5, 0.0, 0.0)).arm
    there = replace(SHIP, vessel=replace(SHIP.vessel, boom_tip_arm=tuple(np.add(ARM, place))))
    moved = outputs_of(replace(SHIP, crane=SLEWED))[300:]
    fixed = outputs_of(there)[300:]
    for one, other in zip(moved, fixed, strict=True):
        assert one.boom_tip.position == pytest.approx(other.boom_tip.position + place, abs=1e-12)
        assert one.boom_tip.velocity == pytest.approx(other.boom_tip.velocity, abs=1e-12)
        assert one.boom_tip.acceleration == pytest.approx(other.boom_tip.acceleration, abs=1e-12)


def test_the_mru_and_the_ship_are_as_without_a_crane_and_so_is_the_tip_before_the_move():
    plain, moved = outputs_of(SHIP, 200), outputs_of(replace(SHIP, crane=SLEWED), 200)
    for tick, (one, other) in enumerate(zip(plain, moved, strict=True), 1):
        assert (one.mru, one.wave_elevation, one.crane) == (other.mru, other.wave_elevation, ())
        if tick < 39:
            np.testing.assert_array_equal(one.boom_tip.position, other.boom_tip.position)


def test_place_velocity_and_acceleration_fit_one_another():
    tips = [one.boom_tip for one in outputs_of(replace(SHIP, crane=SLEWED), 300)]
    series = np.array([[tip.position, tip.velocity, tip.acceleration] for tip in tips]).transpose(1, 0, 2)
    time = (np.arange(300) + 2) * DT
    smooth = np.ones(298, dtype=bool)
    for kink in (1.05, 2.0, 2.0 + 1.875 * 0.1 / 0.2, 2.0 + 1.875 / 0.2):
        smooth &= np.abs(time[1:-1] - kink) > 2.5 * DT  # third derivatives jump there
    for low, high in ((series[0], series[1]), (series[1], series[2])):
        simpson = DT / 3.0 * (high[2:] + 4.0 * high[1:-1] + high[:-2])
        # as in test_component; the shorter move adds h^5 / 90 of its fifth derivative, 720 * 0.1 * 24 m / (0.94 s)^5
        assert np.abs(low[2:] - low[:-2] - simpson)[smooth].max() < 3e-5


def test_a_move_keeps_its_rate_and_ends_where_it_should():
    crane = CraneMotion(SLEWED, np.array(ARM), 0.0)
    states = np.array([crane.joints(t) for t in np.arange(0.0, 15.0, 0.01)])
    assert states[:, 1, 0].max() == pytest.approx(0.2, rel=1e-4)
    assert states[-1, 0].tolist() == [2.5, 0.5, 0.0, 0.0]
    assert not states[-1, 1:].any()
    np.testing.assert_allclose(np.gradient(states[:, 0, 0], 0.01)[1:-1], states[1:-1, 1, 0], atol=1e-5)


def poses_of(crane, ticks):
    """Return the poses of a `crane` by the tick at which they are delivered."""
    ship = WaveVessel(replace(SHIP, crane=crane), seed=1, tick_period=DT)
    return {tick: ship.step(tick).crane for tick in range(1, ticks + 1)}


def test_the_pose_is_published_as_the_joints_are_in_steps_of_the_encoder():
    step, tick = math.tau / 65536.0, round(5.0 / DT)
    (pose,) = poses_of(replace(SLEWED, pose=PoseSensorParameters(angle_resolution=step)), tick)[tick]
    message = deserialize_message(pose_message(pose_to_wire(pose)), CranePose)
    assert message.header.stamp.sec == 5
    assert message.header.frame_id == "vessel"
    joints, rates, _ = CraneMotion(SLEWED, np.array(ARM), 0.0).joints(tick * DT)
    assert message.slew == pytest.approx(joints[0], abs=0.5 * step)
    assert (message.slew / step) == pytest.approx(round(message.slew / step), abs=1e-6)
    assert (message.slew_rate, message.luff_rate) == (rates[0], rates[1])


def faulty(kind, magnitude=0.0):
    """Return the poses of a crane that slews, with a fault of its encoders from tick 100 on and without it."""
    faults = FaultParameters((kind,), (100 * DT,), (0.0,), (magnitude,))
    cranes = (replace(SLEWED, pose=PoseSensorParameters(faults=faults)), SLEWED)
    return [poses_of(crane, 130) for crane in cranes]


@pytest.mark.parametrize(
    ("kind", "magnitude", "of_joint", "of_rate"),
    [("jump", 0.3, lambda joint: joint + 0.3, lambda rate: rate), ("scale", -1.0, lambda joint: -joint, lambda r: -r)],
)
def test_encoders_at_fault_read_every_joint_falsely(kind, magnitude, of_joint, of_rate):
    wrong, right = faulty(kind, magnitude)
    assert wrong[99] == right[99]
    (given,), (true,) = wrong[100], right[100]
    assert given.time == true.time
    assert given.joints == pytest.approx([of_joint(joint) for joint in true.joints])
    assert given.rates == pytest.approx([of_rate(rate) for rate in true.rates])


def test_encoders_that_freeze_stop_or_are_late_are_those_of_any_sensor():
    wrong, right = faulty("freeze")
    assert {(poses[0].joints, poses[0].rates) for tick, poses in wrong.items() if tick >= 99} == {right[99][0][1:]}
    assert wrong[130][0].time == right[130][0].time
    assert not any(poses for tick, poses in faulty("gap")[0].items() if tick >= 100)
    assert np.isnan(faulty("nan")[0][100][0].joints).all()
    wrong, right = faulty("delay", 5 * DT)
    assert wrong[120] == right[115]


def test_a_preview_sees_the_tip_that_moves():
    outputs = outputs_of(replace(SHIP, crane=SLEWED, preview=PreviewParameters(2.0, 0.0)), 160)
    heave = np.array([one.boom_tip.position[2] for one in outputs]) - SHIP.boom_tip_height
    np.testing.assert_array_equal(outputs[100].preview.heave, heave[100:140])


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"boom_length": 20.0, "move_times": [5.0, 2.0]}, "ascending"),
        ({"boom_length": 20.0, "move_times": [5.0], "move_slew": [1.0, 2.0]}, "crane.move_slew must be empty"),
        ({"move_times": [5.0], "move_slew": [1.0]}, "give crane.boom_length"),
    ],
)
def test_a_programme_that_cannot_be_is_refused(given, words):
    with pytest.raises(ParameterError, match=words):
        build_parameters(WaveVesselParameters, {f"crane.{name}": value for name, value in given.items()}, where="x")
