"""Linear state feedback with the share of the unit's own error bounded: what laws lqr and lqg have in common."""

from __future__ import annotations

from heave_core.law import put
from heave_core.law_table import LawKind
from heave_node.numerics.arrays import Array

from winch_controller_node.laws.core_law import CoreLaw
from winch_controller_node.laws.law import LawDesign


class StateFeedback(CoreLaw):
    """u = -gain x, with the share of the unit's own error bounded. For the estimator's input, see `governor`.

    A large error of the unit would ask a winch at its limits for a bang-bang motion that, late as it is, swings the
    unit up instead of down. Less feedback of the unit only takes damping away from a plant that is stable by itself: a
    bounded share cannot do that, whatever the error.

    Parameters
    ----------
    design : what the law is made for
    gain : shape (n,)
    unit_share : share of the largest speed that the unit's error may ask for
    """

    def __init__(self, design: LawDesign, gain: Array, unit_share: float) -> None:
        super().__init__(design, LawKind.FEEDBACK_LAW, gain=gain, unit_share=unit_share)
        self.gain = gain

    @property
    def largest_share(self) -> float:
        """Largest share of the command that the unit's error may ask for [m/s] ([m], first-order winch)."""
        return float(self.core.law["unit_share"][0] * self.winch.record["speed"][0])

    def stay_linear(self) -> None:
        """Leave out what takes over near the limits of the winch."""
        put(self.core.law, {"plans": 0})
