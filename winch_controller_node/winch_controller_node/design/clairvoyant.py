"""The best payout within the winch's limits for one who knows the whole future: a quadratic programme over a record.

Least sum of squares of the unit's heave over payout accelerations that are constant over each step, outlet motion
straight between samples, cable exact, with bounds on payout, speed and acceleration. Solved by a primal-dual interior
point method from the winch at rest, which keeps all bounds from the start; each Newton step is a linear-quadratic
problem over the record, whose optimality conditions, ordered by time, are a band (Wright, J. Optim. Theory Appl. 77,
1993), so that the effort grows with the record and no faster.
"""

from __future__ import annotations

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import interconnect, linear_model
from heave_node.numerics.linear_sampling import discretise
from scipy.linalg import solve_banded

from winch_controller_node.model.blocks import CableModel, cable_block
from winch_controller_node.model.lqr import DesignError

MOST_ITERATIONS = 80
GAP = 1e-9
"""Duality gap per sample at which the plan counts as the best [m^2]: a standard deviation within 0.03 mm."""
SMALL = 1e-9
"""Weight of all that is not the unit's heave: keeps the conditions regular."""
SHARE = 0.995
"""Share of the way to a bound that a step may go."""
STAGE, BAND = 9, 8
"""Unknowns of a sample, four states, input, four multipliers of the step to the next; and how far they reach."""


def clairvoyant_heave(cable: CableModel, bounds: tuple[float, float, float], tip: Array, step: float) -> Array:
    """Return unit heave under the best payout, shape (n,) [m].

    Parameters
    ----------
    cable : two-state
    bounds : finite, of payout [m], payout rate [m/s] and payout acceleration [m/s^2], either way
    tip : boom-tip heave [m], shape (n,)
    step : from one sample to the next [s]

    Raises DesignError where the method does not settle.
    """
    transition, at_start, at_end = _first_order_hold(cable, step)
    F, G = np.zeros((4, 4)), np.zeros(4)
    F[:2, :2], F[:2, 2], F[:2, 3] = transition, -at_start - at_end, -step * at_end
    F[2], F[3] = (0.0, 0.0, 1.0, step), (0.0, 0.0, 0.0, 1.0)
    G[:2], G[2], G[3] = -0.5 * step**2 * at_end, 0.5 * step**2, step
    push = np.zeros((len(tip) - 1, 4))
    push[:, :2] = np.outer(tip[:-1], at_start) + np.outer(tip[1:], at_end)
    states, settled = _solve(F, G, push, np.array(bounds, dtype=float))
    if not settled:
        raise DesignError("the bound of the actuator could not be computed: the interior point method did not settle")
    return np.asarray(states[:, 0])


def _first_order_hold(cable: CableModel, h: float) -> tuple[Array, Array, Array]:
    """Return transition, and the effect of the outlet's start and end value of a step in which it moves straight."""
    unit = cable_block(cable)
    ramp = linear_model([[0.0, 1.0], [0.0, 0.0]], states=("outlet", "slope"), outputs={"boom_tip_heave": [1.0, 0.0]})
    sampled = discretise(interconnect([unit, ramp]), h).A
    slope = sampled[:2, 3] / h
    return sampled[:2, :2], sampled[:2, 2] - slope, slope


def _solve(F: Array, G: Array, push: Array, limits: Array) -> tuple[Array, bool]:
    """Return the states, shape (n, 4), and whether the method has settled. Bounds: payout, rate, acceleration.

    States: unit heave, its rate, payout, payout rate.
    """
    n = len(push) + 1
    states = np.zeros((n, 4))
    for k in range(n - 1):
        states[k + 1] = F @ states[k] + push[k]
    bounded = np.zeros((n, 3))  # payout, rate, acceleration at each sample
    gap = float(np.sum(states[:, 0] ** 2)) / (6.0 * n)
    sides = np.array([1.0, -1.0])[:, None, None]
    multipliers = np.tile(gap / limits, (2, n, 1))  # of the upper and the lower bounds
    band, centring = _conditions(F, G, n), 0.3
    for _ in range(MOST_ITERATIONS):
        room, target = limits - sides * bounded, centring * gap
        changes = _newton_step(band, states, np.sum(multipliers / room, axis=0), np.sum(sides * target / room, axis=0))
        change = np.column_stack((changes[:, 2:4], changes[:, 4]))
        turned = (target + sides * multipliers * change) / room - multipliers
        length = min(1.0, _reach(room, -sides * change), _reach(multipliers, turned))
        states += length * changes[:, :4]
        bounded += length * change
        multipliers += length * turned
        gap = float(np.mean(multipliers * (limits - sides * bounded)))
        if 6.0 * gap < GAP:
            return states, True
        centring = 0.1 if length > 0.9 else 0.5
    return states, False


def _reach(value: Array, change: Array) -> float:
    """Return the share of a `change` that a positive `value` can go without becoming 0."""
    falls = change < 0.0
    return float(np.min(SHARE * value[falls] / -change[falls], initial=np.inf))


def _conditions(F: Array, G: Array, n: int) -> Array:
    """Return the band of s[k+1] = F s[k] + G u[k] between n samples, and of its transpose, (2 BAND + 1, n STAGE).

    Rows of a sample are the slopes by its states and by its input, and the step to the next. The last one has none.
    """
    band = np.zeros((2 * BAND + 1, n * STAGE))
    couplings = [(5 + i, j, F[i, j]) for i in range(4) for j in range(4)]
    couplings += [(5 + i, 4, G[i]) for i in range(4)] + [(5 + i, STAGE + i, -1.0) for i in range(4)]
    for row, column, value in couplings:
        for i, j in ((row, column), (column, row)):
            band[BAND + i - j, j : (n - 1) * STAGE + j : STAGE] = value
    band[BAND, -STAGE + 4 :] = 1.0
    return band


def _newton_step(band: Array, states: Array, weight: Array, slope: Array) -> Array:
    """Return the changes of states and inputs, (n, 5), for bounds of a `weight` and a `slope`, (n, 3)."""
    n = len(states)
    diagonal, right = band[BAND].reshape(n, STAGE), np.zeros((n, STAGE))
    diagonal[:, :4] = [1.0, SMALL, SMALL, SMALL]
    diagonal[:, 2:4] += weight[:, :2]
    diagonal[:-1, 4] = SMALL + weight[:-1, 2]
    right[:, 0] = -states[:, 0]
    right[:, 2] = -slope[:, 0] - SMALL * states[:, 2]
    right[:, 3] = -slope[:, 1]
    right[:-1, 4] = -slope[:-1, 2]
    found = solve_banded((BAND, BAND), band, right.ravel(), check_finite=False)
    return np.asarray(found).reshape(n, STAGE)[:, :5]
