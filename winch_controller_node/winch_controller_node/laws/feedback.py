"""State feedback u = -G x: LQR on unit, winch and delay (thesis 6.2.4, 6.2.5), and full LQG (thesis 6.3)."""

from __future__ import annotations

from dataclasses import dataclass

from winch_controller_node.laws.loop_state import LoopState
from winch_controller_node.linear_model import Array


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
    """u = -gain x. The clipped command is what the estimator is told, see `governor`.

    Parameters
    ----------
    gain : shape (n,)
    """

    def __init__(self, gain: Array) -> None:
        self.gain = gain

    def command(self, state: LoopState) -> LawCommand:
        """Return the command at `state`."""
        return LawCommand(-float(self.gain @ state.x))

    def reset(self) -> None:
        """Nothing is remembered."""
