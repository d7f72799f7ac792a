"""Constant tension without the motion reference unit: tension and drum lead alone."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from heave_core.law import put
from heave_core.law_table import TENSION_ALONE
from heave_core.library import library, new
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.laws.parts.tip_by_tension import (
    TensionRecord,
    TipByTension,
    hanging_time_constant,
    standing_time_constant,
    wire_loop,
)
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.parameters.model import WinchModelParameters


class TensionRate(NamedTuple):
    """A rate command in two parts [m/s]: what follows the boom `tip`, and the `correction` of the tension."""

    tip: float
    correction: float


class TensionAlone:
    """Follows the boom tip as tension and drum tell it, and corrects by the mean tension.

    Above a unit that hangs they do not tell it, and the correction is left.

    Parameters
    ----------
    model : sampled augmented model of the design
    cable : stiffness, and what a hanging unit does; winch : delay, lag and speed
    round_trip : time of a wave down the cable and back [s]
    time_constant : of the correction; the least, which delay and wire may lengthen [s]

    Attributes
    ----------
    tip : the boom tip as tension and drum tell it
    core : array of one `TensionAlone` of the core
    standing, hanging : time constant of the correction above a unit that stands, and above one that hangs [s]
    """

    def __init__(
        self,
        model: LinearModel,
        cable: CableModel,
        winch: WinchModelParameters,
        round_trip: float,
        time_constant: float,
    ) -> None:
        assert model.dt is not None
        loop = wire_loop(cable, winch, round_trip, model.dt)
        self._largest = winch.speed_limit
        self.tip = TipByTension(model, loop, 1.0 / max(time_constant, standing_time_constant(loop)))
        self.standing = self.tip.time_constant
        self.hanging = max(time_constant, hanging_time_constant(loop, cable))
        self.core = new(TENSION_ALONE)
        self.tip.tell(self.core)
        put(self.core, {"standing": self.standing, "hanging": self.hanging})

    def rate(self, record: TensionRecord, set_point: float, *, unit_stands: bool) -> TensionRate:
        """Return the rate that is asked.

        Parameters
        ----------
        record : up to now
        set_point : of the tension [N]
        unit_stands : on the bottom
        """
        found = np.zeros(2)
        addresses = self.core.ctypes.data, record.record.ctypes.data
        library().heave_core_lead_alone(*addresses, set_point, self._largest, unit_stands, found.ctypes.data)
        return TensionRate(*found.tolist())
