"""The motion of a simulated ship from the readings of a sensor: a step in them is none of the ship.

A spike, a sensor that froze and goes on, or a new zero would throw the simulated load by metres. What a step adds is
taken off at once, and given back in GLIDE by half a cosine.
"""

from __future__ import annotations

import math

STEP = 0.2
"""A reading further from where the last ones lead is a step: a ship's acceleration adds less, and so does noise [m]."""
ACCELERATION = 10.0
"""Acceleration that no ship exceeds, which counts where readings are far apart [m/s^2]."""
RATE_TIME = 0.2
"""Time over which the rate is taken that leads from one reading to the next [s]."""
GLIDE = 5.0
"""Time in which a step is given back [s]."""


class WithoutSteps:
    """Takes steps out of readings of one quantity."""

    def __init__(self) -> None:
        self._last: tuple[float, float] | None = None
        self._rate = 0.0
        self._since, self._size = -math.inf, 0.0

    def at(self, time: float, value: float) -> float:
        """Return a `value` of a `time` [s] without the steps so far [m]."""
        before = self._last or (time, value)
        elapsed, change = time - before[0], value - before[1]
        step = change - self._rate * elapsed
        if abs(step) > STEP + 0.5 * ACCELERATION * elapsed**2:
            self._size, self._since = self._left(time) + step, time
        elif elapsed > 0.0:
            self._rate += (change / elapsed - self._rate) * min(elapsed / RATE_TIME, 1.0)
        self._last = (time, value)
        return value - self._left(time)

    def _left(self, time: float) -> float:
        """Return what is left at a `time` [s] of the steps so far [m]."""
        gone = (time - self._since) / GLIDE
        return self._size * 0.5 * (1.0 + math.cos(math.pi * gone)) if gone < 1.0 else 0.0
