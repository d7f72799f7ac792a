"""Plant and winch data as ROS messages, and back; readings of sensors are `heave_node.interface.messages`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Quaternion, Vector3
from heave_msgs.msg import CableState
from heave_msgs.msg import PointMotion as PointMotionMessage
from heave_msgs.msg import WinchCommand as WinchCommandMessage
from heave_msgs.msg import WinchState as WinchStateMessage
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import PointMotion
from heave_node.tick.tick import seconds_of
from nav_msgs.msg import Odometry
from std_msgs.msg import Header

from cable_sim_node.winch.component import WinchCommand, WinchState

if TYPE_CHECKING:  # the winch converts without the plant and its solver
    from cable_sim_node.component import PlantState


WORLD = "world"
UNIT = "unit"
UPRIGHT = (0.0, 0.0, 0.0, 1.0)


def header(stamp: Time, frame: str) -> Header:
    """Return the header of a message of `stamp` in `frame`."""
    return Header(stamp=stamp, frame_id=frame)


def _vector(values: Array) -> Vector3:
    return Vector3(x=float(values[0]), y=float(values[1]), z=float(values[2]))


def point_message(values: Array) -> Point:
    """Return the position `values`, shape (3,) [m], as a message."""
    return Point(x=float(values[0]), y=float(values[1]), z=float(values[2]))


def _upright() -> Quaternion:
    x, y, z, w = UPRIGHT
    return Quaternion(x=x, y=y, z=z, w=w)


def cable_state_message(state: PlantState, stamp: Time) -> CableState:
    """Return the `state` of the cable at `stamp`."""
    return CableState(
        header=header(stamp, WORLD),
        nodes=[point_message(position) for position in state.node_positions],
        segment_tension=state.segment_tensions,
        top_tension=float(state.top_tension),
        bottom_tension=float(state.segment_tensions[0]),
        unstretched_length=float(state.unstretched_length),
        slack_segments=int(state.slack_segments),
        touchdown=bool(state.touchdown),
        touchdown_force=float(state.touchdown_force),
        compensator_stroke=float(state.compensator_stroke),
    )


def point_motion_message(motion: PointMotion, stamp: Time) -> PointMotionMessage:
    """Return the `motion` of a point at `stamp`, frame `world`."""
    return PointMotionMessage(
        header=header(stamp, WORLD),
        position=point_message(motion.position),
        velocity=_vector(motion.velocity),
        acceleration=_vector(motion.acceleration),
    )


def point_motion_of(message: PointMotionMessage) -> PointMotion:
    """Return the motion that a message tells."""
    p, v, a = message.position, message.velocity, message.acceleration
    return PointMotion(
        seconds_of(message.header.stamp),
        np.array([p.x, p.y, p.z]),
        np.array([v.x, v.y, v.z]),
        np.array([a.x, a.y, a.z]),
    )


def unit_odometry_message(motion: PointMotion, stamp: Time) -> Odometry:
    """Return the true `motion` of the unit at `stamp`. It does not turn: child frame `unit` has the axes of `world`."""
    message = Odometry(header=header(stamp, WORLD), child_frame_id=UNIT)
    message.pose.pose.position = point_message(motion.position)
    message.pose.pose.orientation = _upright()
    message.twist.twist.linear = _vector(motion.velocity)
    return message


def winch_state_message(state: WinchState, stamp: Time) -> WinchStateMessage:
    """Return the `state` of the winch at `stamp`."""
    return WinchStateMessage(
        header=header(stamp, ""),
        command_sequence=state.command_sequence,
        payout=state.payout,
        payout_rate=state.payout_rate,
        payout_acceleration=state.payout_acceleration,
        encoder_payout=state.encoder_payout,
        encoder_payout_rate=state.encoder_payout_rate,
        tension=state.tension,
        power=state.power,
        limits_hit=int(state.limits_hit),
        brake=state.brake,
        fault=int(state.fault),
        release=int(state.release),
    )


def winch_command_of(message: WinchCommandMessage) -> WinchCommand:
    """Return the command that a message tells."""
    return WinchCommand(message.sequence, message.payout, message.payout_rate, message.brake)


def drum_motion_of(message: WinchStateMessage) -> PointMotion:
    """Return payout, rate and acceleration of a `message` as a motion with one coordinate, payout [m].

    They are the drum's truth, or the encoder's reading of hardware that has nothing better (without acceleration).
    """
    truth = (message.payout, message.payout_rate, message.payout_acceleration)
    encoder = (message.encoder_payout, message.encoder_payout_rate, 0.0)
    payout, rate, acceleration = truth if all(math.isfinite(value) for value in truth) else encoder
    return PointMotion(seconds_of(message.header.stamp), np.array([payout]), np.array([rate]), np.array([acceleration]))
