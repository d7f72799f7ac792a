"""State feedback u = -G x: LQR on unit, winch and delay (thesis 6.2.4, 6.2.5), and full LQG (thesis 6.3)."""

from __future__ import annotations

from dataclasses import dataclass

from heave_node.arrays import Array

from winch_controller_node.laws.loop_state import LoopState


@dataclass(frozen=True)
class LawCommand:
    """What a law asks for.

    Attributes
    ----------
    value : share of the command that compensates [m/s] (or [m], first-order winch)
    status : of the solver, empty for laws without one
    iterations : of the solver
    active : limits that shape the plan
    """

    value: float
    status: str = ""
    iterations: int = 0
    active: tuple[str, ...] = ()


class StateFeedback:
    """u = -gain x, with the share of the unit's own error bounded. What the estimator is told, see `governor`.

    A large error of the unit would ask a winch at its limits for a bang-bang motion that, late as it is, swings the
    unit up instead of down. Less feedback of the unit only takes damping away from a plant that is stable by itself: a
    bounded share cannot do that, whatever the error.

    Parameters
    ----------
    gain : shape (n,)
    unit : indices of the unit's heave and rate
    largest_share : of the command that the unit's error may ask for [m/s] ([m], first-order winch)
    """

    def __init__(self, gain: Array, unit: list[int], largest_share: float) -> None:
        self.gain = gain
        self._unit = unit
        self._largest_share = largest_share

    def command(self, state: LoopState) -> LawCommand:
        """Return the command at `state`."""
        whole = -float(self.gain @ state.x)
        share = -float(self.gain[self._unit] @ state.x[self._unit])
        bounded = min(max(share, -self._largest_share), self._largest_share)
        return LawCommand(whole - share + bounded)

    def reset(self) -> None:
        """Nothing is remembered."""
