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
    """Motion of the mean payout that compensation is superposed on, at the moment the next command takes effect.

    Attributes
    ----------
    payout, rate : of the winch as it follows the mean payout [m], [m/s]
    command : share of the rate command that belongs to it [m/s]
    """

    payout: float = 0.0
    rate: float = 0.0
    command: float = 0.0


class LoopState(NamedTuple):
    """State of the loop at a tick.

    Attributes
    ----------
    x : state of the compensation problem, names of the design's model, shape (n,)
    reference : the mean payout's motion
    static_tension : tension at the top about which the model's tension counts [N]
    measured_tension : low-passed reading of the load cell [N]; NaN before the first
    mru_rate : newest heave rate that the MRU read, the estimated one where it measures none, times the authority [m/s]
    preview : boom-tip heave ahead, times the authority; None: there is none
    bounds_tension : the highest tension is one that compensation can keep in this sea
    """

    x: Array
    reference: Reference
    static_tension: float
    measured_tension: float = math.nan
    mru_rate: float = 0.0
    preview: HeavePreview | None = None
    bounds_tension: bool = True
