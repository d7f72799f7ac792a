"""The place that belongs to a commanded speed: what a drive with a position loop is to follow, see act.cpp."""

from __future__ import annotations

from heave_core.law import Place

LEAK = 60.0
"""Time constant with which the place is drawn to the drum [s]: far slower than the waves."""
REACH = 2.0
"""Furthest that the place leads the drum [m]: one second at the largest speed of a winch."""


class PlaceOfOrders:
    """Integrates what is sent.

    Parameters
    ----------
    tick_period : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt, self._core = tick_period, Place(LEAK, REACH)
        self.record = self._core.record

    def at_end(self, rate: float, payout: float, *, is_braked: bool) -> float:
        """Return the payout at which the drum is to be at the end of the tick [m].

        Parameters
        ----------
        rate : that is sent for the tick [m/s]
        payout : of the drum at its start [m]
        is_braked : the brake is ordered: the drum stays where it is
        """
        return self._core.at_end(self._dt, rate, payout, is_braked=is_braked)
