"""Jumps in the readings of a depth sensor, which no unit makes."""

from __future__ import annotations

from winch_controller_node.core.estimation.mru_steps import SIGMAS

LARGEST_STEP, LARGEST_SPEED = 0.2, 4.0
"""A unit makes no step beyond the first [m], or SIGMAS of the sensor's noise, plus the second [m/s] times the time
since the last reading.
"""

LIKE_SCALE = 0.1
"""A jump of the depth by more than this share of it may be another scale, and one that makes a loop harmful."""


def largest_step(noise: float, elapsed: float) -> float:
    """Return how far two depths may be apart [m] with an `elapsed` time between them [s] and `noise` of 1 sigma [m]."""
    return max(LARGEST_STEP, SIGMAS * noise) + LARGEST_SPEED * elapsed


class DepthJumps:
    """Takes jumps off the readings of a depth sensor that no unit can have made.

    A sensor that jumps back, as after a spike, is again where it was at first.

    Attributes
    ----------
    offset : sum of the jumps found so far [m]; a reading less the offset is the depth
    jump : the last one [m]
    is_like_scale : as large as that of a sensor that gets another scale or sign
    is_unproved : the last reading goes on from such a jump
    """

    def __init__(self) -> None:
        self.offset = self.jump = 0.0
        self.is_like_scale = self.is_unproved = False
        self._has_jumped = False
        self._last: tuple[float, float] | None = None

    def take_off(self, time: float, depth: float, noise: float = 0.0) -> float | None:
        """Return the depth without jumps [m], or None where it has just jumped.

        Parameters
        ----------
        time, depth : of the reading [s], [m]
        noise : standard deviation of the sensor's, as far as it is known [m]
        """
        last_time, last = (time, depth) if self._last is None else self._last
        allowed = largest_step(noise, time - last_time)
        for offset in (self.offset, 0.0):
            if abs(depth - offset - last) <= allowed:
                self.is_unproved = self._has_jumped and self.is_like_scale and offset != 0.0
                self._has_jumped, self.offset = False, offset
                self._last = (time, depth - offset)
                return depth - offset
        self.jump = depth - self.offset - last
        self.is_like_scale = abs(self.jump) > LIKE_SCALE * abs(last)
        self._has_jumped, self.is_unproved = True, False
        self.offset = depth - last
        self._last = (time, last)
        return None
