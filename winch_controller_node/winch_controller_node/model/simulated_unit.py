"""What is not linear of a hanging unit, quadratic drag and a cable that is slack, and the unit that moves by both.

Gains are designed for a unit that hardly moves. One that no winch holds may move by metres, and near the resonance its
motion is then ruled by a drag several times that of the design. At the speed v of the tick the damping is drag |v|, so
that the state moves as quadratic drag lets it. It is split off the exact step of the linear model: half of what it
takes of the unit's speed goes before the step and half after it (Strang, SIAM J. Numer. Anal. 5 (1968) 506).

A cable cannot push, see `slack_kernel`: the unit then goes down by its weight in water alone.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.drag_kernel import Drag, kept_speed
from winch_controller_node.model.estimator import MeasurementModel
from winch_controller_node.model.models import shadow_model
from winch_controller_node.model.slack_kernel import Slack


def unit_drag(model: LinearModel, cable: CableModel, rate: str = "unit_heave_rate") -> Drag:
    """Return the drag of the unit in a sampled `model`, whose damping is b of the `cable`; `rate` is the unit's."""
    return Drag(model.state(rate), cable.a, cable.b, cable.drag, model.dt or 0.0)


def cable_slack(model: LinearModel, cable: CableModel, measurements: Sequence[MeasurementModel]) -> Slack:
    """Return when the `cable` is slack in a sampled `model` with `measurements`."""
    payout = model.state("payout")
    return Slack(
        pull=model.row("tension") / cable.stiffness,
        # of what is measured, tension and acceleration alone go down with payout
        reads=np.array([max(-float(known.row[payout]), 0.0) for known in measurements]),
        rate=model.state("unit_heave_rate"),
        inertia=cable.a,
        largest=cable.unit_weight / cable.stiffness,
        tick_period=model.dt or 0.0,
    )


class SimulatedUnit:
    """The unit as it moves below an outlet whose motion is known, nothing being measured of the unit.

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
        self._inertia, self._largest_push = cable.a, cable.unit_weight / cable.stiffness
        self._model = shadow_model(cable, tick_period)
        self._drag = unit_drag(self._model, cable, "unit_uncompensated_heave_rate")

    def continue_at(self, state: Array) -> None:
        """Go on from another `state`, shape (2,)."""
        self.state = state

    def go_over_to(self, state: Array, time: float) -> None:
        """Go over to another `state`, shape (2,), with a time constant of `time` [s], by a tick."""
        self.state = self.state + self._dt / time * (state - self.state)

    def step(self, outlet: Array) -> Array:
        """Advance by a tick and return the state.

        `outlet` is its heave [m] and heave rate [m/s] at the start of the tick, shape (2,): those of the boom tip less
        payout and payout rate.
        """
        half = np.array([1.0, kept_speed(self._drag, self.state[1], 0.5 * self._dt)])
        moved = half * (self._model.A @ (half * self.state) + self._model.B @ outlet)
        before, after = self.state[0] - outlet[0], moved[0] - (outlet[0] + self._dt * outlet[1])
        missing_push = 0.5 * sum(max(push - self._largest_push, 0.0) for push in (before, after))
        self.state = moved + np.array([0.0, self._dt / self._inertia * missing_push])
        return self.state
