"""Quadratic drag in a step of a linear model, compiled; see `simulated_unit`."""

from __future__ import annotations

import math
from typing import NamedTuple

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import kernel

UNCERTAINTY = 0.3
"""Standard deviation of the drag that is more than the design's damping, as a share of it: coefficients of bodies that
oscillate are known to a third. So it is with the push of a slack cable that is missing: shocks catch it again."""

UNCERTAINTY_TIME = 1.0
"""Time over which it errs in one direction [s]: a fraction of a wave."""


class Drag(NamedTuple):
    """The drag of the unit in a model; without any values there is none.

    Attributes
    ----------
    rate : index of the unit's heave rate in the state
    inertia : of the cable model [s^2]; damping : the linear one that the model has [s]
    quadratic : damping over speed [s^2/m]
    tick_period : [s]
    power : 2, of a standard deviation: a literal is compiled to a product, which may differ from Python's last bit
    """

    rate: int = 0
    inertia: float = 1.0
    damping: float = 0.0
    quadratic: float = 0.0
    tick_period: float = 0.0
    power: float = 2.0


@kernel
def excess_damping(drag: Drag, speed: float) -> float:
    """Return by how much the damping of a `drag` at a `speed` [m/s] is more than the linear one [s]."""
    return max(drag.quadratic * abs(speed) - drag.damping, 0.0)


@kernel
def kept_speed(drag: Drag, speed: float, time: float) -> float:
    """Return the share of its `speed` [m/s] that a `drag` leaves a unit in a `time` [s], beyond the linear damping."""
    return math.exp(-excess_damping(drag, speed) / drag.inertia * time)


@kernel
def with_drag(drag: Drag, x: Array, F: Array, B: Array, Q: Array) -> tuple[Array, Array, Array]:
    """Return F (n, n), B (n,) and noise Q (n, n) of a step from a state x (n,) with `drag`; a slow unit has none."""
    rate, speed = drag.rate, abs(x[drag.rate])
    excess = excess_damping(drag, speed)
    if excess == 0.0:
        return F, B, Q
    half = kept_speed(drag, speed, 0.5 * drag.tick_period)
    F, B, Q = F.copy(), B.copy(), Q.copy()
    F[rate] *= half
    B[rate] *= half
    Q[rate] *= half
    F[:, rate] *= half
    Q[:, rate] *= half
    Q[rate, rate] += (UNCERTAINTY * excess / drag.inertia * speed) ** drag.power * UNCERTAINTY_TIME * drag.tick_period
    return F, B, Q
