"""Linear state feedback with the share of the unit's own error bounded: what laws lqr and lqg have in common."""

from __future__ import annotations

from heave_node.numerics.arrays import Array

from winch_controller_node.laws.law import ControlLaw, LawCommand, LawDesign
from winch_controller_node.laws.parts.loop_state import LoopState


class StateFeedback(ControlLaw):
    """u = -gain x, with the share of the unit's own error bounded. For the estimator's input, see `governor`.

    A large error of the unit would ask a winch at its limits for a bang-bang motion that, late as it is, swings the
    unit up instead of down. Less feedback of the unit only takes damping away from a plant that is stable by itself: a
    bounded share cannot do that, whatever the error.

    Parameters
    ----------
    design : what the law is made for
    gain : shape (n,)
    largest_share : of the command that the unit's error may ask for [m/s] ([m], first-order winch); an attribute too
    """

    def __init__(self, design: LawDesign, gain: Array, largest_share: float) -> None:
        super().__init__(design, None)
        self.gain = gain
        self._unit = [design.model.state("unit_heave"), design.model.state("unit_heave_rate")]
        self.largest_share = largest_share

    def unit_share(self, state: LoopState) -> float:
        """Return what the unit's own error asks for at `state`, not bounded yet [m/s] ([m], first-order winch)."""
        return -float(self.gain[self._unit] @ state.x[self._unit])

    def command(self, state: LoopState) -> LawCommand:
        """Return the command at `state`."""
        whole, share = -float(self.gain @ state.x), self.unit_share(state)
        bounded = min(max(share, -self.largest_share), self.largest_share)
        return LawCommand(whole - share + bounded)
