"""Law industrial: common practice of winch makers, as an honest baseline for better laws.

The outlet follows the boom tip: speed feed-forward and a position loop, both predicted over the command's delay, and
the winch's lag inverted. Nothing is known of cable and unit, and nothing is tuned but by the winch's stated lag T and
delay tau:

    v_set = v_d + T a_d,   v_d = v + k (x - p),   a_d = a + k (v - p'),   k by `rule_gain`

x, v, a of the boom tip, payout p and its rate, all at t + tau + half a tick: a command is held over a tick. The payout
is predicted from the commands that are still on their way (Smith predictor), the boom tip by the estimator.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from heave_core.law_table import LawKind
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel
from heave_node.parameters import parameter

from winch_controller_node.laws.core_law import CoreLaw
from winch_controller_node.laws.law import LawDesign
from winch_controller_node.laws.parts.governor import drum_ahead, standing_command
from winch_controller_node.model.lqr import DesignError

LARGEST_GAIN = 2.0
"""Largest gain of the position loop by the rule [1/s]."""


def rule_gain(delay: float, lag: float) -> float:
    """Return the gain of the position loop [1/s]: 1/(4 (delay + lag/4)), at most `LARGEST_GAIN`.

    A position loop of gain k round a delay is stable for k delay < pi/2: a quarter of that leaves a phase margin of
    75 degrees; what the inversion of the lag gets wrong counts as a quarter of it.

    Parameters
    ----------
    delay : from the reading to the effect, half a tick included [s]
    lag : time constant of the winch's speed [s]
    """
    return min(1.0 / (4.0 * (delay + 0.25 * lag)), LARGEST_GAIN)


@dataclass(frozen=True)
class IndustrialParameters:
    """The industrial baseline."""

    position_gain: float = parameter(0.0, "1/s", 0.0, 20.0,
        "Gain of the position loop at the boom tip; 0: computed from delay and lag of the winch.")  # fmt: skip


class IndustrialBaseline(CoreLaw):
    """Outlet position loop with speed feed-forward, delay predicted and lag inverted.

    Parameters
    ----------
    design : what the law is made for
    parameters : gain of the position loop

    Raises DesignError for a first-order winch, whose command is a payout.
    """

    name: ClassVar[str] = "industrial"
    summary: ClassVar[str] = "position loop on the rope at the boom tip, with speed feed-forward: the baseline"
    parameters_type: ClassVar[type | None] = IndustrialParameters
    required_sensors: ClassVar[tuple[str, ...]] = ("mru",)
    feeds_back_unit: ClassVar[bool] = False

    def __init__(self, design: LawDesign, parameters: IndustrialParameters) -> None:
        model, winch = design.model, design.winch
        if winch.law == "first_order":
            raise DesignError("law industrial commands a rate: set winch.law to speed_servo")
        assert model.dt is not None
        delay, lag = winch.command_delay + 0.5 * model.dt, winch.time_constant
        k = parameters.position_gain or rule_gain(delay, lag)
        heave, rate, acceleration = _tip_ahead(model, delay)
        payout, payout_rate = drum_ahead(model, winch)
        payout = payout + 0.5 * model.dt * payout_rate
        wanted = rate + k * (heave - payout)
        slope = acceleration + k * (rate - payout_rate)
        gain = -(wanted + lag * slope + standing_command(model, winch))
        super().__init__(design, LawKind.LINEAR_LAW, gain=gain)
        self.gain = gain


def _tip_ahead(model: LinearModel, time: float) -> tuple[Array, Array, Array]:
    """Return rows of the boom tip's heave, rate and acceleration a `time` [s] from now, linear between ticks."""
    assert model.dt is not None
    whole = math.floor(time / model.dt)
    share = time / model.dt - whole
    soon = np.linalg.matrix_power(model.A, whole)
    later = soon @ model.A
    ahead = (1.0 - share) * soon + share * later
    rate = model.row("boom_tip_heave_rate")
    return model.row("boom_tip_heave") @ ahead, rate @ ahead, rate @ (later - soon) / model.dt
