"""Quadratic drag in a model that is linear: the unit's damping follows the speed that it is seen to have.

Gains are designed for a unit that hardly moves. One that no winch holds may move by metres, and near the resonance its
motion is then ruled by a drag several times that of the design. At the speed v of the tick the damping is drag |v|, so
that the state moves as quadratic drag lets it. It is split off the exact step of the linear model: half of what it
takes of the unit's speed goes before the step and half after it (Strang, SIAM J. Numer. Anal. 5 (1968) 506).
"""

from __future__ import annotations

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.drag_kernel import Drag, kept_speed
from winch_controller_node.model.models import shadow_model


def unit_drag(model: LinearModel, cable: CableModel, rate: str = "unit_heave_rate") -> Drag:
    """Return the drag of the unit in a sampled `model`, whose damping is b of the `cable`; `rate` is the unit's."""
    return Drag(model.state(rate), cable.a, cable.b, cable.drag, model.dt or 0.0)


class ShadowUnit:
    """The unit as it would move with the winch locked.

    Parameters
    ----------
    cable : that it hangs on
    tick_period : [s]

    Attributes
    ----------
    state : heave [m] and heave rate [m/s], shape (2,)
    """

    def __init__(self, cable: CableModel, tick_period: float) -> None:
        self.state: Array = np.zeros(2)
        self.take_cable(cable, tick_period)

    def take_cable(self, cable: CableModel, tick_period: float) -> None:
        """Go on with another `cable`, in ticks of `tick_period` [s]."""
        self._dt = tick_period
        self._model = shadow_model(cable, tick_period)
        self._drag = unit_drag(self._model, cable, "unit_uncompensated_heave_rate")

    def continue_at(self, state: Array) -> None:
        """Go on from another `state`, shape (2,)."""
        self.state = state

    def step(self, boom_tip: Array) -> Array:
        """Advance by a tick and return the state.

        `boom_tip` is its heave [m] and heave rate [m/s] at the start of the tick, shape (2,).
        """
        half = np.array([1.0, kept_speed(self._drag, self.state[1], 0.5 * self._dt)])
        self.state = half * (self._model.A @ (half * self.state) + self._model.B @ boom_tip)
        return self.state
