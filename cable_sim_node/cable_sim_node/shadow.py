"""Payout of the shadow plant, whose winch does not compensate."""

from __future__ import annotations

import math

FOLLOWING_TIME = 1.0
"""Time constant with which the payout follows the programme, critically damped [s]."""


class ShadowPayout:
    """Payout that follows a programme smoothly, or stays where it is.

    Parameters
    ----------
    tick_period : [s]

    Attributes
    ----------
    payout, rate : [m], [m/s]
    """

    def __init__(self, *, tick_period: float) -> None:
        self.payout = 0.0
        self.rate = 0.0
        self._tick_period = tick_period

    def advance(self, programme: float | None) -> None:
        """Advance by a tick towards `programme` [m]; None or NaN holds the last one."""
        if programme is None or not math.isfinite(programme):
            programme = self.payout + self.rate * FOLLOWING_TIME  # ends the motion as a critically damped system does
        decay = math.exp(-self._tick_period / FOLLOWING_TIME)
        gap = self.payout - programme
        slope = self.rate + gap / FOLLOWING_TIME
        self.payout = programme + (gap + slope * self._tick_period) * decay
        self.rate = (self.rate - slope * self._tick_period / FOLLOWING_TIME) * decay
