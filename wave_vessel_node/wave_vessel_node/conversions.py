"""Serialised messages of the sea and vessel from the plain data of its component.

Each table names the fields of a message in the order in which the function below fills them. Messages of the MRU are
made by `heave_node.interface.messages`.
"""

from __future__ import annotations

import math
from operator import attrgetter

from heave_node.cdr.packer import Packer
from heave_node.interface import topics
from heave_node.interface.preview import HeavePreview
from heave_node.interface.waves import Waves
from heave_node.numerics import kinematics

from wave_vessel_node.mru import sea_state_estimate
from wave_vessel_node.sea import sea
from wave_vessel_node.vessel.motion import VesselMotions

WORLD, VESSEL = "world", "vessel"

_STAMP = "header.stamp"
_IN_WORLD = {"header.frame_id": WORLD}

_BOOM_TIP = Packer(topics.BOOM_TIP.type, (_STAMP, "position", "velocity", "acceleration"), _IN_WORLD)
_ELEVATION = Packer(topics.WAVE_ELEVATION.type, (_STAMP, "elevation"), _IN_WORLD)
_PREVIEW = Packer(topics.HEAVE_PREVIEW.type, (_STAMP, "ahead", "heave", "heave_sigma"), _IN_WORLD)
_ODOMETRY = Packer(
    topics.VESSEL_ODOMETRY.type, (_STAMP, "pose.pose", "twist.twist"), {**_IN_WORLD, "child_frame_id": VESSEL}
)

_SEA_FIELDS = (
    *("spectrum", "significant_wave_height", "peak_period", "zero_crossing_period", "peak_enhancement", "heading"),
    *("spreading", "seed", "angular_frequency", "spectral_density"),
)
_sea_values = attrgetter(*_SEA_FIELDS)
_SEA_STATE = Packer(topics.SEA_STATE.type, (_STAMP, *_SEA_FIELDS), _IN_WORLD)

_WAVE_COMPONENTS = Packer(
    topics.WAVE_COMPONENTS.type,
    (_STAMP, "ramp", "frequency", "encounter_frequency", "amplitude", "phase", "direction"),
    _IN_WORLD,
)

_ESTIMATE_FIELDS = (
    *("record_length", "significant_wave_height", "significant_wave_height_interval", "peak_period"),
    *("peak_period_interval", "boom_tip_sigma", "angular_frequency", "spectral_density"),
)
_estimate_values = attrgetter(*_ESTIMATE_FIELDS)
_ESTIMATE = Packer(topics.SEA_STATE_ESTIMATE.type, (_STAMP, "valid", *_ESTIMATE_FIELDS), _IN_WORLD)


def boom_tip_message(motion: kinematics.PointMotion, stamp: int) -> bytes:
    """Return the true motion of the boom tip at `stamp` [ns]."""
    return _BOOM_TIP.pack(stamp, motion.position, motion.velocity, motion.acceleration)


def elevation_message(elevation: float, stamp: int) -> bytes:
    """Return the elevation of the sea at `stamp` [ns]."""
    return _ELEVATION.pack(stamp, elevation)


def preview_message(preview: HeavePreview, noise: float) -> bytes:
    """Return a `preview` of the boom tip and its error, `noise` [m], 1 sigma."""
    return _PREVIEW.pack(preview.stamp, preview.ahead, preview.heave, noise)


def odometry_message(motions: VesselMotions, row: int, stamp: int) -> bytes:
    """Return a `row` of `motions` at `stamp` [ns]: pose about the mean in world axes, twist in vessel axes."""
    heading = motions.heading
    cosine, sine = math.cos(heading), math.sin(heading)
    surge, sway, heave, roll, pitch, yaw = motions.six[row, 0].tolist()
    position = (cosine * surge - sine * sway, sine * surge + cosine * sway, heave)
    return _ODOMETRY.pack(stamp, (*position, *quaternion(roll, pitch, heading + yaw)), motions.six[row, 1].tolist())


def sea_state_message(state: sea.SeaState, stamp: int) -> bytes:
    """Return `state`, the sea that the vessel is in, from `stamp` on [ns]."""
    return _SEA_STATE.pack(stamp, *_sea_values(state))


def waves_message(waves: Waves) -> bytes:
    """Return the components of a sea, its `waves`, stamped with the start of their ramp."""
    return _WAVE_COMPONENTS.pack(round(waves.start * 1e9), waves.ramp, *waves.columns)


def estimate_message(estimate: sea_state_estimate.SeaStateEstimate, stamp: int) -> bytes:
    """Return the `estimate` of the sea state from the MRU record that ends at `stamp` [ns]."""
    is_valid = math.isfinite(estimate.peak_period) and estimate.significant_wave_height > 0.0
    return _ESTIMATE.pack(stamp, is_valid, *_estimate_values(estimate))


def quaternion(roll: float, pitch: float, yaw: float) -> tuple[float, float, float, float]:
    """Return x, y, z, w of the rotation about z by yaw, then y by pitch, then x by roll (intrinsic): REP-103."""
    cr, sr = math.cos(0.5 * roll), math.sin(0.5 * roll)
    cp, sp = math.cos(0.5 * pitch), math.sin(0.5 * pitch)
    cy, sy = math.cos(0.5 * yaw), math.sin(0.5 * yaw)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )
