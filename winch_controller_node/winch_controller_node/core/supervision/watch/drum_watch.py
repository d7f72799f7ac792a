"""Reflexes about the drum: is it off what the last second foresaw, and does its encoder go as the winch was ordered."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

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

STRAIGHT = 0.15
"""Orders and encoder are compared where no more is left of the readings than this share: a weak drum lags behind."""

REVERSED, NOT_REVERSED = -0.2, 0.5
"""Ratio of encoder to orders below which the encoder is reversed, and above which it is no more."""

SUDDEN, NOT_SUDDEN = (0.6, 1.6), (0.75, 1.3)
"""Ratio of encoder to orders outside which its scale has changed suddenly, and within which it has not."""

TRUE = 0.1
"""Largest error of that ratio of an encoder that reads what was ordered: a weaker or slower winch is further off."""


class Ordered(NamedTuple):
    """What the encoder reads of what the winch was ordered."""

    share: float  # times as much [-]
    left: float  # standard deviation of the rest over that of the readings [-]
    payout: float  # where the drum should be by now, did it start where it was read [m]
    is_limited: bool = False  # the winch says that it has been at a limit meanwhile

    def is_reversed(self, *, was: bool) -> bool:
        """Return whether the encoder is reversed, and if it `was` so, still is."""
        return self.share < NOT_REVERSED if was else self.share < REVERSED and self.left < STRAIGHT

    def is_sudden(self, *, was: bool) -> bool:
        """Tell whether the encoder reads far less or more, no limit having acted, and if it `was` so, still does."""
        least, most = NOT_SUDDEN if was else SUDDEN
        return not least < self.share < most and (was or (self.left < STRAIGHT and not self.is_limited))

    @property
    def is_right_way(self) -> bool:
        """Tell whether the encoder goes the way that was ordered."""
        return self.share > NOT_REVERSED and self.left < STRAIGHT

    @property
    def is_true(self) -> bool:
        """Tell whether the encoder reads what was ordered."""
        return abs(self.share - 1.0) < TRUE and self.left < STRAIGHT


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
        self.restart, self.error = self._core.restart, self._core.error
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

    def does_as_nominal(self, scale: float) -> bool:
        """Tell whether the encoder, whose assumed `scale` is left out, reads what a nominal winch was ordered."""
        found = self.ordered(of_nominal=True)
        return found is not None and found._replace(share=found.share * scale).is_true

    def ordered(self, *, of_nominal: bool = False) -> Ordered | None:
        """Return what the encoder reads of what the winch was ordered, with its assumed scale; None: unknown.

        `of_nominal` : the nominal winch was, not the assumed one
        """
        share, left, payout, is_limited = self._core.ordered(of_nominal=of_nominal)
        return None if math.isnan(share) else Ordered(share, left, payout, bool(is_limited))
