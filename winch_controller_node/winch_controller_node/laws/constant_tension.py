"""Constant tension: the winch follows the boom tip and corrects what is left of the tension's error slowly."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.laws.law import LawCommand
from winch_controller_node.laws.parts.governor import standing_command
from winch_controller_node.laws.parts.loop_state import LoopState
from winch_controller_node.laws.parts.tension_alone import TensionAlone, TensionRate
from winch_controller_node.laws.parts.tip_by_tension import WAVE_TIME_SHARES, TensionRecord
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.parameters.laws import TensionLawParameters
from winch_controller_node.parameters.model import WinchModelParameters

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
    target : that it goes to [N]
    """

    def __init__(self, parameters: TensionLawParameters, *, tick_period: float) -> None:
        self._dt = tick_period
        self._ramp_time = parameters.ramp_time
        self.value = math.nan
        self.target = math.nan
        self._slope = 0.0

    def begin(self, measured: float) -> None:
        """Start from the measured tension [N]: none was held until now."""
        self.value = self.target = measured
        self._slope = 0.0

    def hold(self, tension: float) -> None:
        """Go to a tension [N] from the one that is held."""
        self.target = tension
        self._slope = abs(tension - self.value) / self._ramp_time

    def advance(self) -> float:
        """Return the set-point of the next tick [N]."""
        step = self._slope * self._dt
        self.value += min(max(self.target - self.value, -step), step)
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
        self._bound, self._required = math.inf, 0.0

    def begin(self, bound: float, required: float = 0.0) -> None:
        """Count from the next tick on; no more than `bound` either way beyond what is `required` [m]."""
        self._origin, self._travel = math.nan, 0.0
        self._bound, self._required = bound, required

    @property
    def is_half_used(self) -> bool:
        """Tell whether half of the bound has been used."""
        return abs(self._travel) >= self._required + 0.5 * self._bound

    def bounded(self, correction: float, outlet: float) -> float:
        """Return what of a `correction` [m/s] keeps the bound; `outlet`: cable out beyond the boom tip [m]."""
        if not math.isfinite(self._origin):
            self._origin = outlet
        self._travel += self._weight * (outlet - self._origin - self._travel)
        if abs(self._travel) >= self._required + self._bound and correction * self._travel > 0.0:
            return 0.0
        return correction


class ConstantTension:
    """Rate command = predicted boom-tip rate + (tension - set-point)/(stiffness * time constant).

    Without the motion reference unit the tension leads alone, see `TensionAlone`, up to the winch's own speed.

    Parameters
    ----------
    model : the design's augmented model
    cable : its stiffness, and what a hanging unit does; winch : delay and lag
    parameters : time constant, largest correction
    set_point : that is held, advanced by a tick with each command
    travel : that is bounded
    round_trip : time of a wave down the cable and back [s], by payout [m]
    """

    def __init__(
        self,
        model: LinearModel,
        cable: CableModel,
        winch: WinchModelParameters,
        parameters: TensionLawParameters,
        set_point: TensionSetPoint,
        travel: Travel,
        *,
        round_trip: Callable[[float], float],
    ) -> None:
        assert model.dt is not None
        self._set_point, self._travel = set_point, travel
        self._model, self._cable, self._winch, self._parameters = model, cable, winch, parameters
        self._round_trip = round_trip
        ticks = round((winch.command_delay + winch.time_constant) / model.dt)
        self._tip_rate: Array = model.row("boom_tip_heave_rate") @ np.linalg.matrix_power(model.A, ticks)
        self._standing: Array = standing_command(model, winch) if winch.law == "speed_servo" else np.zeros(model.order)
        self._payout: Array = model.row("payout")
        self._boom_tip: Array = model.row("boom_tip_heave")
        self._step = model.dt / BLEND_TIME
        self._tip_share = 1.0
        longest = max(WAVE_TIME_SHARES) * round_trip(winch.payout_maximum)
        self._record = TensionRecord(longest, tick_period=model.dt)
        self._alone: TensionAlone | None = None

    def command(self, state: LoopState, tension: float, *, follows_tip: bool, unit_stands: bool) -> LawCommand:
        """Return the command.

        Parameters
        ----------
        state : its `x` is the unshifted estimate, so that the whole boom tip is followed
        tension : newest reading [N], used where it leads alone
        follows_tip : the motion of the boom tip is known
        unit_stands : on the bottom
        """
        self._record.add(tension, float(self._payout @ state.x) + state.reference.payout)
        if self._alone is None and not follows_tip:
            self._alone = self._begin_alone(state)
        share = self._tip_share + min(max(float(follows_tip) - self._tip_share, -self._step), self._step)
        self._tip_share = share
        if share == 1.0:
            self._alone = None
        set_point = self._set_point.advance()
        with_tip = self._followed(state, set_point)
        alone = with_tip if self._alone is None else self._alone.rate(self._record, set_point, unit_stands=unit_stands)
        correction = share * with_tip.correction + (1.0 - share) * alone.correction
        outlet = self._payout - self._boom_tip
        bounded = self._travel.bounded(correction, float(outlet @ state.x) + state.reference.payout)
        active = (TRAVEL,) if bounded != correction else ()
        tip = share * with_tip.tip + (1.0 - share) * alone.tip
        return LawCommand(float(self._standing @ state.x) + tip + bounded, active=active)

    def _followed(self, state: LoopState, set_point: float) -> TensionRate:
        """Return the rate with the boom tip as estimated in `state`, for a `set_point` [N]."""
        parameters = self._parameters
        correction = (state.measured_tension - set_point) / (self._cable.stiffness * parameters.time_constant)
        limit = parameters.speed_limit
        return TensionRate(float(self._tip_rate @ state.x), min(max(correction, -limit), limit))

    def _begin_alone(self, state: LoopState) -> TensionAlone:
        """Return what leads by the tension alone from now on, on the wire that is out."""
        payout = float(self._payout @ state.x) + state.reference.payout
        alone = TensionAlone(
            self._model, self._cable, self._winch, self._round_trip(payout), self._parameters.time_constant
        )
        alone.begin(state.x, self._record)
        return alone
