"""Motion of a point, as plain data between components."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


def _zeros() -> NDArray[np.float64]:
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
    position: NDArray[np.float64] = field(default_factory=_zeros)
    velocity: NDArray[np.float64] = field(default_factory=_zeros)
    acceleration: NDArray[np.float64] = field(default_factory=_zeros)
