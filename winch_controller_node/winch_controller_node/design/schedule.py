"""Gain schedule over the deployed length: a resonance crosses the sea while a unit is lowered, gains go with it.

Gains are designed at lengths in geometric progression and interpolated between them in the logarithm of length; the
model is exact at every length. That the loop is stable between the points is checked at design, not hoped for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import spectral_abscissa, with_feedback

from winch_controller_node.design.design import ControllerDesign, assumed_plant, at_cable, design_controller
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.model.models import cable_between
from winch_controller_node.model.regulator import is_sensor_state
from winch_controller_node.node_parameters import WinchControllerParameters

CHECKED_BETWEEN = 1
"""Lengths between two neighbouring points at which stability is checked."""


@dataclass(frozen=True)
class GainSchedule:
    """Designs over length.

    Attributes
    ----------
    designs : in rising length, two or more
    """

    designs: tuple[ControllerDesign, ...]

    @property
    def lengths(self) -> Array:
        """Lengths of the points [m]."""
        return np.array([design.length for design in self.designs])

    def gain_at(self, length: float) -> Array:
        """Return the interpolated gain at `length` [m], shape (n,); beyond the ends that of the end."""
        first, share = self._place(length)
        return (1.0 - share) * self.designs[first].gain + share * self.designs[first + 1].gain

    def cable_at(self, length: float) -> CableModel:
        """Return the cable at `length` [m]: a and b between those of the points, stiffness and tension exact."""
        first, share = self._place(length)
        low, high = self.designs[first].cable, self.designs[first + 1].cable
        a = math.exp((1.0 - share) * math.log(low.a) + share * math.log(high.a))
        b = (1.0 - share) * low.b + share * high.b
        p = self.designs[0].parameters
        plant = assumed_plant(p)
        return cable_between(plant, p.cable_model, length, a=a, b=b)

    def design_at(self, length: float) -> ControllerDesign:
        """Return the design at `length` [m]: exact model of the interpolated cable, interpolated gain."""
        first, _ = self._place(length)
        return at_cable(self.designs[first], self.cable_at(length), length, self.gain_at(length))

    def check(self) -> float:
        """Return the largest closed-loop pole between the points, magnitude.

        Raises DesignError, naming the length, where the interpolated gain does not stabilise the model.
        """
        worst = 0.0
        for low, high in zip(self.designs[:-1], self.designs[1:], strict=True):
            for i in range(1, CHECKED_BETWEEN + 1):
                length = low.length * (high.length / low.length) ** (i / (CHECKED_BETWEEN + 1))
                radius = closed_loop_radius(self.design_at(length))
                if radius >= 1.0:
                    raise DesignError(
                        f"between {low.length:g} and {high.length:g} m the scheduled gain does not stabilise the "
                        "loop: increase schedule.points"
                    )
                worst = max(worst, radius)
        return worst

    def _place(self, length: float) -> tuple[int, float]:
        """Return the point below `length` and the share of the one above it, in the logarithm of length."""
        logs = np.log(self.lengths)
        at = min(max(math.log(length), logs[0]), logs[-1])
        first = min(int(np.searchsorted(logs, at, side="right")) - 1, len(logs) - 2)
        return first, float((at - logs[first]) / (logs[first + 1] - logs[first]))


def closed_loop_radius(design: ControllerDesign) -> float:
    """Return the largest magnitude of the closed loop's poles, sensor states (which no command moves) left out.

    The loop is that of `design`.
    """
    keep = [name for name in design.model.state_names if not is_sensor_state(name)]
    closed = with_feedback(design.model, design.gain).select_states(keep)
    return spectral_abscissa(closed)


def is_scheduled(parameters: WinchControllerParameters) -> bool:
    """Return whether the parameters ask for a schedule."""
    return parameters.schedule.maximum_length > 0.0


def identifies_winch(parameters: WinchControllerParameters) -> bool:
    """Tell whether the winch is identified while the loop runs: a speed servo, no gain schedule in `parameters`."""
    return parameters.lag.adaptation and not is_scheduled(parameters) and parameters.winch.law != "first_order"


FOLLOW = 0.03
"""Change of length, relative, at which the scheduled design is renewed."""


def design_schedule(parameters: WinchControllerParameters, *, tick_period: float) -> GainSchedule:
    """Design the schedule of `parameters.schedule` for a `tick_period` [s], and check it.

    Raises DesignError where a point cannot be designed, or the loop is not stable between two of them.
    """
    wanted = parameters.schedule
    shortest = wanted.minimum_length if wanted.minimum_length > 0.0 else parameters.length
    if not wanted.maximum_length > shortest:
        raise DesignError(
            f"schedule.maximum_length = {wanted.maximum_length:g} m must be above the shortest length, {shortest:g} m"
        )
    lengths = np.geomspace(shortest, wanted.maximum_length, wanted.points)
    schedule = GainSchedule(
        tuple(design_controller(parameters, tick_period=tick_period, length=float(length)) for length in lengths)
    )
    schedule.check()
    return schedule
