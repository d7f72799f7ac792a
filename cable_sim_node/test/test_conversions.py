"""Messages say what plant, sensors and winch say, in the units and frames of their definitions."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip("heave_msgs")

from builtin_interfaces.msg import Time
from cable_sim_node.component import PlantState
from cable_sim_node.parameters import SeabedParameters, SeabedProfileParameters
from cable_sim_node.physics.seabed import Seabed
from cable_sim_node.winch.command_line import WinchCommand
from cable_sim_node.winch.component import VirtualWinch
from cable_sim_node.winch.parameters import WinchParameters
from heave_msgs.msg import CableState
from heave_msgs.msg import WinchCommand as WinchCommandMessage
from heave_msgs.msg import WinchState as WinchStateMessage
from heave_node.interface import topics
from heave_node.interface.messages import MessageReader
from heave_node.numerics.kinematics import PointMotion
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message
from visualization_msgs.msg import Marker, MarkerArray

from cable_sim_node import conversions, markers

NOW = 12_350_000_000
STAMP = Time(sec=12, nanosec=350_000_000)
MOTION = PointMotion(12.35, np.array([1.0, -2.0, -300.5]), np.array([0.1, 0.2, -0.3]), np.array([0.4, 0.5, 0.6]))
STATE = PlantState(
    time=12.35,
    node_positions=np.array([[1.0, -2.0, -300.5], [0.5, -1.0, -150.0], [0.0, 0.0, 1.0]]),
    segment_tensions=np.array([0.0, 31_000.0]),
    top_tension=33_000.0,
    largest_top_tension=35_000.0,
    unstretched_length=301.0,
    slack_segments=1,
    touchdown=True,
    touchdown_force=1500.0,
    compensator_stroke=0.2,
    unit=MOTION,
    uncompensated=MOTION,
    uncompensated_tension=30_000.0,
    uncompensated_largest_tension=32_000.0,
)


def test_cable_state_holds_the_plant_from_the_unit_upwards() -> None:
    message = deserialize_message(conversions.cable_state_message(STATE, NOW), CableState)
    assert (message.header.stamp, message.header.frame_id) == (STAMP, "world")
    assert [(p.x, p.y, p.z) for p in message.nodes] == [tuple(row) for row in STATE.node_positions]
    assert list(message.segment_tension) == [0.0, 31_000.0]
    assert (message.bottom_tension, message.top_tension, message.unstretched_length) == (0.0, 33_000.0, 301.0)
    assert (message.slack_segments, message.touchdown, message.touchdown_force) == (1, True, 1500.0)
    assert message.compensator_stroke == 0.2
    assert message.largest_top_tension == 35_000.0


def test_point_motion_survives_the_way_there_and_back() -> None:
    reader = MessageReader(topics.BOOM_TIP.type, conversions.POINT_MOTION)
    back = conversions.point_motion_of(reader.reading(conversions.point_motion_message(MOTION, NOW)))
    for name in ("position", "velocity", "acceleration"):
        np.testing.assert_array_equal(getattr(back, name), getattr(MOTION, name))
    assert back.time == pytest.approx(12.35)


def test_odometry_of_the_unit_is_in_world_with_the_unit_upright() -> None:
    message = deserialize_message(conversions.unit_odometry_message(MOTION, NOW), Odometry)
    assert (message.header.frame_id, message.child_frame_id) == ("world", "unit")
    assert message.pose.pose.position.z == -300.5
    assert message.twist.twist.linear.z == -0.3
    q = message.pose.pose.orientation
    assert (q.x, q.y, q.z, q.w) == (0.0, 0.0, 0.0, 1.0)


def test_winch_state_and_command_keep_every_field() -> None:
    winch = VirtualWinch(WinchParameters(command_delay=0.0), tick_period=0.05)
    for tick in range(1, 20):
        state = winch.step(tick, WinchCommand(tick, 0.0, 5.0), 30_000.0)
    message = deserialize_message(conversions.winch_state_message(state, NOW), WinchStateMessage)
    for name, value in state._asdict().items():
        if name not in ("time", "limits_hit"):
            assert getattr(message, name) == value, name
    assert message.limits_hit == WinchStateMessage.LIMIT_SPEED + WinchStateMessage.LIMIT_ACCELERATION
    assert message.power < 0.0
    command = WinchCommandMessage(sequence=7, payout=1.5, payout_rate=-0.2, brake=True, mean_payout=1.25)
    reader = MessageReader(topics.WINCH_COMMAND.type, conversions.WINCH_COMMAND)
    heard = reader.reading(bytes(serialize_message(command)))
    assert conversions.winch_command_of(heard) == WinchCommand(7, 1.5, -0.2, True, 1.25)


def test_hardware_that_knows_only_its_encoder_moves_the_plant_by_it() -> None:
    nan = math.nan
    message = WinchStateMessage(
        payout=nan, payout_rate=nan, payout_acceleration=nan, encoder_payout=1.25, encoder_payout_rate=0.5
    )
    reader = MessageReader(topics.WINCH_STATE.type, conversions.DRUM_MOTION)
    drum = conversions.drum_motion_of(reader.reading(bytes(serialize_message(message))))
    assert (drum.position[0], drum.velocity[0], drum.acceleration[0]) == (1.25, 0.5, 0.0)
    message.payout, message.payout_rate, message.payout_acceleration = 1.2501, 0.49, -0.1
    reader = MessageReader(topics.WINCH_STATE.type, conversions.DRUM_MOTION)
    drum = conversions.drum_motion_of(reader.reading(bytes(serialize_message(message))))
    assert (drum.position[0], drum.velocity[0], drum.acceleration[0]) == (1.2501, 0.49, -0.1)


def shown(seabed: SeabedParameters) -> list[Marker]:
    """Return the markers of STATE as RViz reads them."""
    return list(deserialize_message(markers.plant_markers(STATE, seabed, NOW), MarkerArray).markers)


def test_markers_show_every_part_and_a_slack_segment_in_red() -> None:
    cable, unit, *others, seabed = all_of_them = shown(SeabedParameters(depth=300.0, slope=(0.01, 0.0)))
    assert [marker.id for marker in all_of_them] == [0, 1, 2, 3, 4, 5]
    assert cable.type == Marker.LINE_STRIP
    assert [(p.x, p.y, p.z) for p in cable.points] == [tuple(row) for row in STATE.node_positions]
    assert len(cable.colors) == len(cable.points)
    rgba = [(c.r, c.g, c.b, c.a) for c in cable.colors]
    assert rgba[0] == pytest.approx(markers.SLACK)
    assert rgba[1] == pytest.approx(markers.TAUT)
    place = unit.pose.position
    assert (place.x, place.y, place.z) == (1.0, -2.0, -300.5)
    assert [marker.type for marker in (unit, *others, seabed)] == [Marker.CUBE] * 2 + [Marker.SPHERE] + [
        Marker.TRIANGLE_LIST
    ] * 2
    for p in seabed.points:
        assert p.z == pytest.approx(-300.0 + 0.01 * p.x)
    assert all(m.header.frame_id == "world" and m.header.stamp == STAMP for m in all_of_them)
    assert all(m.pose.orientation.w == 1.0 and m.color.a > 0.0 for m in all_of_them)


def test_a_seabed_with_a_profile_is_shown_as_far_as_that_reaches() -> None:
    profile = SeabedProfileParameters(distance=(0.0, 1000.0), height=(0.0, 50.0), direction=0.5)
    seabed = SeabedParameters(depth=300.0, slope=(0.0, 0.02), profile=profile)
    points = shown(seabed)[5].points
    assert len(points) % 3 == 0
    for p in points:
        assert p.z == pytest.approx(Seabed(seabed).height((p.x, p.y)))
    assert max(p.x * math.cos(0.5) + p.y * math.sin(0.5) for p in points) == pytest.approx(1000.0)


def test_without_a_seabed_none_is_shown() -> None:
    assert len(shown(SeabedParameters())) == 5
