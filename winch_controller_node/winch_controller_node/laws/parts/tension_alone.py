"""Constant tension without the motion reference unit: tension and drum lead alone."""

from __future__ import annotations

from typing import NamedTuple

from heave_node.numerics.arrays import Array
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
        self._stiffness, self._largest = cable.stiffness, winch.speed_limit
        loop = wire_loop(cable, winch, round_trip, model.dt)
        self._tip = TipByTension(model, loop, 1.0 / max(time_constant, standing_time_constant(loop)))
        self.standing = self._tip.time_constant
        self.hanging = max(time_constant, hanging_time_constant(loop, cable))

    def begin(self, x: Array, record: TensionRecord) -> None:
        """Go on from a state `x` of the model, shape (n,), with the `record` up to then."""
        self._tip.begin(x, record)

    def rate(self, record: TensionRecord, set_point: float, *, unit_stands: bool) -> TensionRate:
        """Return the rate that is asked.

        Parameters
        ----------
        record : up to now
        set_point : of the tension [N]
        unit_stands : on the bottom
        """
        stretch = (record.mean_tension(self._tip.window) - set_point) / self._stiffness
        correction = stretch / (self.standing if unit_stands else self.hanging)
        tip = self._tip.update(record) if unit_stands else 0.0
        return TensionRate(tip, min(max(correction, -self._largest), self._largest))
