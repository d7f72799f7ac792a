"""What a law is given each tick: the compensation problem as the laws see it.

Compensation of the share `authority` of the sea, about a mean payout that may move, is the plain problem in shifted
states: unit heave minus (1 - authority) times the uncompensated heave, boom tip and waves times authority, payout
minus the mean payout. The plant is linear in all of them, so that one law serves every authority, and authority may
move at any time without a step in the command.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from heave_node.interface.preview import HeavePreview
from heave_node.numerics.arrays import Array


class Reference(NamedTuple):
    """Motion of the mean payout that compensation is superposed on, at the moment the next command takes effect."""

    payout: float = 0.0  # of the winch as it follows the mean payout [m]
    rate: float = 0.0  # of the winch as it follows the mean payout [m/s]
    command: float = 0.0  # share of the rate command that belongs to it [m/s]


class LoopState(NamedTuple):
    """State of the loop at a tick."""

    x: Array  # state of the compensation problem, names of the design's model, shape (n,)
    reference: Reference  # the mean payout's motion
    static_tension: float  # tension at the top about which the model's tension counts [N]
    measured_tension: float = math.nan  # low-passed reading of the load cell [N]; NaN before the first
    # newest heave rate that the MRU read, the estimated one where it measures none, times the authority [m/s]
    mru_rate: float = 0.0
    preview: HeavePreview | None = None  # boom-tip heave ahead, times the authority; None: there is none
    bounds_tension: bool = True  # the highest tension is one that compensation can keep in this sea
