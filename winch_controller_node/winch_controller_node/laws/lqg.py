"""Law lqg: feedback of all states, those of the sea included, estimated by the Kalman filter (thesis 6.3).

A linear law does not know the limits of the winch. Where the sea comes near to them, the drum would be late, be sent
after the boom tip with all of the winch's speed, not be able to stop where it should, and soon move against the boom
tip: the unit would swing more than without compensation. Nor does a bounded share of the command bring a unit to rest
that something has set swinging by metres. There the law with the limits as constraints takes over, until all is well
away from them again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from heave_node.numerics.arrays import Array
from heave_node.parameters import parameter

from winch_controller_node.laws.law import LawCommand, LawDesign
from winch_controller_node.laws.mpc import ConstrainedLaw, MpcParameters
from winch_controller_node.laws.parts.loop_state import LoopState
from winch_controller_node.laws.parts.near_limits import NearLimits
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

    Near the limits of the winch the commands are those of law mpc, with its default parameters.
    """

    name: ClassVar[str] = "lqg"
    summary: ClassVar[str] = "feedback of all states; near the limits as mpc"
    parameters_type: ClassVar[type | None] = LqgParameters
    gain_names: ClassVar[tuple[str, ...]] = ConstrainedLaw.gain_names

    def __init__(self, design: LawDesign, parameters: LqgParameters) -> None:
        super().__init__(design, design.gain, parameters.unit_share * design.limits.speed)
        self._limits: NearLimits | None = None
        self.keeps_limits = design.winch.law == "speed_servo"  # a first-order winch has no acceleration to be limited
        if self.keeps_limits:
            self._limits = NearLimits(design.model, design.limits)
            self._constrained = ConstrainedLaw(design, _near_limits(design))

    @classmethod
    def own_gains(cls, design: LawDesign, parameters: LqgParameters) -> dict[str, Array]:
        """Return those of the law near the limits of the winch of a `design`, whatever the `parameters`."""
        del parameters
        return ConstrainedLaw.own_gains(design, _near_limits(design)) if design.winch.law == "speed_servo" else {}

    def take_limits(self, limits: WinchLimits) -> None:
        """Count with other limits of the winch from now on."""
        if self._limits is not None:
            self._limits.take_limits(limits)
            self._constrained.take_limits(limits)

    def reset(self) -> None:
        """Start again."""
        if self._limits is not None:
            self._limits.reset()
            self._constrained.reset()

    def command(self, state: LoopState) -> LawCommand:
        """Return the command at `state`."""
        unit_use = abs(self.unit_share(state)) / self.largest_share
        if self._limits is not None and self._limits.are_near(state.x, unit_use):
            return self._constrained.command(state)
        return super().command(state)


def _near_limits(design: LawDesign) -> MpcParameters:
    """Return the parameters of the law near the limits."""
    return MpcParameters(horizon=MpcParameters.horizon + design.winch.command_delay)
