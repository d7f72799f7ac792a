"""The top tension without the waves' quicker part: a first-order low-pass of the load cell."""

from __future__ import annotations

import math

FILTER_SHARE = 0.25
"""Time constant of the low-pass over that of the tension loop."""


class TensionFilter:
    """Low-pass of the load cell.

    Parameters
    ----------
    loop_time_constant : of the tension loop that it serves [s]
    tick_period : [s]

    Attributes
    ----------
    value : filtered tension [N]; NaN before the first reading
    """

    def __init__(self, loop_time_constant: float, *, tick_period: float) -> None:
        self._weight = tick_period / (FILTER_SHARE * loop_time_constant + tick_period)
        self.value = math.nan

    def add(self, tension: float) -> None:
        """Take in one reading of the `tension` [N]."""
        if not math.isfinite(self.value):
            self.value = tension
        self.value += self._weight * (tension - self.value)
