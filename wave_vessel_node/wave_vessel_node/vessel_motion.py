"""Motion of the vessel in six degrees of freedom, and of a point of it.

Axes as in REP-103: x forward, y to port, z up; roll about x, pitch about y (bow down positive), yaw about z. Motions
are small: rigid-body
kinematics to first order.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from heave_node.kinematics import PointMotion
from numpy.typing import NDArray

Array = NDArray[np.float64]

SURGE, SWAY, HEAVE, ROLL, PITCH, YAW = range(6)
DEGREES_OF_FREEDOM = ("surge", "sway", "heave", "roll", "pitch", "yaw")


@dataclass
class VesselMotion:
    """Motion of the vessel's reference point about its mean, vessel axes, at one time.

    Attributes
    ----------
    time : simulated time [s]
    displacement, velocity, acceleration : surge, sway, heave [m], roll, pitch, yaw [rad] and derivatives, shape (6,)
    elevation : sea surface above still water below the boom tip [m]
    heading, turn_rate, speed : mean heading from world x [rad], its rate [rad/s], forward speed [m/s]
    """

    time: float = 0.0
    displacement: Array = field(default_factory=lambda: np.zeros(6))
    velocity: Array = field(default_factory=lambda: np.zeros(6))
    acceleration: Array = field(default_factory=lambda: np.zeros(6))
    elevation: float = 0.0
    heading: float = 0.0
    turn_rate: float = 0.0
    speed: float = 0.0


def lever_arm_matrix(arm: Array) -> Array:
    """Return T, shape (3, 6): the displacement of a point at `arm` [m] is T q, q the six motions.

    x: surge + z pitch - y yaw; y: sway + x yaw - z roll; z: heave - x pitch + y roll.
    """
    x, y, z = arm
    cross = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    return np.hstack((np.eye(3), cross))


def point_motion(motion: VesselMotion, arm: Array, mean_height: float) -> PointMotion:
    """Return the motion of the point at `arm` (vessel axes) in frame world, whose origin is below the mean point.

    The frame travels with the mean position of the vessel (forward speed is not in it); `mean_height` is the mean z of
    the point.
    """
    lever = lever_arm_matrix(arm)
    cosine, sine = np.cos(motion.heading), np.sin(motion.heading)
    rotation = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    to_world = rotation @ lever
    position = to_world @ motion.displacement
    position[2] += mean_height
    return PointMotion(motion.time, position, to_world @ motion.velocity, to_world @ motion.acceleration)
