"""The laws of a design, by the name of the parameter `law`."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from heave_node.arrays import Array
from heave_node.linear_model import LinearModel

from winch_controller_node.design.design import ControllerDesign, is_sensor_state, regulator_gain
from winch_controller_node.laws.constrained import ConstrainedLaw
from winch_controller_node.laws.effort import Effort, feedback_effort
from winch_controller_node.laws.feedback import LawCommand, StateFeedback
from winch_controller_node.laws.feedforward import OutletHold, SpeedFeedforward
from winch_controller_node.laws.governor import CommandGovernor, WinchLimits, winch_limits
from winch_controller_node.laws.loop_state import LoopState
from winch_controller_node.model.lqr import lqr_gain, output_cost
from winch_controller_node.parameters.laws import MpcParameters


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


def constrained_gain(model: LinearModel, parameters: MpcParameters) -> Array:
    """Return the LQR gain of the constrained law, shape (n,).

    It can be sharper than that of a law whose command is clipped: the limits are in the plan.
    """
    sizes = {
        "unit_heave": parameters.unit_heave,
        "payout": parameters.payout,
        "payout_acceleration": parameters.payout_acceleration,
    }
    moved = [name for name in model.state_names if not is_sensor_state(name)]
    plant = model.select_states(moved)
    gain = np.zeros(model.order)
    gain[[model.state(name) for name in moved]] = lqr_gain(plant, output_cost(plant, sizes, parameters.command))[0]
    return gain


def make_law(design: ControllerDesign) -> Law:
    """Return the law that the design's parameters name; for `off` the LQG law, which is never asked.

    Raises DesignError where the winch cannot be driven by that law.
    """
    parameters = design.parameters
    if parameters.law == "mpc":
        gain = constrained_gain(design.model, parameters.mpc)
        return ConstrainedLaw(design.model, gain, parameters.winch, limits_of(design), parameters.mpc)
    if parameters.law == "feedforward":
        return SpeedFeedforward(design.model, parameters.winch, parameters.feedforward)
    unit = [design.model.state("unit_heave"), design.model.state("unit_heave_rate")]
    if parameters.law == "lqr":
        # all that it does comes from the unit's error
        return StateFeedback(regulator_gain(parameters, design.model), unit, limits_of(design).speed)
    return StateFeedback(design.gain, unit, parameters.limits.unit_share * limits_of(design).speed)


def effort_of(design: ControllerDesign, law: Law) -> Effort:
    """Return what the design's law asks of the winch; those that know the boom tip ask for its motion."""
    is_regulator = design.parameters.law == "lqr" and design.parameters.winch.law == "speed_servo"
    return feedback_effort(design, law.gain) if is_regulator else Effort()


def make_open_loop(design: ControllerDesign, *, settles: bool = False) -> OutletHold | None:
    """Return the law by which compensation is faded out: slow enough to bear delays that nobody believes in.

    With `settles` it damps the unit as well. None for a first-order winch, which has no rate to command.
    """
    winch = design.parameters.winch
    inertia = design.cable.a if settles else 0.0
    return None if winch.law == "first_order" else OutletHold(design.model, winch, inertia)
