"""Law lqr: the regulator of unit, winch and delayed commands alone (thesis 6.2.4, 6.2.5). It knows of no sea."""

from __future__ import annotations

from typing import ClassVar

from heave_node.numerics.arrays import Array

from winch_controller_node.laws.core_law import StateFeedback
from winch_controller_node.laws.law import LawDesign
from winch_controller_node.laws.parts.effort import feedback_effort
from winch_controller_node.model.regulator import unit_regulator_gain


class UnitRegulator(StateFeedback):
    """Feedback of the unit's motion. All that it does comes from the unit's error, which may ask for the full speed.

    It is made for a `design`, and has no `parameters`.
    """

    name: ClassVar[str] = "lqr"
    summary: ClassVar[str] = "feedback of the unit alone"
    gain_names: ClassVar[tuple[str, ...]] = ("unit",)

    def __init__(self, design: LawDesign, parameters: None) -> None:
        gains = design.own_gains or self.own_gains(design, parameters)
        super().__init__(design, gains["unit"], 1.0)
        if design.winch.law == "speed_servo":
            self.effort = feedback_effort(design.model, self.gain)

    @classmethod
    def own_gains(cls, design: LawDesign, parameters: None) -> dict[str, Array]:
        """Return the gain of the regulator for a `design`; it has no `parameters`."""
        del parameters
        return {"unit": unit_regulator_gain(design.weights, design.model)}
