"""Constant tension: the winch follows the boom tip and corrects what is left of the tension's error slowly."""

from __future__ import annotations

import math

import numpy as np
from heave_node.arrays import Array
from heave_node.linear_model import LinearModel

from winch_controller_node.laws.governor import standing_command
from winch_controller_node.laws.law import LawCommand
from winch_controller_node.laws.loop_state import LoopState
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.parameters.laws import TensionLawParameters
from winch_controller_node.parameters.model import WinchModelParameters


class TensionSetPoint:
    """The tension that is held, on its way to the one asked for.

    Parameters
    ----------
    parameters : time of the ramp
    tick_period : [s]

    Attributes
    ----------
    value : tension that is held now [N]; NaN before the first
    """

    def __init__(self, parameters: TensionLawParameters, *, tick_period: float) -> None:
        self._dt = tick_period
        self._ramp_time = parameters.ramp_time
        self.value = math.nan
        self._target = math.nan
        self._slope = 0.0

    def begin(self, measured: float) -> None:
        """Start from the measured tension [N]: none was held until now."""
        self.value = self._target = measured
        self._slope = 0.0

    def hold(self, tension: float) -> None:
        """Go to a tension [N] from the one that is held."""
        self._target = tension
        self._slope = abs(tension - self.value) / self._ramp_time

    def advance(self) -> float:
        """Return the set-point of the next tick [N]."""
        step = self._slope * self._dt
        self.value += min(max(self._target - self.value, -step), step)
        return self.value


class ConstantTension:
    """Rate command = predicted boom-tip rate + (tension - set-point)/(stiffness * time constant).

    Parameters
    ----------
    model : the design's augmented model; cable : its stiffness; winch : delay and lag
    parameters : time constant, largest correction
    set_point : that is held, advanced by a tick with each command
    """

    def __init__(
        self,
        model: LinearModel,
        cable: CableModel,
        winch: WinchModelParameters,
        parameters: TensionLawParameters,
        set_point: TensionSetPoint,
    ) -> None:
        assert model.dt is not None
        self._set_point = set_point
        ticks = round((winch.command_delay + winch.time_constant) / model.dt)
        self._rate: Array = model.row("boom_tip_heave_rate") @ np.linalg.matrix_power(model.A, ticks)
        if winch.law == "speed_servo":
            self._rate = self._rate + standing_command(model, winch)
        self._per_tension = 1.0 / (cable.stiffness * parameters.time_constant)
        self._largest = parameters.speed_limit

    def command(self, state: LoopState) -> LawCommand:
        """Return the command; `state.x` is the unshifted estimate, so that the whole boom tip is followed."""
        correction = (state.measured_tension - self._set_point.advance()) * self._per_tension
        return LawCommand(float(self._rate @ state.x) + min(max(correction, -self._largest), self._largest))
