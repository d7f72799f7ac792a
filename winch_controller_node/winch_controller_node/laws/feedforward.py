"""Speed feed-forward of the boom tip's rate: what industry does, and the baseline of every better law.

Without prediction the MRU's heave rate is commanded as it is read, and delay and lag of the winch leave their phase.
With prediction the Kalman filter's boom tip is taken forward to when the command has come through delay and lag.
"""

from __future__ import annotations

import math

import numpy as np
from heave_node.arrays import Array
from heave_node.linear_model import LinearModel

from winch_controller_node.laws.feedback import LawCommand
from winch_controller_node.laws.governor import standing_command
from winch_controller_node.laws.loop_state import LoopState
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.parameters.laws import FeedforwardParameters
from winch_controller_node.parameters.model import WinchModelParameters

HOLD_TIME, HOLD_LAGS = 2.0, 4.0
"""The payout follows the boom tip within this time [s], and no quicker than so many lags of the winch."""

SETTLING_DAMPING = 0.5
"""Damping ratio that the unit is given on its way back to the uncompensated motion."""

SETTLED = 0.05
"""Swing about the uncompensated motion that is worth no more of it [m]."""


class SpeedFeedforward:
    """Rate command = boom-tip rate (predicted or read), and a slow pull of the payout to its mean.

    Parameters
    ----------
    model : the design's augmented model
    winch : delay and lag to predict over
    parameters : prediction or not; centring time

    Raises DesignError for a first-order winch, whose command is a payout.
    """

    def __init__(self, model: LinearModel, winch: WinchModelParameters, parameters: FeedforwardParameters) -> None:
        if winch.law == "first_order":
            raise DesignError("law feedforward commands a rate: it needs winch.law speed_servo")
        assert model.dt is not None
        ticks = round((winch.command_delay + winch.time_constant) / model.dt) if parameters.prediction else 0
        self._rate: Array = model.row("boom_tip_heave_rate") @ np.linalg.matrix_power(model.A, ticks)
        self._payout: Array = model.row("payout") / parameters.centring_time - standing_command(model, winch)
        self._uses_reading = not parameters.prediction
        self.gain: Array = np.zeros(0)
        self.reading = 0.0
        """The MRU's newest heave rate times the authority [m/s]; set each tick by the owner."""

    def command(self, state: LoopState) -> LawCommand:
        """Return the command at `state`."""
        rate = self.reading if self._uses_reading else float(self._rate @ state.x)
        return LawCommand(rate - float(self._payout @ state.x))

    def reset(self) -> None:
        """Nothing is remembered."""
        self.reading = 0.0


class OutletHold:
    """Brings a lost loop back: the payout follows the boom tip slowly, and the unit's swing is damped.

    Rate command = boom-tip rate + (outlet + d z')/time + d z'', so that the outlet becomes -d z'. It takes back, in
    seconds, whatever payout a lost loop has left, before the unit follows it: a unit whose mean has been moved by
    metres swings about the new mean for minutes. A heavy unit on a long cable also has hardly any damping of its own:
    let go at another phase than that of the uncompensated motion it would swing on for minutes. Its resonance is so
    slow that damping it bears delays far beyond those believed; where it is not (a stiff, short cable), the unit
    follows the fade by itself and d is 0.

    Parameters
    ----------
    model : the design's augmented model
    winch : delay and lag to predict over
    inertia : a of the two-state cable [s^2]; 0: the unit is left alone

    Raises DesignError for a first-order winch, whose command is a payout.
    """

    def __init__(self, model: LinearModel, winch: WinchModelParameters, inertia: float) -> None:
        if winch.law == "first_order":
            raise DesignError("holding the outlet commands a rate: it needs winch.law speed_servo")
        assert model.dt is not None
        lag = winch.command_delay + winch.time_constant
        ahead = np.linalg.matrix_power(model.A, round(lag / model.dt))
        is_slow = math.sqrt(inertia) > HOLD_LAGS * lag
        self.settled = SETTLED if is_slow else math.inf
        """Swing about the uncompensated motion, payout included, at which the winch may stop [m]."""
        damping = 2.0 * SETTLING_DAMPING * math.sqrt(inertia) if is_slow else 0.0
        outlet = model.row("boom_tip_heave") - model.row("payout") + damping * model.row("unit_heave_rate")
        rate = model.row("boom_tip_heave_rate") + damping * model.row("unit_heave_acceleration")
        back = rate + outlet / max(HOLD_TIME, HOLD_LAGS * lag)
        self._row: Array = back @ ahead + standing_command(model, winch)
        self.gain: Array = -self._row

    def command(self, state: LoopState) -> LawCommand:
        """Return the command at `state`."""
        return LawCommand(float(self._row @ state.x))

    def reset(self) -> None:
        """Nothing is remembered."""
