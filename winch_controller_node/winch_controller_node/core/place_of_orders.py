"""The place that belongs to a commanded speed: what a drive with a position loop of its own is to follow.

p' = v + (u - p)/LEAK: the integral of the speed v that is sent, from where the drum u is when its brake opens. A drum
that follows p through a lag T moves as one that follows v through the same lag. The leak takes out what adds up where a
drive goes by v alone, with another gain; p never leads the drum by more than REACH.
"""

from __future__ import annotations

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
        self._dt = tick_period
        self._place: float | None = None

    def at_end(self, rate: float, payout: float, *, is_braked: bool) -> float:
        """Return the payout at which the drum is to be at the end of the tick [m].

        Parameters
        ----------
        rate : that is sent for the tick [m/s]
        payout : of the drum at its start [m]
        is_braked : the brake is ordered: the drum stays where it is
        """
        if is_braked or self._place is None:
            self._place = payout
        if is_braked:
            return payout
        self._place += self._dt * (rate + (payout - self._place) / LEAK)
        self._place = min(max(self._place, payout - REACH), payout + REACH)
        return self._place
