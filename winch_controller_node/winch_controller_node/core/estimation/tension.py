"""The top tension: low-passed, and its mean over waves, which is what stays of it under a brake.

Over waves the mean is the weight that the cable carries, for the mean acceleration of a unit that goes nowhere is 0:
it distinguishes one that stands from one that hangs, where a reading, or a low-pass of a second, shows the wave. Both
are made in C++ (`heave_core`, watches.cpp).
"""

from __future__ import annotations

import math
from typing import NamedTuple

MEMORY = 30.0
"""Time constant of the mean [s]: of a wave it leaves 1/(w T), as much as a plain mean over twice the time may. It holds
a wave and a half of the longest swell, of 20 s; the motion of the boom tip is averaged over it as well."""

FILTER_SHARE = 0.25
"""Time constant of the low-pass over that of the tension loop."""

MOVED = 0.01
"""Way of the mean payout from which on the tension is that of another place [m]."""


class TensionMean(NamedTuple):
    """A mean tension.

    Attributes
    ----------
    value : [N]; NaN where there is none
    sigma : standard deviation of the tension about it [N]
    time : for which the situation has been the same [s]
    """

    value: float = math.nan
    sigma: float = 0.0
    time: float = 0.0
