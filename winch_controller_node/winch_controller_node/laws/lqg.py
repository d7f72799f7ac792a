"""Law lqg: feedback of all states, those of the sea included, estimated by the Kalman filter (thesis 6.3)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from heave_node.parameters import parameter

from winch_controller_node.laws.law import LawDesign
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
    """Feedback of all states with the gain of the `design`; `parameters` bound what the unit's error may ask for."""

    name: ClassVar[str] = "lqg"
    summary: ClassVar[str] = "feedback of all states"
    parameters_type: ClassVar[type | None] = LqgParameters

    def __init__(self, design: LawDesign, parameters: LqgParameters) -> None:
        super().__init__(design, design.gain, parameters.unit_share * design.limits.speed)
