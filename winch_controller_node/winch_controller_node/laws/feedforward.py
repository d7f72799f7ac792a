"""Speed feed-forward of the boom tip's rate: what industry does, and the baseline of every better law.

Without prediction the MRU's heave rate is commanded as it is read, and delay and lag of the winch leave their phase.
With prediction the Kalman filter's boom tip is taken forward to when the command has come through delay and lag.
"""

from __future__ import annotations

import numpy as np

from winch_controller_node.law_parameters import FeedforwardParameters
from winch_controller_node.laws.feedback import LawCommand
from winch_controller_node.laws.loop_state import LoopState
from winch_controller_node.linear_model import Array, LinearModel
from winch_controller_node.lqr import DesignError
from winch_controller_node.model_parameters import WinchModelParameters

HOLD_TIME, HOLD_LAGS = 2.0, 4.0
"""The payout follows the boom tip within this time [s], and no quicker than so many lags of the winch."""


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
        self._payout: Array = model.row("payout") / parameters.centring_time
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
    """Holds the outlet still without feedback of the unit: rate command = boom-tip rate + (boom tip - payout)/time.

    It takes back, in seconds, whatever payout a lost loop has left, before the unit follows it: a unit whose mean has
    been moved by metres swings about the new mean for minutes.

    Parameters
    ----------
    model : the design's augmented model
    winch : delay and lag to predict over

    Raises DesignError for a first-order winch, whose command is a payout.
    """

    def __init__(self, model: LinearModel, winch: WinchModelParameters) -> None:
        if winch.law == "first_order":
            raise DesignError("holding the outlet commands a rate: it needs winch.law speed_servo")
        assert model.dt is not None
        lag = winch.command_delay + winch.time_constant
        ahead = np.linalg.matrix_power(model.A, round(lag / model.dt))
        outlet = (model.row("boom_tip_heave") - model.row("payout")) @ ahead
        self._row: Array = model.row("boom_tip_heave_rate") @ ahead + outlet / max(HOLD_TIME, HOLD_LAGS * lag)
        self.gain: Array = -self._row

    def command(self, state: LoopState) -> LawCommand:
        """Return the command at `state`."""
        return LawCommand(float(self._row @ state.x))

    def reset(self) -> None:
        """Nothing is remembered."""
