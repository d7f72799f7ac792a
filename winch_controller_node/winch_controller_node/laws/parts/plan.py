"""The plan of law mpc: the winch's limits as rows of it, and the solver that corrects it.

A row gives a constrained quantity at a tick of the horizon from the state now, from the correction, and from what a
preview predicts beyond the state.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import daqp
import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel
from numpy.typing import NDArray

from winch_controller_node.laws.parts.governor import (
    ACCELERATION,
    PAYOUT,
    POWER,
    SPEED,
    TENSION,
    standing_command,
)
from winch_controller_node.parameters.model import WinchModelParameters

UNBOUNDED = 1e30
"""Bound that stands for none."""
SOFT = 8
"""DAQP's mark of a soft constraint."""

ACTIVE_TOLERANCE = 1e-3
"""A limit shapes the plan when the plan comes this near to it, relative to the limit."""

SPARED = 0.02
"""Share of the acceleration limit that a command leaves unused where no limit shapes the plan."""


def correction_knots(horizon: float, dt: float) -> list[int]:
    """Return the ticks of the hat functions: dense where the next commands are made, sparse far ahead.

    `horizon` [s], `dt` : tick period [s].
    """
    knots, time = [0], 0.0
    while time < horizon - 1e-9:
        time += 0.1 if time < 0.5 else 0.25 if time < 3.0 else 0.35
        tick = round(min(time, horizon) / dt)
        if tick > knots[-1]:
            knots.append(tick)
    if len(knots) > 2 and knots[-1] - knots[-2] == 1:
        del knots[-2]  # else nothing before the end of the horizon would belong to the last one
    return knots


def constrained_ticks(first: int, horizon_ticks: int, dt: float) -> list[int]:
    """Return the ticks from `first` up to `horizon_ticks` at which limits are kept: each one soon, some later.

    `dt` : tick period [s].
    """
    ticks: list[int] = []
    tick = first
    while tick < horizon_ticks:
        ticks.append(tick)
        ahead = (tick - first) * dt
        tick += max(1, round((0.05 if ahead < 2.3 else 0.1 if ahead < 4.8 else 0.15) / dt))
    return ticks


def hat_functions(knots: list[int], ticks: int) -> Array:
    """Return the basis of the correction, shape (ticks, knots): linear between knots."""
    time = np.arange(ticks)
    return np.column_stack([np.interp(time, knots, np.eye(len(knots))[j]) for j in range(len(knots))])


@dataclass(frozen=True, eq=False)
class _Rows:
    """Rows of one kind of constraint: which rows, and when [s from now]."""

    name: str
    rows: slice
    times: Array


class Planned(NamedTuple):
    """What a plan is made for."""

    gain: Array  # of the feedback under it, shape (n,)
    basis: Array  # of the correction, shape (ticks, m)
    disturbances: Array  # of a preview, shape (k, n, p): what it adds to the state
    fed: Array  # of a preview, shape (k, p): what it adds to the command
    standing: Array  # row that gives the command under which the drum does not accelerate, shape (n,)
    delay: int  # of the command, in ticks


class PlanRows:
    """The limits of the winch as rows of the plan.

    Parameters
    ----------
    model : sampled
    winch : a speed servo
    plan : what it is made for

    Attributes
    ----------
    kinds : of rows
    free, forced, previewed : rows of the state, the correction and the preview, shapes (r, n), (r, m), (r, p)
    """

    def __init__(self, model: LinearModel, winch: WinchModelParameters, plan: Planned) -> None:
        assert model.dt is not None
        dense = np.array(constrained_ticks(plan.delay, len(plan.basis), model.dt))
        sparse, commanded = dense[::3], dense - plan.delay

        def asked_less(taken: Array, divisor: float) -> tuple[Array, float]:
            return -(plan.gain + taken) / divisor, 1.0 / divisor

        constrained = [
            _Constrained(SPEED, dense, *_output(model, plan.gain, "payout_rate")),
            # acceleration at the moment each command takes effect, which may be within a tick
            _Constrained(ACCELERATION, commanded, *asked_less(plan.standing, winch.time_constant)),
            # the speed that the servo is asked for: a slow one needs more than it makes
            _Constrained(SPEED, commanded, *asked_less(standing_command(model, winch), 1.0)),
            _Constrained(PAYOUT, sparse, *_output(model, plan.gain, "payout")),
            _Constrained(TENSION, sparse, *_output(model, plan.gain, "tension")),
        ]
        self.kinds, start = [], 0
        for one in constrained:
            self.kinds.append(_Rows(one.name, slice(start, start + len(one.ticks)), np.asarray(one.ticks * model.dt)))
            start += len(one.ticks)
        self.free, self.forced, self.previewed = _rows(model, plan, constrained)

    def active(self, planned: Array, lower: Array, upper: Array, *, speed: float, power: float) -> tuple[str, ...]:
        """Return the limits that a plan touches, in words.

        Parameters
        ----------
        planned, lower, upper : of all rows, shape (r,)
        speed, power : limits of the winch [m/s], [W]
        """
        active = []
        for kind in self.kinds:
            values, low, high = planned[kind.rows], lower[kind.rows], upper[kind.rows]
            if np.any(values >= high - ACTIVE_TOLERANCE * np.abs(high)) or np.any(
                values <= low + ACTIVE_TOLERANCE * np.abs(low)
            ):
                is_power = kind.name == SPEED and math.isfinite(power)
                active.append(POWER if is_power and float(np.max(high)) < speed else kind.name)
        return tuple(active)


class PlanSolver:
    """Finds the smallest correction with which a plan keeps its bounds: a QP with a constant Hessian.

    Parameters
    ----------
    basis : of the correction, shape (ticks, m)
    forced : rows of it, shape (r, m)
    tick_period : [s]
    iteration_limit : iterations after which it gives up
    softness : reciprocal weight of a violated bound
    """

    def __init__(
        self, basis: Array, forced: Array, *, tick_period: float, iteration_limit: int, softness: float
    ) -> None:
        hessian = basis.T @ basis * tick_period
        self._scale = 1.0 / np.sqrt(np.diag(hessian))
        self._hessian = np.ascontiguousarray(hessian * self._scale[:, None] * self._scale[None, :])
        self._forced = np.ascontiguousarray(forced * self._scale[None, :])
        self._settings = {"iter_limit": iteration_limit, "rho_soft": softness}
        self._fresh: Any = None  # solver without a warm start
        self.restart()

    def restart(self) -> None:
        """Discard the warm start: another solver takes the place, which was prepared beside the ticks."""
        self.prepare()
        self._solver, self._fresh = self._fresh, None

    def prepare(self) -> None:
        """Have such a solver: to set one up takes longer than a tick may."""
        if self._fresh is not None:
            return
        rows, columns = self._forced.shape
        self._fresh = daqp.Model()
        self._fresh.settings = self._settings
        self._fresh.setup(
            self._hessian,
            np.zeros(columns),
            self._forced,
            np.full(rows, UNBOUNDED),
            np.full(rows, -UNBOUNDED),
            np.full(rows, SOFT, dtype=np.int32),
        )

    def solve(self, lower: Array, upper: Array) -> tuple[Array | None, int]:
        """Return the correction, shape (m,), for bounds `lower` and `upper`, shape (r,), and its iterations."""
        self._solver.update(bupper=upper, blower=lower)
        solution, _, flag, info = self._solver.solve()
        iterations = int(info["iterations"])
        if flag > 0 and np.all(np.isfinite(solution)):
            return np.asarray(solution) * self._scale, iterations
        # a solver that stopped in mid-way starts afresh
        self.restart()
        return None, iterations


class _Constrained(NamedTuple):
    """What is constrained, by its limit: feedback @ state + through * correction, at some ticks of the horizon."""

    name: str
    ticks: NDArray[np.int64]
    feedback: Array
    through: float


def _output(model: LinearModel, gain: Array, output: str) -> tuple[Array, float]:
    """Return the row of an output in the loop that the `gain` closes, and its direct share of the correction."""
    through = float(model.D[model.output_names.index(output), 0])
    return model.row(output) - through * gain, through


def _rows(model: LinearModel, plan: Planned, constrained: list[_Constrained]) -> tuple[Array, Array, Array]:
    """Return the rows of the state now, of the correction and of a preview, for all that is `constrained`.

    x_k = F^k x + sum F^(k-1-i) (B c_i + what a preview adds at i), with F = A - B G: the correction acts by the pulse
    response of each row.
    """
    basis, ticks = plan.basis, len(plan.basis)
    # no more is known of what comes after the preview than the estimate says
    fed = np.vstack([plan.fed, np.zeros((max(ticks - len(plan.fed), 0), plan.fed.shape[1]))])
    closed = model.A - model.B @ plan.gain[None, :]
    ahead = np.empty((ticks + 1, len(constrained), model.order))
    ahead[0] = [one.feedback for one in constrained]
    previewed = np.zeros((ticks + 1, model.order, fed.shape[1]))
    for k in range(ticks):
        ahead[k + 1] = ahead[k] @ closed
        if fed.shape[1] > 0:
            previewed[k + 1] = closed @ previewed[k] + model.B @ fed[k][None, :]
            previewed[k + 1] += plan.disturbances[k] if k < len(plan.disturbances) else 0.0
    pulse = ahead @ model.B[:, 0]
    rows = []
    for place, (_, at, feedback, through) in enumerate(constrained):
        since = at[:, None] - 1 - np.arange(ticks)
        commands = np.where(since >= 0, pulse[since, place], 0.0)
        now = np.minimum(at, ticks - 1)
        commands[np.arange(len(at)), now] += through
        rows.append((ahead[at, place], commands @ basis, feedback @ previewed[at] + through * fed[now]))
    free, forced, seen = (np.vstack(blocks) for blocks in zip(*rows, strict=True))
    return free, forced, seen
