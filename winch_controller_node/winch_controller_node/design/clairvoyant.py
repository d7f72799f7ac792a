"""The best payout within the winch's limits for one who knows the whole future: a quadratic programme over a record.

Least sum of squares of the unit's heave over payout accelerations that are constant over each step, outlet motion
straight between samples, cable exact, with bounds on payout, speed and acceleration. Solved by a primal-dual interior
point method from the winch at rest, which keeps all bounds from the start; each Newton step is a linear-quadratic
problem over the record and is solved by Riccati recursion (Rao, Wright & Rawlings, J. Optim. Theory Appl. 99, 1998), so
that the effort grows with the record and no faster.
"""

from __future__ import annotations

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel, kernel
from heave_node.numerics.linear_model import interconnect, linear_model
from heave_node.numerics.linear_sampling import discretise

from winch_controller_node.model.blocks import CableModel, cable_block
from winch_controller_node.model.lqr import DesignError

MOST_ITERATIONS = 80
GAP = 1e-9
"""Duality gap per sample at which the plan counts as the best [m^2]: a standard deviation within 0.03 mm."""
SMALL = 1e-9
"""Weight of all that is not the unit's heave: keeps the recursion regular."""


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


@kernel
def _solve(F: Array, G: Array, push: Array, limits: Array) -> tuple[Array, bool]:
    """Return the states, shape (n, 4), and whether the method has settled. Bounds: payout, rate, acceleration.

    States: unit heave, its rate, payout, payout rate.
    """
    n = len(push) + 1
    states, inputs = np.zeros((n, 4)), np.zeros(n - 1)
    for k in range(n - 1):
        states[k + 1] = F @ states[k] + push[k]
    bounded = np.zeros((n, 3))  # payout, rate, acceleration at each sample
    upper, lower = np.empty((n, 3)), np.empty((n, 3))  # multipliers
    gap = np.sum(states[:, 0] ** 2) / (6.0 * n)
    for j in range(3):
        upper[:, j] = lower[:, j] = gap / limits[j]
    centring = 0.3
    for _ in range(MOST_ITERATIONS):
        ds, du = _newton_step(F, G, states, bounded, upper, lower, limits, centring * gap)
        length, new_gap = _advance(states, inputs, bounded, upper, lower, limits, ds, du, centring * gap)
        centring = 0.1 if length > 0.9 else 0.5
        gap = new_gap
        if 6.0 * gap < GAP:
            return states, True
    return states, False


@inner_kernel
def _newton_step(
    F: Array, G: Array, states: Array, bounded: Array, upper: Array, lower: Array, limits: Array, target: float
) -> tuple[Array, Array]:
    """Return the changes of states and inputs by Riccati recursion, back over the record and forth again."""
    n = len(states)
    K, d = np.empty((n - 1, 4)), np.empty(n - 1)
    P, p = np.zeros((4, 4)), np.zeros(4)
    weight, slope = np.empty(3), np.empty(3)
    for k in range(n - 1, -1, -1):
        for j in range(3):
            above, below = limits[j] - bounded[k, j], limits[j] + bounded[k, j]
            weight[j] = upper[k, j] / above + lower[k, j] / below
            slope[j] = target / above - target / below
        if k < n - 1:
            PG = P @ G
            H = SMALL + weight[2] + G @ PG
            K[k] = (PG @ F) / H
            slope_u = slope[2] + G @ p
            d[k] = slope_u / H
            p = F.T @ p - K[k] * slope_u
            P = F.T @ P @ F - H * np.outer(K[k], K[k])
            P = 0.5 * (P + P.T)
        P[0, 0] += 1.0
        P[1, 1] += SMALL
        P[2, 2] += SMALL + weight[0]
        P[3, 3] += SMALL + weight[1]
        p[0] += states[k, 0]
        p[2] += slope[0] + SMALL * states[k, 2]
        p[3] += slope[1]
    ds, du = np.empty((n, 4)), np.empty(n - 1)
    ds[0] = -np.linalg.solve(P, p)
    for k in range(n - 1):
        du[k] = -(K[k] @ ds[k]) - d[k]
        ds[k + 1] = F @ ds[k] + G * du[k]
    return ds, du


@inner_kernel
def _advance(
    states: Array,
    inputs: Array,
    bounded: Array,
    upper: Array,
    lower: Array,
    limits: Array,
    ds: Array,
    du: Array,
    target: float,
) -> tuple[float, float]:
    """Go as far along the step as the bounds allow, in place; return its length and the mean gap of a bound then."""
    n = len(states)
    change = np.zeros((n, 3))
    change[:, 0], change[:, 1], change[:-1, 2] = ds[:, 2], ds[:, 3], du
    primal = dual = 1.0
    d_upper, d_lower = np.empty((n, 3)), np.empty((n, 3))
    for k in range(n):
        for j in range(3):
            dy, above, below = change[k, j], limits[j] - bounded[k, j], limits[j] + bounded[k, j]
            d_upper[k, j] = (target + upper[k, j] * dy) / above - upper[k, j]
            d_lower[k, j] = (target - lower[k, j] * dy) / below - lower[k, j]
            if dy > 0.0:
                primal = min(primal, 0.995 * above / dy)
            elif dy < 0.0:
                primal = min(primal, 0.995 * below / -dy)
            if d_upper[k, j] < 0.0:
                dual = min(dual, -0.995 * upper[k, j] / d_upper[k, j])
            if d_lower[k, j] < 0.0:
                dual = min(dual, -0.995 * lower[k, j] / d_lower[k, j])
    length = min(primal, dual)
    states += length * ds
    inputs += length * du
    bounded += length * change
    upper += length * d_upper
    lower += length * d_lower
    total = 0.0
    for k in range(n):
        for j in range(3):
            total += upper[k, j] * (limits[j] - bounded[k, j]) + lower[k, j] * (limits[j] + bounded[k, j])
    return length, total / (6.0 * n)
