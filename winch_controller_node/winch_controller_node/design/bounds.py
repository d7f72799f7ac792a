"""The bounds that kappa is measured against: what no controller can beat, whatever it does.

s_est (see `prediction.estimation_bound`) is what sensors and delay leave without limits; s_act is what the winch's
limits leave to one who knows the whole future. kappa = s(z) / sqrt(s_est^2 + s_act^2).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import osqp
import scipy.sparse as sp
from heave_node.arrays import Array
from heave_node.linear_model import covariance_factor, interconnect, linear_model, state_covariance
from heave_node.linear_sampling import discretise
from heave_node.randomness import random_stream

from winch_controller_node.model.blocks import CableModel, cable_block
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.model.models import boom_tip_block
from winch_controller_node.parameters.model import SeaModelParameters, VesselModelParameters

BOUND_STEP = 0.2
"""Step of the clairvoyant's plan [s]: a fortieth of the shortest peak period of the benchmarks."""


@dataclass(frozen=True)
class WinchLimits:
    """Limits of the winch: speed [m/s], acceleration [m/s^2], payout either way of its mean [m]."""

    speed: float
    acceleration: float
    payout: float = math.inf


def boom_tip_realisation(
    sea: SeaModelParameters, vessel: VesselModelParameters, *, duration: float, step: float, seed: int
) -> Array:
    """Return stationary boom-tip heave of the design sea, shape (duration/step,) [m], from its shaping filter.

    Parameters
    ----------
    sea, vessel : of the design
    duration, step : of the record [s]
    seed : of the noise that drives the filter
    """
    model = discretise(boom_tip_block(sea, vessel), step)
    rng = random_stream(seed, "winch_controller/bound")
    count = round(duration / step)
    x = covariance_factor(state_covariance(model)) @ rng.standard_normal(model.order)
    noise = rng.standard_normal((count, model.G.shape[1])) @ model.G.T
    row = model.row("boom_tip_heave")
    heave = np.empty(count)
    for k in range(count):
        heave[k] = row @ x
        x = model.A @ x + noise[k]
    return heave


def actuator_bound(cable: CableModel, limits: WinchLimits, boom_tip_heave: Array, step: float) -> float:
    """Return s_act [m]: the least unit sigma within the winch's limits for one who knows the boom tip beforehand.

    A quadratic programme over the whole record: payout acceleration constant over each step, outlet motion straight
    between samples, cable exact. The first and last tenth are left out: there the plan has no past or no future.

    Parameters
    ----------
    cable : two-state
    limits : of the winch
    boom_tip_heave : the record [m], a sample each `step` [s]

    Raises DesignError where the programme is not solved.
    """
    solution = _clairvoyant(cable, limits, boom_tip_heave, step)
    edge = len(solution) // 10
    return float(np.std(solution[edge:-edge]))


def _clairvoyant(cable: CableModel, limits: WinchLimits, tip: Array, h: float) -> Array:
    """Return unit heave under the best payout; variables per sample are x, x', payout, payout rate, acceleration."""
    n = len(tip)
    transition, at_start, at_end = _first_order_hold(cable, h)
    size = 1.0 / math.sqrt(cable.a)
    rows, columns, values, right = [], [], [], []

    def put(row: int, k: int, variable: int, value: float) -> None:
        rows.append(row)
        columns.append(5 * k + variable)
        values.append(value)

    for k in range(n - 1):
        r = 4 * k
        for i in range(2):
            # x in metres, x' divided by the natural frequency: numbers of one size
            scale = 1.0 if i == 0 else 1.0 / size
            for j in range(2):
                put(r + i, k, j, transition[i, j] * scale * (1.0 if j == 0 else size))
            put(r + i, k + 1, i, -1.0)
            put(r + i, k, 2, -at_start[i] * scale)
            put(r + i, k + 1, 2, -at_end[i] * scale)
            right.append(-scale * float(at_start[i] * tip[k] + at_end[i] * tip[k + 1]))
        for variable, value in ((2, 1.0), (3, h), (4, 0.5 * h * h)):
            put(r + 2, k, variable, value)
        put(r + 2, k + 1, 2, -1.0)
        for variable, value in ((3, 1.0), (4, h)):
            put(r + 3, k, variable, value)
        put(r + 3, k + 1, 3, -1.0)
        right += [0.0, 0.0]
    dynamics = sp.csc_matrix((values, (rows, columns)), shape=(4 * (n - 1), 5 * n))
    return _solve(dynamics, np.array(right), limits, n)


def _first_order_hold(cable: CableModel, h: float) -> tuple[Array, Array, Array]:
    """Return transition, and the effect of the outlet's start and end value of a step in which it moves straight."""
    unit = cable_block(cable)
    ramp = linear_model([[0.0, 1.0], [0.0, 0.0]], states=("outlet", "slope"), outputs={"boom_tip_heave": [1.0, 0.0]})
    sampled = discretise(interconnect([unit, ramp]), h).A
    slope = sampled[:2, 3] / h
    return sampled[:2, :2], sampled[:2, 2] - slope, slope


def _solve(dynamics: sp.csc_matrix, right: Array, limits: WinchLimits, n: int) -> Array:
    cost = sp.diags(np.tile([1.0, 1e-9, 1e-9, 1e-9, 1e-9], n), format="csc")
    box = np.tile([np.inf, np.inf, limits.payout, limits.speed, limits.acceleration], n)
    bounded = np.isfinite(box)
    selection = sp.eye(5 * n, format="csc")[np.flatnonzero(bounded)]
    solver = osqp.OSQP()
    solver.setup(
        cost,
        np.zeros(5 * n),
        sp.vstack([dynamics, selection], format="csc"),
        np.concatenate([right, -box[bounded]]),
        np.concatenate([right, box[bounded]]),
        verbose=False,
        eps_abs=1e-5,
        eps_rel=1e-5,
        max_iter=20_000,
        polishing=False,
    )
    result = solver.solve(raise_error=False)
    if result.info.status not in ("solved", "solved inaccurate"):
        raise DesignError(f"the bound of the actuator could not be computed: the solver says {result.info.status}")
    return np.asarray(result.x[0::5])
