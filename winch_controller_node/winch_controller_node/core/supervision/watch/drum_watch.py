"""Reflexes about the drum: is it off what the last second foresaw, and does its encoder go as the winch was ordered."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from heave_core.watch import Drum, DrumOrders, run_of

from winch_controller_node.beliefs.drum import drum_of
from winch_controller_node.parameters.model import WinchModelParameters

CHECKED_TIME = 1.0
"""The drum is compared with its prediction over this time [s]."""

ORDERED_TIME = 0.8
"""Orders and encoder are compared over this time [s]."""

CONSTANTS = {
    "least_seen": 0.8,
    "least_motion": 0.004,
    "settled": 5.0,
}
"""Constants of the drum's watch: meanings and units are in the core's table, DRUM_WATCH_DESIGN."""

LONGEST = 12.0
"""Time for which orders and readings are kept [s]."""


def watched(drum: Drum, largest: float, position_gain: float, tick_period: float) -> dict[str, Any]:
    """Return the values of the core's DrumWatchDesign.

    Parameters
    ----------
    drum : nominal
    largest : most by which the assumed delay may be longer [s]
    position_gain : of the drive's position loop [1/s]; 0: none
    tick_period : [s]
    """
    ahead = math.ceil((drum.delay + largest) / tick_period) + 3
    return {
        "kept": round(LONGEST / tick_period) + ahead,
        "ahead": ahead,
        "checked": 2 * round(CHECKED_TIME / tick_period),
        "ordered": round(ORDERED_TIME / tick_period),
        **CONSTANTS,
        "run": run_of(position_gain, tick_period)[0],
        "assumed": drum,
        "nominal": drum,
    }


class DrumWatch:
    """Keeps orders and encoder readings of the last seconds; they are compared in C++ (`heave_core`, drum_watch.cpp).

    Parameters
    ----------
    winch : nominal
    largest : most by which the assumed delay may be longer [s]
    tick_period : [s]
    orders : of the core; None: its own
    """

    def __init__(
        self,
        winch: WinchModelParameters,
        largest: float,
        tick_period: float,
        orders: DrumOrders | None = None,
    ) -> None:
        self._nominal = winch
        values = watched(drum_of(winch), largest, winch.position_gain, tick_period)
        self._core = DrumOrders(values) if orders is None else orders
        self.restart = self._core.restart
        self.reset()

    def take(self, assumed: Mapping[str, float]) -> None:
        """Go by the `assumed` winch from now on, by quantity."""
        self._core.design["assumed"] = drum_of(self._nominal, assumed)

    def reset(self, payout: float = 0.0) -> None:
        """Restart with the drum at rest at `payout` [m]."""
        self._core.reset(payout)

    def add(
        self,
        payout: float,
        rate: float,
        encoder: float | None,
        *,
        tension: float = math.nan,
        is_limited: bool = False,
    ) -> None:
        """Take a tick in.

        Parameters
        ----------
        payout, rate : set-points [m], [m/s]
        encoder : at its end [m]; None: no reading
        tension : at its end [N]; NaN: unknown
        is_limited : the winch says that a limit acted in it
        """
        self._core.add(payout, rate, tension, math.nan if encoder is None else encoder, is_limited)
