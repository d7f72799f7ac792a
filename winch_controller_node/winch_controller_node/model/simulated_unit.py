"""What is not linear of a hanging unit, quadratic drag and a cable that is slack, and the unit that moves by both.

Gains are designed for a unit that hardly moves. One that no winch holds may move by metres, and near the resonance its
motion is then ruled by a drag several times that of the design. At the speed v of the tick the damping is drag |v|, so
that the state moves as quadratic drag lets it. It is split off the exact step of the linear model: half of what it
takes of the unit's speed goes before the step and half after it (Strang, SIAM J. Numer. Anal. 5 (1968) 506).

A cable cannot push: the unit then goes down by its weight in water alone, without the part of the cable that moves with
it; when the cable takes it up again both go on with their common momentum.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from heave_core.filter import Drag, Slack
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.estimator import MeasurementModel
from winch_controller_node.model.models import shadow_model


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


def kept_speed(drag: Drag, speed: float, time: float) -> float:
    """Return the share of its `speed` [m/s] that a `drag` leaves a unit in a `time` [s], beyond the linear damping."""
    excess = max(drag.quadratic * abs(speed) - drag.damping, 0.0)
    return math.exp(-excess / drag.inertia * time)


class SimulatedUnit:
    """The unit as it moves below an outlet whose motion is known, nothing being measured of the unit.

    Parameters
    ----------
    cable : that it hangs on
    tick_period : [s]
    """

    def __init__(self, cable: CableModel, tick_period: float) -> None:
        self._mode, self._outlet, self._is_slack = np.zeros(2), np.zeros(2), False
        self.take_cable(cable, tick_period)

    @property
    def state(self) -> Array:
        """Heave [m] and heave rate [m/s], shape (2,)."""
        return self._model.C @ self._mode + self._model.D @ self._outlet

    def take_cable(self, cable: CableModel, tick_period: float) -> None:
        """Go on with another `cable`, in ticks of `tick_period` [s]."""
        self._dt, self._participation = tick_period, cable.participation
        self._inertia, self._largest_push = cable.natural_a, cable.unit_weight / cable.stiffness
        self._model = shadow_model(cable, tick_period)
        self._drag = unit_drag(self._model, cable, "mode_heave_rate")
        # of a uniform cable a third moves with the unit, and a sixth is what makes the participation more than 1
        self._cable_share = 2.0 * (cable.participation - 1.0)

    def continue_at(self, state: Array) -> None:
        """Go on from another `state`, shape (2,)."""
        self._mode = (state - self._model.D @ self._outlet) / self._participation

    def go_over_to(self, state: Array, time: float) -> None:
        """Go over to another `state`, shape (2,), with a time constant of `time` [s], by a tick."""
        before = self.state
        self.continue_at(before + self._dt / time * (state - before))

    def step(self, outlet: Array) -> Array:
        """Advance by a tick and return the state.

        `outlet` is its heave [m] and heave rate [m/s] at the start of the tick, shape (2,): those of the boom tip less
        payout and payout rate.
        """
        half = np.array([1.0, kept_speed(self._drag, self._mode[1], 0.5 * self._dt)])
        moved = half * (self._model.A @ (half * self._mode) + self._model.B @ outlet)
        before = self._missing_push(self._mode[0] - outlet[0])
        self._outlet = outlet + np.array([self._dt * outlet[1], 0.0])
        after = self._missing_push(moved[0] - self._outlet[0])
        moved[1] += self._gained_speed(0.5 * (before + after))
        was_slack, self._is_slack = self._is_slack, after > 0.0
        if self._is_slack:
            moved[1] -= self._gained_speed(self._cable_share * self._largest_push)
        elif was_slack:
            moved[1] += self._cable_share * (outlet[1] - moved[1])
        self._mode = moved
        return self.state

    def _missing_push(self, stretch: float) -> float:
        """Return by how much more than its weight the model would push the unit down at a `stretch` of the mode [m]."""
        return max(self._participation * stretch - self._largest_push, 0.0)

    def _gained_speed(self, pull: float) -> float:
        """Return the speed of the mode that a `pull` upwards, in metres of stretch, makes within a tick [m/s]."""
        return self._dt * pull / (self._inertia * self._participation)
