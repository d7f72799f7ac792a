"""Constant tension: the winch follows the boom tip and corrects what is left of the tension's error slowly."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from heave_core.law import put
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.laws.parts.governor import standing_command
from winch_controller_node.laws.parts.tip_by_tension import WAVE_TIME_SHARES, TensionAlone, TensionRecord
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.parameters.laws import TensionLawParameters
from winch_controller_node.parameters.model import WinchModelParameters

BLEND_TIME = 2.0
"""Time over which the boom tip is given up, or taken up again [s]."""

TRAVEL_TIME = 5.0
"""Time over which travel is averaged [s]: it is not to count the waves."""

TRAVEL = "travel"
"""Name of the bound on travel."""


class ConstantTension:
    """Rate command = predicted boom-tip rate + (tension - set-point)/(stiffness * time constant), made in the core.

    Without the motion reference unit the tension leads alone, see `TensionAlone`, up to the winch's own speed. The
    tension that is held is on its way to the one asked for; how far the winch has paid out or taken in is bounded.

    `memory` : array of one `TensionState` of the core; it outlives a design
    """

    def __init__(self, memory: Any) -> None:
        self._memory = memory
        put(memory, {"value": math.nan, "target": math.nan, "origin": math.nan, "bound": math.inf})

    def take_design(
        self,
        model: LinearModel,
        cable: CableModel,
        winch: WinchModelParameters,
        parameters: TensionLawParameters,
        *,
        round_trip: Callable[[float], float],
    ) -> dict[str, Any]:
        """Go by another design from now on; the tension that is held stays. Returns fields of `TensionLaw` in the core.

        Parameters
        ----------
        model : the design's augmented model
        cable : its stiffness, and what a hanging unit does; winch : delay and lag
        parameters : time constant, largest correction, time of the ramp, travel
        round_trip : time of a wave down the cable and back [s], by payout [m]
        """
        assert model.dt is not None
        self._model, self._cable, self._winch, self._parameters = model, cable, winch, parameters
        self._round_trip = round_trip
        longest = max(WAVE_TIME_SHARES) * round_trip(winch.payout_maximum)
        TensionRecord(longest, tick_period=model.dt, record=self._memory["record"])
        put(self._memory, {"tip_share": 1.0, "has_alone": 0, "begins": 0})
        ticks = round((winch.command_delay + winch.time_constant) / model.dt)
        is_servo = winch.law == "speed_servo"
        return {
            "tip_rate": model.row("boom_tip_heave_rate") @ np.linalg.matrix_power(model.A, ticks),
            "standing": standing_command(model, winch) if is_servo else np.zeros(model.order),
            "outlet": model.row("payout") - model.row("boom_tip_heave"),
            "time_constant": parameters.time_constant,
            "speed": parameters.speed_limit,
            "blend_step": model.dt / BLEND_TIME,
            "travel_share": model.dt / TRAVEL_TIME,
        }

    @property
    def value(self) -> float:
        """Tension that is held now [N]; NaN before the first."""
        return float(self._memory["value"][0])

    @property
    def target(self) -> float:
        """Tension that it goes to [N]; NaN before the first."""
        return float(self._memory["target"][0])

    def begin(self, measured: float) -> None:
        """Start from the measured tension [N]: none was held until now."""
        put(self._memory, {"value": measured, "target": measured, "slope": 0.0})

    def hold(self, tension: float) -> None:
        """Go to a tension [N] from the one that is held; the travel counts from the next tick on.

        It may be no more either way than its bound beyond what the change of tension needs.
        """
        change = abs(tension - self.value)
        travel = {"origin": math.nan, "travel": 0.0, "bound": self._parameters.travel}
        travel["required"] = change / self._cable.stiffness
        put(self._memory, {"target": tension, "slope": change / self._parameters.ramp_time, **travel})

    def begin_alone(self, payout: float) -> None:
        """Let tension and drum lead alone from the next tick on, on the wire that is out at a `payout` [m]."""
        alone = TensionAlone(
            self._model, self._cable, self._winch, self._round_trip(payout), self._parameters.time_constant
        )
        put(self._memory, {"alone": alone.core[0], "has_alone": 1, "begins": 1})
