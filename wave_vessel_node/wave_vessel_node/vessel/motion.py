"""Motion of the vessel in six degrees of freedom, and of a point of it.

Axes as in REP-103: x forward, y to port, z up; roll about x, pitch about y (bow down positive), yaw about z. Motions
are small: rigid-body kinematics to first order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array

SURGE, SWAY, HEAVE, ROLL, PITCH, YAW = range(6)
DEGREES_OF_FREEDOM = ("surge", "sway", "heave", "roll", "pitch", "yaw")


@dataclass
class VesselMotions:
    """Motion of the vessel's reference point about its mean, vessel axes, at n ticks in order."""

    time: Array  # simulated time [s], shape (n,)
    six: Array  # surge, sway, heave [m], roll, pitch, yaw [rad], and two derivatives, shape (n, 3, 6)
    elevation: Array  # sea surface above still water below the boom tip [m], shape (n,)
    heading: float = 0.0  # of the vessel from world x [rad]

    @classmethod
    def still(cls, ticks: range, tick_period: float) -> VesselMotions:
        """Return the motion of a vessel that does not move, at `ticks` of a `tick_period` [s]."""
        count = len(ticks)
        return cls(np.asarray(ticks, dtype=float) * tick_period, np.zeros((count, 3, 6)), np.zeros(count))


def lever_arm_matrix(arm: Array) -> Array:
    """Return T, shape (3, 6): the displacement of a point at `arm` [m] is T q, q the six motions.

    x: surge + z pitch - y yaw; y: sway + x yaw - z roll; z: heave - x pitch + y roll.
    """
    x, y, z = arm
    cross = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    return np.hstack((np.eye(3), cross))


def point_motions(motions: VesselMotions, lever: Array, mean_height: float, own: Array | None = None) -> Array:
    """Return position, velocity and acceleration of a point in frame world at n ticks, shape (n, 3, 3).

    The frame's origin is below the mean point, and travels with the mean position of the vessel: forward speed is not
    in it.

    Parameters
    ----------
    motions : of the vessel's reference point
    lever : `lever_arm_matrix` of the point, shape (3, 6), or that of each tick, shape (n, 3, 6)
    mean_height : mean z of the point [m]
    own : what the point moves by itself, vessel axes: position from the mean point, velocity, acceleration, shape
        (n, 3, 3); None: it does not
    """
    points: Array = motions.six @ lever.swapaxes(-1, -2)
    if own is not None:
        points += own
    if motions.heading:
        cosine, sine = np.cos(motions.heading), np.sin(motions.heading)
        x, y = points[:, :, 0].copy(), points[:, :, 1].copy()
        points[:, :, 0], points[:, :, 1] = cosine * x - sine * y, sine * x + cosine * y
    points[:, 0, 2] += mean_height
    return points
