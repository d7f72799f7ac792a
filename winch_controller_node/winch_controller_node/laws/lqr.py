"""Law lqr: the regulator of unit, winch and delayed commands alone (thesis 6.2.4, 6.2.5). It knows of no sea."""

from __future__ import annotations

from typing import ClassVar

from winch_controller_node.laws.law import LawDesign
from winch_controller_node.laws.parts.effort import feedback_effort
from winch_controller_node.laws.state_feedback import StateFeedback
from winch_controller_node.model.regulator import unit_regulator_gain


class UnitRegulator(StateFeedback):
    """Feedback of the unit's motion. All that it does comes from the unit's error, which may ask for the full speed.

    It is made for a `design`, and has no `parameters`.
    """

    name: ClassVar[str] = "lqr"
    summary: ClassVar[str] = "feedback of the unit alone"

    def __init__(self, design: LawDesign, parameters: None) -> None:
        del parameters
        super().__init__(design, unit_regulator_gain(design.weights, design.model), design.limits.speed)
        if design.winch.law == "speed_servo":
            self.effort = feedback_effort(design.model, self.gain)
