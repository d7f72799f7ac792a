"""Motion of a point, as plain data between components."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel


def _zeros() -> Array:
    return np.zeros(3)


@dataclass
class PointMotion:
    """Position, velocity and acceleration of one point at one time, in frame `world` (z up, origin at still water)."""

    time: float = 0.0  # simulated time [s]
    position: Array = field(default_factory=_zeros)  # shape (3,) [m]
    velocity: Array = field(default_factory=_zeros)  # shape (3,) [m/s]
    acceleration: Array = field(default_factory=_zeros)  # shape (3,) [m/s^2]


def euler_part(part: str, x: Array, y: Array, z: Array, w: Array) -> Array:
    """Return `part`, roll, pitch or yaw [rad] (about x, y, z, in the order z-y-x), of the quaternions x, y, z, w."""
    if part == "roll":
        return np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    if part == "pitch":
        return np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    return np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def turned(vector: Sequence[Array], x: Array, y: Array, z: Array, w: Array) -> tuple[Array, Array, Array]:
    """Return a `vector` in the frame that the quaternions x, y, z, w turn it into.

    v + 2 q x (q x v + w v), q = x, y, z. Each component, and each of x, y, z, w, has one shape; their squares sum to 1.
    """
    a, b, c = vector
    inner = (y * c - z * b + w * a, z * a - x * c + w * b, x * b - y * a + w * c)
    return (
        a + 2.0 * (y * inner[2] - z * inner[1]),
        b + 2.0 * (z * inner[0] - x * inner[2]),
        c + 2.0 * (x * inner[1] - y * inner[0]),
    )


def height_of(arm: Sequence[float], roll: float, pitch: float) -> float:
    """Return how high the end of an arm is above its start: the third component of R_y(pitch) R_x(roll) arm [m].

    -x sin(pitch) + (y sin(roll) + z cos(roll)) cos(pitch); a velocity in the ship's frame in the place of the arm gives
    its vertical component.

    Parameters
    ----------
    arm : x forward, y to port, z up, in the ship's frame (REP-103) [m]
    roll, pitch : about x, starboard down positive, then about y, bow down positive [rad]
    """
    x, y, z = arm
    return -x * math.sin(pitch) + (y * math.sin(roll) + z * math.cos(roll)) * math.cos(pitch)


def height_rate_of(arm: Sequence[float], roll: float, pitch: float, turning: Sequence[float]) -> float:
    """Return the rate of `height_of` of an arm that is fixed to the ship, by the chain rule [m/s].

    Parameters
    ----------
    arm : x forward, y to port, z up, in the ship's frame [m]
    roll, pitch : as in `height_of` [rad]
    turning : their rates [rad/s]
    """
    x, y, z = arm
    raised = y * math.sin(roll) + z * math.cos(roll)
    by_roll = (y * math.cos(roll) - z * math.sin(roll)) * math.cos(pitch)
    by_pitch = -x * math.cos(pitch) - raised * math.sin(pitch)
    return by_roll * turning[0] + by_pitch * turning[1]


PEAK_OF_RAMP = 1.875
"""Largest rate of the ramp over its mean rate."""


def smooth_ramp(time: float, duration: float) -> tuple[float, float, float]:
    """Return the quintic ramp r(time / duration) from 0 to 1 and its first two time derivatives.

    Parameters
    ----------
    time : since the start of the ramp [s]
    duration : of the ramp [s]; 0 gives r = 1
    """
    if time >= duration:
        return 1.0, 0.0, 0.0
    if time <= 0.0:
        return 0.0, 0.0, 0.0
    x = time / duration
    value = x**3 * (10.0 + x * (6.0 * x - 15.0))
    rate = 30.0 * x**2 * (1.0 - x) ** 2 / duration
    acceleration = 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / duration**2
    return value, rate, acceleration


smooth_ramp_kernel = inner_kernel(smooth_ramp)
"""The same for kernels."""
