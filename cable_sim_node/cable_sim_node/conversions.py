"""Plant and winch data as serialised messages, and back; readings of sensors are `heave_node.interface.messages`.

Each table names the fields of a message in the order in which the function below it fills or reads them.
"""

from __future__ import annotations

import math
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np
from heave_node.cdr.packer import Packer
from heave_node.interface import topics
from heave_node.interface.sensors import WireReading
from heave_node.interface.waves import Waves
from heave_node.numerics.kinematics import PointMotion
from heave_node.tick.tick import seconds_of

from cable_sim_node.winch.command_line import WinchCommand
from cable_sim_node.winch.component import WinchState

if TYPE_CHECKING:  # the winch converts without the plant and its solver
    from cable_sim_node.component import PlantState

WORLD = "world"
UNIT = "unit"

_STAMP = "header.stamp"
_IN_WORLD = {"header.frame_id": WORLD}

CABLE_SCALARS = (
    *("top_tension", "largest_top_tension", "unstretched_length", "slack_segments", "touchdown", "touchdown_force"),
    "compensator_stroke",
)
_cable_scalars = attrgetter(*CABLE_SCALARS)
_CABLE_STATE = Packer(
    topics.CABLE_STATE.type, (_STAMP, "nodes", "segment_tension", "bottom_tension", *CABLE_SCALARS), _IN_WORLD
)

POINT_MOTION = ("position", "velocity", "acceleration")
_POINT_MOTION = Packer(topics.BOOM_TIP.type, (_STAMP, *POINT_MOTION), _IN_WORLD)

_UNIT_ODOMETRY = Packer(
    topics.UNIT_ODOMETRY.type,
    (_STAMP, "pose.pose.position", "twist.twist.linear"),
    # the unit does not turn: its frame has the axes of the world
    {**_IN_WORLD, "child_frame_id": UNIT, "pose.pose.orientation.w": 1.0},
)

WINCH_STATE = (
    *("command_sequence", "payout", "payout_rate", "payout_acceleration", "encoder_payout", "encoder_payout_rate"),
    *("tension", "power", "limits_hit", "brake", "fault", "release"),
)
_winch_values = attrgetter(*WINCH_STATE)
_WINCH_STATE = Packer(topics.WINCH_STATE.type, (_STAMP, *WINCH_STATE))

WINCH_COMMAND = ("sequence", "payout", "payout_rate", "brake", "mean_payout")
DRUM_MOTION = ("payout", "payout_rate", "payout_acceleration", "encoder_payout", "encoder_payout_rate")


def cable_state_message(state: PlantState, stamp: int) -> bytes:
    """Return the `state` of the cable at `stamp` [ns]."""
    tensions = state.segment_tensions
    return _CABLE_STATE.pack(stamp, state.node_positions, tensions, tensions[0], *_cable_scalars(state))


def point_motion_message(motion: PointMotion, stamp: int) -> bytes:
    """Return the `motion` of a point at `stamp` [ns], frame `world`."""
    return _POINT_MOTION.pack(stamp, motion.position, motion.velocity, motion.acceleration)


def point_motion_of(reading: WireReading) -> PointMotion:
    """Return the motion in a `reading` of the fields POINT_MOTION."""
    numbers = np.array(reading.numbers)
    return PointMotion(reading.time, numbers[0:3], numbers[3:6], numbers[6:9])


def waves_of(message: Any) -> Waves:
    """Return the components in a heave_msgs/WaveComponents, the `message`. Raises ValueError where they are none."""
    return Waves(
        np.array(message.frequency, dtype=float),
        np.array(message.encounter_frequency, dtype=float),
        np.array(message.amplitude, dtype=float),
        np.array(message.phase, dtype=float),
        np.array(message.direction, dtype=float),
        start=seconds_of(message.header.stamp),
        ramp=message.ramp,
    )


def unit_odometry_message(motion: PointMotion, stamp: int) -> bytes:
    """Return the true `motion` of the unit at `stamp` [ns]; it stays upright."""
    return _UNIT_ODOMETRY.pack(stamp, motion.position, motion.velocity)


def winch_state_message(state: WinchState, stamp: int) -> bytes:
    """Return the `state` of the winch at `stamp` [ns]."""
    return _WINCH_STATE.pack(stamp, *_winch_values(state))


def winch_command_of(reading: WireReading) -> WinchCommand:
    """Return the command in a `reading` of the fields WINCH_COMMAND."""
    sequence, payout, payout_rate, brake, mean = reading.numbers
    return WinchCommand(int(sequence), payout, payout_rate, bool(brake), mean)


def drum_motion_of(reading: WireReading) -> PointMotion:
    """Return a `reading` of the fields DRUM_MOTION as a motion with one coordinate, payout [m].

    It is the drum's truth, or the encoder's reading of hardware that has nothing better (without acceleration).
    """
    truth, encoder = reading.numbers[:3], (*reading.numbers[3:], 0.0)
    payout, rate, acceleration = truth if all(math.isfinite(value) for value in truth) else encoder
    return PointMotion(reading.time, np.array([payout]), np.array([rate]), np.array([acceleration]))
