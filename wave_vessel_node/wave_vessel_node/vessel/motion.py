"""Motion of the vessel in six degrees of freedom, and of a point of it.

Axes as in REP-103: x forward, y to port, z up; roll about x, pitch about y (bow down positive), yaw about z. Motions
are small: rigid-body kinematics to first order.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import PointMotion

SURGE, SWAY, HEAVE, ROLL, PITCH, YAW = range(6)
DEGREES_OF_FREEDOM = ("surge", "sway", "heave", "roll", "pitch", "yaw")


@dataclass
class VesselMotion:
    """Motion of the vessel's reference point about its mean, vessel axes, at one time."""

    time: float = 0.0  # simulated time [s]
    # surge, sway, heave [m], roll, pitch, yaw [rad] and derivatives, shape (6,)
    displacement: Array = field(default_factory=lambda: np.zeros(6))
    # surge, sway, heave [m], roll, pitch, yaw [rad] and derivatives, shape (6,)
    velocity: Array = field(default_factory=lambda: np.zeros(6))
    # surge, sway, heave [m], roll, pitch, yaw [rad] and derivatives, shape (6,)
    acceleration: Array = field(default_factory=lambda: np.zeros(6))
    elevation: float = 0.0  # sea surface above still water below the boom tip [m]
    heading: float = 0.0  # mean heading from world x [rad] and derivatives
    turn_rate: float = 0.0  # mean heading from world x [rad] and derivatives
    turn_acceleration: float = 0.0  # mean heading from world x [rad] and derivatives
    speed: float = 0.0  # mean forward speed [m/s]


def lever_arm_matrix(arm: Array) -> Array:
    """Return T, shape (3, 6): the displacement of a point at `arm` [m] is T q, q the six motions.

    x: surge + z pitch - y yaw; y: sway + x yaw - z roll; z: heave - x pitch + y roll.
    """
    x, y, z = arm
    cross = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    return np.hstack((np.eye(3), cross))


def point_motion(motion: VesselMotion, lever: Array, mean_height: float, own: Array | None = None) -> PointMotion:
    """Return the motion of a point in frame world, whose origin is below the mean point.

    Parameters
    ----------
    motion : of the vessel's reference point
    lever : `lever_arm_matrix` of the point
    mean_height : mean z of the point [m]
    own : what the point moves by itself, vessel axes: position from the mean point, velocity, acceleration, shape
        (3, 3); None: it does not

    The frame travels with the mean position of the vessel: forward speed is not in it.
    """
    six = np.array((motion.displacement, motion.velocity, motion.acceleration))
    vessel = six @ lever.T
    if own is not None:
        vessel += own
    if motion.turn_rate != 0.0:
        _add_turning(vessel, motion.turn_rate, motion.turn_acceleration)
    if motion.heading != 0.0:
        cosine, sine = np.cos(motion.heading), np.sin(motion.heading)
        x, y = vessel[:, 0].copy(), vessel[:, 1].copy()
        vessel[:, 0], vessel[:, 1] = cosine * x - sine * y, sine * x + cosine * y
    vessel[0, 2] += mean_height
    return PointMotion(motion.time, vessel[0], vessel[1], vessel[2])


def _add_turning(vessel: Array, rate: float, acceleration: float) -> None:
    """Add to velocity and acceleration (rows 1, 2) what turning axes give a point that is off the mean."""
    position, velocity = vessel[0, :2].copy(), vessel[1, :2].copy()
    across, across_velocity = np.array([-position[1], position[0]]), np.array([-velocity[1], velocity[0]])
    vessel[1, :2] += rate * across
    vessel[2, :2] += 2.0 * rate * across_velocity - rate**2 * position + acceleration * across
