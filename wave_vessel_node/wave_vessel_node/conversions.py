"""Messages of the sea and vessel from the plain data of its component.

Those of the MRU are made by `heave_node.interface.messages`.

No rclpy: message classes are plain data.
"""

from __future__ import annotations

import math

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Quaternion, Vector3
from heave_msgs.msg import HeavePreview as HeavePreviewMessage
from heave_msgs.msg import PointMotion, SeaState, SeaStateEstimate, WaveElevation
from heave_node.interface.preview import HeavePreview
from heave_node.numerics import kinematics
from heave_node.tick.tick import stamp_of
from nav_msgs.msg import Odometry

from wave_vessel_node.mru import sea_state_estimate
from wave_vessel_node.sea import sea
from wave_vessel_node.vessel.motion import VesselMotion

WORLD, VESSEL = "world", "vessel"


def boom_tip_message(motion: kinematics.PointMotion, stamp: Time) -> PointMotion:
    """Return the true motion of the boom tip at `stamp`."""
    message = PointMotion()
    message.header.stamp, message.header.frame_id = stamp, WORLD
    message.position = Point(**_xyz(motion.position))
    message.velocity = Vector3(**_xyz(motion.velocity))
    message.acceleration = Vector3(**_xyz(motion.acceleration))
    return message


def elevation_message(elevation: float, stamp: Time) -> WaveElevation:
    """Return the elevation of the sea at `stamp`."""
    message = WaveElevation(elevation=float(elevation))
    message.header.stamp, message.header.frame_id = stamp, WORLD
    return message


def preview_message(preview: HeavePreview, noise: float) -> HeavePreviewMessage:
    """Return a `preview` of the boom tip and its error, `noise` [m], 1 sigma."""
    message = HeavePreviewMessage(ahead=preview.ahead, heave=preview.heave, heave_sigma=noise)
    message.header.stamp, message.header.frame_id = stamp_of(preview.stamp), WORLD
    return message


def odometry_message(motion: VesselMotion, stamp: Time) -> Odometry:
    """Return the vessel's motion at `stamp`: pose about its mean in world axes, twist in vessel axes."""
    message = Odometry()
    message.header.stamp, message.header.frame_id = stamp, WORLD
    message.child_frame_id = VESSEL
    cosine, sine = math.cos(motion.heading), math.sin(motion.heading)
    surge, sway, heave, roll, pitch, yaw = (float(value) for value in motion.displacement)
    message.pose.pose.position = Point(x=cosine * surge - sine * sway, y=sine * surge + cosine * sway, z=heave)
    message.pose.pose.orientation = quaternion(roll, pitch, motion.heading + yaw)
    twist = motion.velocity.copy()
    twist[5] += motion.turn_rate
    message.twist.twist.linear = Vector3(**_xyz(twist[:3]))
    message.twist.twist.angular = Vector3(**_xyz(twist[3:]))
    return message


def sea_state_message(state: sea.SeaState, stamp: Time) -> SeaState:
    """Return `state`, the sea that the vessel is in, from `stamp` on."""
    message = SeaState()
    message.header.stamp, message.header.frame_id = stamp, WORLD
    message.spectrum = state.spectrum
    message.significant_wave_height = float(state.significant_wave_height)
    message.peak_period = float(state.peak_period)
    message.zero_crossing_period = float(state.zero_crossing_period)
    message.peak_enhancement = float(state.peak_enhancement)
    message.heading, message.spreading = float(state.heading), float(state.spreading)
    message.seed = state.seed
    message.angular_frequency = state.angular_frequency.tolist()
    message.spectral_density = state.spectral_density.tolist()
    return message


def estimate_message(estimate: sea_state_estimate.SeaStateEstimate, stamp: Time) -> SeaStateEstimate:
    """Return the `estimate` of the sea state from the MRU record that ends at `stamp`."""
    message = SeaStateEstimate()
    message.header.stamp, message.header.frame_id = stamp, WORLD
    message.valid = math.isfinite(estimate.peak_period) and estimate.significant_wave_height > 0.0
    message.record_length = estimate.record_length
    message.significant_wave_height = estimate.significant_wave_height
    message.significant_wave_height_interval = np.array(estimate.significant_wave_height_interval)
    message.peak_period = estimate.peak_period
    message.peak_period_interval = np.array(estimate.peak_period_interval)
    message.boom_tip_sigma = estimate.boom_tip_sigma
    message.angular_frequency = estimate.angular_frequency.tolist()
    message.spectral_density = estimate.spectral_density.tolist()
    return message


def quaternion(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the rotation about z by yaw, then y by pitch, then x by roll (intrinsic), as REP-103 names them."""
    cr, sr = math.cos(0.5 * roll), math.sin(0.5 * roll)
    cp, sp = math.cos(0.5 * pitch), math.sin(0.5 * pitch)
    cy, sy = math.cos(0.5 * yaw), math.sin(0.5 * yaw)
    return Quaternion(
        w=cr * cp * cy + sr * sp * sy,
        x=sr * cp * cy - cr * sp * sy,
        y=cr * sp * cy + sr * cp * sy,
        z=cr * cp * sy - sr * sp * cy,
    )


def _xyz(vector: np.ndarray) -> dict[str, float]:
    return {"x": float(vector[0]), "y": float(vector[1]), "z": float(vector[2])}
