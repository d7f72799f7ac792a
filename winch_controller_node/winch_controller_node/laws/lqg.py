"""Law lqg: feedback of all states, those of the sea included, estimated by the Kalman filter (thesis 6.3).

A linear law does not know the limits of the winch. Where the sea comes near to them, the drum would be late, be sent
after the boom tip with all of the winch's speed, not be able to stop where it should, and soon move against the boom
tip: the unit would swing more than without compensation. Nor does a bounded share of the command bring a unit to rest
that something has set swinging by metres. There the law with the limits as constraints takes over, until all is well
away from them again.
"""

from __future__ import annotations

from typing import ClassVar

from heave_core.law import put
from heave_node.numerics.arrays import Array

from winch_controller_node.laws.core_law import StateFeedback
from winch_controller_node.laws.law import LawDesign
from winch_controller_node.laws.mpc import ConstrainedLaw, MpcParameters, Planner, own_gains
from winch_controller_node.laws.parts.near_limits import near_limits

UNIT_SHARE = 0.2
"""Fraction of the winch's speed limit that is available to the feedback of the unit's own error [-]."""


class FullStateFeedback(StateFeedback):
    """Feedback of all states with the gain of the `design`; UNIT_SHARE bounds what the unit's error may ask for.

    Near the limits of the winch the commands are those of law mpc, with its default parameters.
    """

    name: ClassVar[str] = "lqg"
    summary: ClassVar[str] = "feedback of all states; near the limits as mpc"
    gain_names: ClassVar[tuple[str, ...]] = ConstrainedLaw.gain_names

    def __init__(self, design: LawDesign, parameters: None) -> None:
        del parameters
        super().__init__(design, design.gain, UNIT_SHARE)
        self.keeps_limits = design.winch.law == "speed_servo"  # a first-order winch has no acceleration to be limited
        if not self.keeps_limits:
            return
        self.planner = Planner(design, _near_limits(design), self.core)
        put(self.core.law, {"plans": 1, **near_limits(design.model)})

    @classmethod
    def own_gains(cls, design: LawDesign, parameters: None) -> dict[str, Array]:
        """Return those of the law near the limits of the winch of a `design`, whatever the `parameters`."""
        del parameters
        return own_gains(design.model, _near_limits(design)) if design.winch.law == "speed_servo" else {}


def _near_limits(design: LawDesign) -> MpcParameters:
    """Return the parameters of the law near the limits."""
    return MpcParameters(horizon=MpcParameters.horizon + design.winch.command_delay)
