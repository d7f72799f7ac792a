"""Constant tension: the winch follows the boom tip and corrects what is left of the tension's error slowly."""

from __future__ import annotations

import math

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.laws.law import LawCommand
from winch_controller_node.laws.parts.governor import standing_command
from winch_controller_node.laws.parts.loop_state import LoopState
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.parameters.laws import TensionLawParameters
from winch_controller_node.parameters.model import WinchModelParameters

ALONE_LAGS = 2.0
"""Time constant of a tension loop without the boom tip, in lags of the winch: a phase margin of 60 degrees."""

BLEND_TIME = 2.0
"""Time over which the boom tip is given up, or taken up again [s]."""

TRAVEL_TIME = 5.0
"""Time over which travel is averaged [s]: it is not to count the waves."""

TRAVEL = "travel"
"""Name of the bound on travel."""


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


class Travel:
    """How far constant tension has paid out or taken in, and how far it may.

    Parameters
    ----------
    tick_period : [s]
    """

    def __init__(self, *, tick_period: float) -> None:
        self._weight = tick_period / TRAVEL_TIME
        self._origin = math.nan
        self._travel = 0.0
        self._bound = math.inf

    def begin(self, bound: float) -> None:
        """Count from the next tick on; no more than `bound` either way [m]."""
        self._origin, self._travel, self._bound = math.nan, 0.0, bound

    def bounded(self, correction: float, outlet: float) -> float:
        """Return what of a `correction` [m/s] keeps the bound; `outlet`: cable out beyond the boom tip [m]."""
        if not math.isfinite(self._origin):
            self._origin = outlet
        self._travel += self._weight * (outlet - self._origin - self._travel)
        if abs(self._travel) >= self._bound and correction * self._travel > 0.0:
            return 0.0
        return correction


class ConstantTension:
    """Rate command = predicted boom-tip rate + (tension - set-point)/(stiffness * time constant).

    Without the motion reference unit the tension alone leads, faster and up to the winch's own speed.

    Parameters
    ----------
    model : the design's augmented model; cable : its stiffness; winch : delay and lag
    parameters : time constant, largest correction
    set_point : that is held, advanced by a tick with each command
    travel : that is bounded
    """

    def __init__(
        self,
        model: LinearModel,
        cable: CableModel,
        winch: WinchModelParameters,
        parameters: TensionLawParameters,
        set_point: TensionSetPoint,
        travel: Travel,
    ) -> None:
        assert model.dt is not None
        self._set_point, self._travel = set_point, travel
        lag = winch.command_delay + winch.time_constant
        ticks = round(lag / model.dt)
        self._tip_rate: Array = model.row("boom_tip_heave_rate") @ np.linalg.matrix_power(model.A, ticks)
        self._standing: Array = standing_command(model, winch) if winch.law == "speed_servo" else np.zeros(model.order)
        self._outlet: Array = model.row("payout") - model.row("boom_tip_heave")
        self._stiffness = cable.stiffness
        self._times = (max(ALONE_LAGS * lag, ALONE_LAGS * model.dt), parameters.time_constant)
        self._largest = (winch.speed_limit, parameters.speed_limit)
        self._step = model.dt / BLEND_TIME
        self._tip_share = 1.0

    def command(self, state: LoopState, tension: float, *, follows_tip: bool) -> LawCommand:
        """Return the command.

        Parameters
        ----------
        state : its `x` is the unshifted estimate, so that the whole boom tip is followed
        tension : newest reading [N], used where it leads alone
        follows_tip : the motion of the boom tip is known
        """
        share = self._tip_share + min(max(float(follows_tip) - self._tip_share, -self._step), self._step)
        self._tip_share = share
        alone, with_tip = self._times
        measured = share * state.measured_tension + (1.0 - share) * tension
        time_constant = share * with_tip + (1.0 - share) * alone
        largest = share * self._largest[1] + (1.0 - share) * self._largest[0]
        correction = (measured - self._set_point.advance()) / (self._stiffness * time_constant)
        correction = min(max(correction, -largest), largest)
        bounded = self._travel.bounded(correction, float(self._outlet @ state.x) + state.reference.payout)
        active = (TRAVEL,) if bounded != correction else ()
        rate = float(self._standing @ state.x) + share * float(self._tip_rate @ state.x) + bounded
        return LawCommand(rate, active=active)
