"""Whether the unit stands: what the depth sensor alone says of its speed.

A cable is unloaded by the seabed, and by a unit that swings. The first stands still, the second falls faster than it is
lowered; this needs no model of the cable and so holds where the model is wrong, as a lost loop shows it to be.
"""

from __future__ import annotations

from collections import deque

import numpy as np

WINDOW = 1.0
"""Time over which the speed is seen [s]; readings of 2 cm at 10 Hz tell it to 2 cm/s."""

STANDING_SHARE = 0.25
"""A unit stands that falls more slowly than this share of the speed at which it is lowered..."""

STANDING_SPEED = 0.05
"""...or than this, which noise alone may show [m/s]."""


class StandingWatch:
    """Follows the depth readings of the last second."""

    def __init__(self) -> None:
        self._readings: deque[tuple[float, float]] = deque()

    def add(self, time: float, depth: float) -> None:
        """Take a good reading in: its stamp [s] and depth, positive down [m]."""
        self._readings.append((time, depth))
        while time - self._readings[0][0] > WINDOW and len(self._readings) > 2:
            self._readings.popleft()

    @property
    def fall_rate(self) -> float:
        """Speed of the unit, positive down [m/s], the slope of a straight line; 0 before there are two readings."""
        times, depths = np.array(self._readings).reshape(-1, 2).T
        if times.size < 2 or times[-1] <= times[0]:
            return 0.0
        about = times - times.mean()
        return float(about @ depths / (about @ about))

    def stands(self, lowering_rate: float) -> bool:
        """Tell whether the unit stands while it is lowered at `lowering_rate` [m/s]."""
        return self.fall_rate < max(STANDING_SHARE * lowering_rate, STANDING_SPEED)
