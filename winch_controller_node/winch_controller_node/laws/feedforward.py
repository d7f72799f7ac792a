"""Law feedforward: the winch follows the boom tip's rate, its lag not inverted; the baseline is law industrial.

Without prediction the MRU's heave rate is commanded as it is read, and delay and lag of the winch leave their phase.
With prediction the Kalman filter's boom tip is taken forward to when the command has come through delay and lag.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from heave_core.law_table import LawKind
from heave_node.parameters import parameter

from winch_controller_node.laws.core_law import CoreLaw
from winch_controller_node.laws.law import LawDesign
from winch_controller_node.laws.parts.governor import standing_command
from winch_controller_node.model.lqr import DesignError


@dataclass(frozen=True)
class FeedforwardParameters:
    """The speed feed-forward of the MRU."""

    prediction: bool = parameter(True,
        description="Predict the boom tip over the winch's delay and lag; false: command the MRU's rate.")  # fmt: skip
    centring_time: float = 60.0  # time constant with which the mean payout is restored [s]


class SpeedFeedforward(CoreLaw):
    """Rate command = boom-tip rate (predicted or read), and a slow pull of the payout to its mean.

    Parameters
    ----------
    design : what the law is made for
    parameters : prediction or not; centring time

    Raises DesignError for a first-order winch, whose command is a payout.
    """

    name: ClassVar[str] = "feedforward"
    summary: ClassVar[str] = "boom-tip rate, predicted or as measured by the MRU"
    parameters_type: ClassVar[type | None] = FeedforwardParameters
    required_sensors: ClassVar[tuple[str, ...]] = ("mru",)
    feeds_back_unit: ClassVar[bool] = False

    def __init__(self, design: LawDesign, parameters: FeedforwardParameters) -> None:
        model, winch = design.model, design.winch
        if winch.law == "first_order":
            raise DesignError("law feedforward commands a rate: set winch.law to speed_servo")
        assert model.dt is not None
        ticks = round((winch.command_delay + winch.time_constant) / model.dt)
        predicted = model.row("boom_tip_heave_rate") @ np.linalg.matrix_power(model.A, ticks)
        centring = model.row("payout") / parameters.centring_time - standing_command(model, winch)
        rate, of_reading = (predicted, 0.0) if parameters.prediction else (np.zeros(model.order), 1.0)
        super().__init__(design, LawKind.LINEAR_LAW, gain=centring - rate, reading_share=of_reading)
