"""Constant tension: the winch follows the boom tip and corrects what is left of the tension's error slowly."""

from __future__ import annotations

import math

import numpy as np
from heave_node.arrays import Array
from heave_node.linear_model import LinearModel

from winch_controller_node.laws.feedback import LawCommand
from winch_controller_node.laws.governor import standing_command
from winch_controller_node.laws.loop_state import LoopState
from winch_controller_node.model.models import CableModel
from winch_controller_node.parameters.laws import TensionLawParameters
from winch_controller_node.parameters.model import WinchModelParameters

FILTER_SHARE = 0.25
"""Time constant of the load cell's low-pass over that of the loop."""


class ConstantTension:
    """Rate command = predicted boom-tip rate + (tension - set-point)/(stiffness * time constant).

    Parameters
    ----------
    model : the design's augmented model; cable : its stiffness; winch : delay and lag
    parameters : time constant, ramp, largest correction
    before : the law of an earlier design, whose set-point and measured tension are taken over

    Attributes
    ----------
    set_point : tension that is held now, on its way to the one asked for [N]
    measured : low-passed measured tension [N]; NaN before the first reading
    """

    def __init__(
        self,
        model: LinearModel,
        cable: CableModel,
        winch: WinchModelParameters,
        parameters: TensionLawParameters,
        before: ConstantTension | None = None,
    ) -> None:
        assert model.dt is not None
        self.gain: Array = np.zeros(0)
        self._dt = model.dt
        self._parameters = parameters
        ticks = round((winch.command_delay + winch.time_constant) / model.dt)
        self._rate: Array = model.row("boom_tip_heave_rate") @ np.linalg.matrix_power(model.A, ticks)
        if winch.law == "speed_servo":
            self._rate = self._rate + standing_command(model, winch)
        self._per_tension = 1.0 / (cable.stiffness * parameters.time_constant)
        self.set_point = math.nan
        self.measured = math.nan
        self._target = math.nan
        self._slope = 0.0
        if before is not None:
            self.set_point, self.measured = before.set_point, before.measured
            self._target, self._slope = before._target, before._slope

    def reset(self) -> None:
        """Forget the set-point; the measured tension stays."""
        self.set_point = math.nan
        self._target = math.nan

    def hold(self, tension: float) -> None:
        """Ask for a tension [N]; the set-point ramps there from the measured one."""
        if not math.isfinite(self.set_point):
            self.set_point = self.measured if math.isfinite(self.measured) else tension
        self._target = tension
        self._slope = abs(tension - self.set_point) / self._parameters.ramp_time

    def observe(self, tension: float) -> None:
        """Take one reading of the load cell [N] in."""
        if not math.isfinite(self.measured):
            self.measured = tension
        weight = self._dt / (FILTER_SHARE * self._parameters.time_constant + self._dt)
        self.measured += weight * (tension - self.measured)

    def command(self, state: LoopState) -> LawCommand:
        """Return the command; `state.x` is the unshifted estimate, so that the whole boom tip is followed."""
        step = self._slope * self._dt
        self.set_point += min(max(self._target - self.set_point, -step), step)
        correction = (self.measured - self.set_point) * self._per_tension
        limit = self._parameters.speed_limit
        return LawCommand(float(self._rate @ state.x) + min(max(correction, -limit), limit))
