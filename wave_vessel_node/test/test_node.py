"""The ROS shell: messages carry what the component says. The tick protocol has its own tests in node_base."""

import math

import numpy as np
import pytest
from heave_msgs.msg import PointMotion as PointMotionMessage
from heave_msgs.msg import SeaState
from heave_node.numerics.kinematics import PointMotion
from heave_node.tick.tick import Tick, stamp_of
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message
from wave_vessel_node.component import WaveVessel
from wave_vessel_node.parameters import WaveVesselParameters
from wave_vessel_node.vessel.motion import VesselMotions

from wave_vessel_node import conversions as messages
from wave_vessel_node import node

NOW = 12_500_000_000
STAMP = stamp_of(NOW)


def test_the_boom_tip_goes_out_in_frame_world_with_its_stamp():
    motion = PointMotion(12.5, np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0, 6.0]), np.array([7.0, 8.0, 9.0]))
    message = deserialize_message(messages.boom_tip_message(motion, NOW), PointMotionMessage)
    assert (message.header.frame_id, message.header.stamp) == ("world", STAMP)
    assert (message.position.z, message.velocity.y, message.acceleration.x) == (3.0, 5.0, 7.0)


def test_odometry_has_unit_quaternions_and_world_axes():
    motions = VesselMotions.still(range(1, 3), 0.05)
    motions.heading = math.pi / 2
    motions.six[1, 0], motions.six[1, 1, 5] = [1.0, 0.0, 0.5, 0.1, -0.2, 0.05], 0.1
    message = deserialize_message(messages.odometry_message(motions, 1, NOW), Odometry)
    position, q = message.pose.pose.position, message.pose.pose.orientation
    assert (position.x, position.y, position.z) == pytest.approx((0.0, 1.0, 0.5))
    assert q.x**2 + q.y**2 + q.z**2 + q.w**2 == pytest.approx(1.0)
    assert message.twist.twist.angular.z == pytest.approx(0.1)


@pytest.mark.parametrize("angle", [0.3, -0.7])
def test_a_quaternion_of_one_angle_turns_about_its_axis(angle):
    half = math.sin(angle / 2)
    for axis, angles in enumerate(((angle, 0, 0), (0, angle, 0), (0, 0, angle))):
        q = messages.quaternion(*angles)
        assert q[axis] == pytest.approx(half)
        assert q[3] == pytest.approx(math.cos(angle / 2))


def test_the_sea_state_message_holds_the_target_spectrum():
    state = WaveVessel(WaveVesselParameters(significant_wave_height=2.0), seed=9, tick_period=0.05).sea_state()
    message = deserialize_message(messages.sea_state_message(state, NOW), SeaState)
    assert message.seed == 9
    assert 4 * math.sqrt(np.trapezoid(message.spectral_density, message.angular_frequency)) == pytest.approx(
        2.0, rel=0.02
    )


class Steps(list):
    """Stands in for the component: notes the ticks that it is stepped through."""

    def step(self, number: int) -> int:
        self.append(number)
        return number


def test_each_tick_is_worked_out_once_in_advance_or_within_and_a_fault_begins_after_what_is_worked_out():
    shell = node.WaveVesselNode.__new__(node.WaveVesselNode)
    shell.component, shell._prepared, shell.tick = Steps(), None, None
    assert shell.next_tick == 1
    for number in (1, 2, 3):
        shell.tick = Tick(number, 1, 50_000_000)
        shell.on_inactive_tick(shell.tick)
        assert shell.next_tick == number + 1
        if number == 1:
            shell.prepare(2)
            assert shell.next_tick == 3
    assert shell.component == [1, 2, 3]
