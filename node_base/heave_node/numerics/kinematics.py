"""Motion of a point, as plain data between components."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from heave_node.numerics.arrays import Array


def _zeros() -> Array:
    return np.zeros(3)


@dataclass
class PointMotion:
    """Position, velocity and acceleration of one point at one time, in frame `world` (z up, origin at still water).

    Attributes
    ----------
    time : simulated time [s]
    position, velocity, acceleration : shape (3,) [m], [m/s], [m/s^2]
    """

    time: float = 0.0
    position: Array = field(default_factory=_zeros)
    velocity: Array = field(default_factory=_zeros)
    acceleration: Array = field(default_factory=_zeros)


def euler_part(part: str, x: Array, y: Array, z: Array, w: Array) -> Array:
    """Return `part`, roll, pitch or yaw [rad] (about x, y, z, in the order z-y-x), of the quaternions x, y, z, w."""
    if part == "roll":
        return np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    if part == "pitch":
        return np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    return np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
