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
