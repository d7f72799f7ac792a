"""How compensation is faded out: the payout follows the boom tip slowly, and the unit's swing is damped."""

from __future__ import annotations

import math

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.laws.parts.governor import standing_command
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.parameters.model import WinchModelParameters

HOLD_TIME, HOLD_LAGS = 2.0, 4.0
"""The payout follows the boom tip within this time [s], and no faster than this many time constants of the winch."""

SETTLING_DAMPING = 0.5
"""Damping ratio that the unit is given on its way back to the uncompensated motion."""

SETTLED_SWING = 0.05
"""Amplitude about the uncompensated motion below which the unit counts as settled [m]."""


class OutletHold:
    """Brings the winch back to its mean after an unstable or blind loop.

    Rate command = boom-tip rate + (outlet + d z')/time + d z'', so that the outlet becomes -d z'. It takes back, in
    seconds, whatever payout an unstable loop has left, before the unit follows it: a unit whose mean has been moved by
    metres swings about the new mean for minutes. A heavy unit on a long cable also has hardly any damping of its own:
    let go at another phase than that of the uncompensated motion it would swing on for minutes. Its resonance is so
    slow that damping it tolerates delays far beyond those of the model; where it is not (a stiff, short cable), the
    unit follows the fade by itself and d is 0.

    Parameters
    ----------
    model : the design's augmented model
    winch : delay and lag to predict over
    inertia : a of the two-state cable [s^2]; 0: the unit is left alone

    Raises DesignError for a first-order winch, whose command is a payout.
    """

    def __init__(self, model: LinearModel, winch: WinchModelParameters, inertia: float) -> None:
        if winch.law == "first_order":
            raise DesignError("the fade-out commands a rate: set winch.law to speed_servo")
        assert model.dt is not None
        lag = winch.command_delay + winch.time_constant
        ahead = np.linalg.matrix_power(model.A, round(lag / model.dt))
        is_slow = math.sqrt(inertia) > HOLD_LAGS * lag
        # swing about the uncompensated motion, payout included, at which the winch may stop [m]
        self.settled_swing = SETTLED_SWING if is_slow else math.inf
        damping = 2.0 * SETTLING_DAMPING * math.sqrt(inertia) if is_slow else 0.0
        outlet = model.row("boom_tip_heave") - model.row("payout") + damping * model.row("unit_heave_rate")
        rate = model.row("boom_tip_heave_rate") + damping * model.row("unit_heave_acceleration")
        back = rate + outlet / max(HOLD_TIME, HOLD_LAGS * lag)
        # of the rate command over all states, shape (n,)
        self.row: Array = back @ ahead + standing_command(model, winch)
