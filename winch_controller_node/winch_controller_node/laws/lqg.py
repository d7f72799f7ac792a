"""Law lqg: feedback of all states, those of the sea included, estimated by the Kalman filter (thesis 6.3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from heave_node.parameters import parameter

from winch_controller_node.laws.law import LawCommand, LawDesign
from winch_controller_node.laws.parts.late_drum import LateDrum
from winch_controller_node.laws.parts.loop_state import LoopState
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.laws.state_feedback import StateFeedback


@dataclass(frozen=True)
class LqgParameters:
    """Feedback of all states."""

    unit_share: float = parameter(
        0.2,
        unit="",
        minimum=0.001,
        maximum=100.0,
        description="Fraction of the winch's speed limit available to the feedback of the unit's own error.",
    )


class FullStateFeedback(StateFeedback):
    """Feedback of all states with the gain of the `design`; `parameters` bound what the unit's error may ask for.

    What a drum is asked for that the sea outruns, see `late_drum`.
    """

    name: ClassVar[str] = "lqg"
    summary: ClassVar[str] = "feedback of all states"
    parameters_type: ClassVar[type | None] = LqgParameters

    def __init__(self, design: LawDesign, parameters: LqgParameters) -> None:
        largest_share = parameters.unit_share * design.limits.speed
        super().__init__(design, design.gain, largest_share)
        self._payout = design.model.state("payout")
        self._late_drum: LateDrum | None = None
        if design.winch.law == "speed_servo":  # a first-order winch has no acceleration to be limited
            self._late_drum = LateDrum(
                design.model, design.winch, design.limits, gain=self.gain, largest_share=largest_share
            )

    def take_limits(self, limits: WinchLimits) -> None:
        """Count with other limits of the winch from now on."""
        if self._late_drum is not None:
            self._late_drum.take_limits(limits)

    def command(self, state: LoopState) -> LawCommand:
        """Return the command at `state`."""
        if self._late_drum is None:
            return super().command(state)
        x = state.x.copy()
        x[self._payout] -= self._late_drum.forgiven(x)
        return LawCommand(self._feed_back(x) + self._late_drum.turn_early(state.x))
