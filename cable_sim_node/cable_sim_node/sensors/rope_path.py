"""Friction of the sheaves between drum and boom tip, where the load cell reads.

A rope that runs over a sheave towards the drum is pulled with T e^f there, and with T e^-f where it runs out, T the
tension on the cable's side (Euler and Eytelwein: f = mu theta). Between the two it sticks: the drum then stretches or
relieves what gives between drum and boom tip, of stiffness k, until the rope slides (a Jenkin element). So the reading
has a loop over payout, of height 2 T sinh f and with flanks of slope k, and does not chatter; with the drum at rest it
does not follow a tension at the boom tip that stays within e^f of it.
"""

from __future__ import annotations

import math

from cable_sim_node.parameters import RopePathParameters
from cable_sim_node.physics.rope_friction import jenkin_force


class RopePath:
    """The rope's way from the drum to the boom tip.

    Parameters
    ----------
    parameters : friction and stiffness
    tension : at the boom tip where the rope comes to rest at the start, with payout 0 [N]

    Attributes
    ----------
    drum_tension : of the rope on the drum's side of the sheaves [N]
    """

    def __init__(self, parameters: RopePathParameters, tension: float) -> None:
        self._ratio = math.exp(parameters.friction)
        self._stiffness = parameters.stiffness
        self._payout = 0.0
        self.drum_tension = tension

    def advance(self, tension: float, payout: float) -> None:
        """Go on to a `tension` at the boom tip [N], never negative, and a `payout` of the drum [m]."""
        sticking = self.drum_tension - self._stiffness * (payout - self._payout)
        self.drum_tension = jenkin_force(sticking, tension / self._ratio, tension * self._ratio)
        self._payout = payout
