"""The laws of a design, by the name of the parameter `law`."""

from __future__ import annotations

from typing import Protocol

from winch_controller_node.design import ControllerDesign
from winch_controller_node.laws.constrained import ConstrainedLaw
from winch_controller_node.laws.feedback import LawCommand, StateFeedback
from winch_controller_node.laws.feedforward import SpeedFeedforward
from winch_controller_node.laws.governor import CommandGovernor, WinchLimits, winch_limits
from winch_controller_node.laws.loop_state import LoopState
from winch_controller_node.linear_model import Array


class Law(Protocol):
    """What all laws have in common."""

    gain: Array

    def command(self, state: LoopState) -> LawCommand:
        """Return the command at `state`."""
        ...

    def reset(self) -> None:
        """Begin anew."""
        ...


def limits_of(design: ControllerDesign) -> WinchLimits:
    """Return the limits in force under a design."""
    return winch_limits(design.parameters.winch, design.parameters.limits, design.cable.static_tension)


def make_governor(design: ControllerDesign) -> CommandGovernor:
    """Return the governor of a design."""
    return CommandGovernor(design.model, design.parameters.winch, limits_of(design))


def make_law(design: ControllerDesign) -> Law:
    """Return the law that the design's parameters name; for `off` the LQG law, which is never asked.

    Raises DesignError where the winch cannot be driven by that law.
    """
    parameters = design.parameters
    if parameters.law == "mpc":
        return ConstrainedLaw(design.model, design.gain, parameters.winch, limits_of(design), parameters.mpc)
    if parameters.law == "feedforward":
        return SpeedFeedforward(design.model, parameters.winch, parameters.feedforward)
    return StateFeedback(design.regulator_gain if parameters.law == "lqr" else design.gain)
