"""Law mpc: model predictive control with the limits of the winch in the plan, on the same estimate as law lqg.

The command is u = -G x + c with a correction c over the horizon, zero after it. For the LQR gain G the cost of any c is
J = J_LQR + W sum c^2 exactly, W = R + B' P B: the best correction is the smallest that keeps the limits, and where the
LQR keeps them by itself there is none. The QP then has the identity for a Hessian (in a basis of hat functions), its
matrices never change, and each tick only its bounds are new. Constraints are soft, with a weight that makes a
violation dear: a QP without a solution does not exist. DAQP (dual active set, warm-started from the last active set)
solves it in some tens of microseconds; its iterations are capped, so that it is as repeatable as it is fast.

What is best at the limits is not what is best away from them: a cost that spares the command leaves the limits more
often alone, and some of the sea uncompensated. So there are two gains of one estimate. The plan at the limits is made
with the sparing one, and followed with it, so that the limits hold; away from them the law slides back to the full
one, which leaves no more motion than law lqg.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import daqp
import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel
from heave_node.parameters import parameter

from winch_controller_node.laws.law import ControlLaw, LawCommand, LawDesign
from winch_controller_node.laws.parts.governor import (
    ACCELERATION,
    PAYOUT,
    POWER,
    SPEED,
    TENSION,
    SpeedServo,
    drum_ahead,
    standing_command,
)
from winch_controller_node.laws.parts.loop_state import LoopState, Reference
from winch_controller_node.laws.parts.preview import STEP, PreviewReader, feedforward
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.model.lqr import DesignError
from winch_controller_node.model.regulator import acceleration_size, output_gain
from winch_controller_node.parameters.model import WinchModelParameters

FREE = "free"
"""Status of a command that no limit shapes."""
UNBOUNDED = 1e30
"""Bound that stands for none."""
SOFT = 8
"""DAQP's mark of a soft constraint."""

ACTIVE_TOLERANCE = 1e-3
"""A limit shapes the plan when the plan comes this near to it, relative to the limit."""

SPARED = 0.02
"""Share of the acceleration limit that a command leaves unused where no limit shapes the plan."""


@dataclass(frozen=True)
class MpcParameters:
    """The constrained law."""

    horizon: float = parameter(10.0, unit="s", minimum=1.0, maximum=60.0, description="Prediction horizon.")
    solve_ticks: int = parameter(1, unit="", minimum=1, maximum=20, description="Ticks between solutions.")
    iteration_limit: int = parameter(
        200, unit="", minimum=5, maximum=100_000, description="Iterations after which the last good plan is followed."
    )
    unit_heave: float = parameter(
        0.01, unit="m", minimum=1e-4, maximum=10.0, description="Scale of unit heave in this law's own quadratic cost."
    )
    payout_acceleration: float = parameter(
        0.5,
        unit="m/s^2",
        minimum=0.0,
        maximum=1e3,
        description="Scale of payout acceleration in that cost; 0 leaves it out.",
    )
    payout: float = parameter(50.0, unit="m", minimum=0.0, maximum=1e5, description="Scale of payout in that cost.")
    command: float = parameter(
        0.3,
        unit="m/s",
        minimum=1e-3,
        maximum=1e3,
        description="Scale of the command in that cost; a small one leaves some of the motion uncompensated.",
    )
    free_payout_acceleration: float = parameter(
        0.6,
        unit="m/s^2",
        minimum=0.0,
        maximum=1e3,
        description="Scale of payout acceleration away from the limits; 0 leaves it out.",
    )
    free_command: float = parameter(
        2.0, unit="m/s", minimum=1e-3, maximum=1e3, description="Scale of the command away from the limits."
    )
    release_time: float = parameter(
        60.0,
        unit="s",
        minimum=0.0,
        maximum=1e4,
        description="Time constant with which the law returns to full effort after a limit shaped its plan.",
    )
    preview_time: float = parameter(
        0.0,
        unit="s",
        minimum=0.0,
        maximum=60.0,
        description="Time ahead for which a preview of the boom tip is used, where one is given; 0: not used.",
    )
    preview_noise: float = parameter(
        0.05, unit="m", minimum=1e-3, maximum=10.0, description="Error of that preview, 1 sigma."
    )
    softness: float = parameter(
        1e-7, unit="", minimum=1e-12, maximum=1.0, description="Reciprocal weight of a violated constraint."
    )


def constrained_gain(model: LinearModel, parameters: MpcParameters) -> Array:
    """Return the LQR gain with which plans at the limits are made, shape (n,), for the weights of `parameters`.

    It can be sharper than that of a law whose command is clipped: the limits are in the plan. `model` is sampled.
    """
    return _gain(model, parameters, parameters.payout_acceleration, parameters.command)


def free_gain(model: LinearModel, parameters: MpcParameters) -> Array:
    """Return the LQR gain away from the limits, shape (n,), for the weights of `parameters`. `model` is sampled."""
    return _gain(model, parameters, parameters.free_payout_acceleration, parameters.free_command)


def _gain(model: LinearModel, parameters: MpcParameters, acceleration: float, command: float) -> Array:
    return output_gain(model, _sizes(model, parameters, acceleration), command)


def _sizes(model: LinearModel, parameters: MpcParameters, acceleration: float) -> dict[str, float]:
    return {
        "unit_heave": parameters.unit_heave,
        "payout": parameters.payout,
        "payout_acceleration": acceleration_size(model, acceleration),
    }


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


@dataclass(frozen=True)
class _Rows:
    """Rows of one kind of constraint: which rows, and when [s from now]."""

    name: str
    rows: slice
    times: Array


class ConstrainedLaw(ControlLaw):
    """MPC with limits on winch speed, acceleration, power, payout and tension.

    Parameters
    ----------
    design : what the law is made for; its winch is a speed servo
    parameters : horizon, ticks between solutions, caps, cost

    Raises DesignError for a first-order winch and for a horizon that the delay fills.

    Attributes
    ----------
    gain : in force, shape (n,): between that of the plan and that away from the limits
    limits : that are kept
    """

    name: ClassVar[str] = "mpc"
    summary: ClassVar[str] = "feedback of all states with the limits as constraints"
    parameters_type: ClassVar[type | None] = MpcParameters
    keeps_limits = True
    gain_names: ClassVar[tuple[str, ...]] = ("constrained", "free")

    def __init__(self, design: LawDesign, parameters: MpcParameters) -> None:
        super().__init__(design, parameters)
        model, winch = design.model, design.winch
        if "payout_acceleration" not in model.output_names:
            raise DesignError("law mpc bounds the winch's acceleration: set winch.law to speed_servo")
        assert model.dt is not None
        gains = design.own_gains or self.own_gains(design, parameters)
        self._constrained, self._free_less_constrained = gains["constrained"], gains["free"] - gains["constrained"]
        self._releasing = math.exp(-model.dt * parameters.solve_ticks / max(parameters.release_time, 1e-9))
        self._lag, self._dt = winch.time_constant, model.dt
        self._position_gain = winch.position_gain
        self._standing = drum_ahead(model, winch)[1] + standing_command(model, winch)
        self._set_point_reach = winch.set_point_reach
        self.take_limits(design.limits)
        self._parameters = parameters
        horizon_ticks = round(parameters.horizon / model.dt)
        command = model.input_names[0]
        delay = sum(name.startswith(command + "_") for name in model.state_names)
        if delay >= horizon_ticks:
            raise DesignError(
                f"mpc.horizon = {parameters.horizon:g} s must be longer than the command delay ({delay * model.dt:g} s)"
            )
        self._basis = _hat_functions(correction_knots(parameters.horizon, model.dt), horizon_ticks)
        self._prepare_preview(model, parameters)
        self._build_rows(model, winch, delay, horizon_ticks)
        self._setup_cost(model.dt)
        self.reset()

    @classmethod
    def own_gains(cls, design: LawDesign, parameters: MpcParameters) -> dict[str, Array]:
        """Return the gains of plans at the limits and away from them, for a `design` and `parameters`."""
        model = design.model
        return {"constrained": constrained_gain(model, parameters), "free": free_gain(model, parameters)}

    def take_limits(self, limits: WinchLimits) -> None:
        """Keep other limits from now on."""
        self.limits = limits
        self._acceleration = SpeedServo(self._lag, limits.acceleration, self._dt).linear_acceleration

    def _prepare_preview(self, model: LinearModel, parameters: MpcParameters) -> None:
        """Make what a preview needs; without one all of it has no columns."""
        self._reader: PreviewReader | None = None
        self._disturbances, self._fed = np.zeros((0, model.order, 0)), np.zeros((0, 0))
        if parameters.preview_time < STEP:
            return
        self._reader = PreviewReader(model, parameters.preview_time, parameters.preview_noise)
        self._disturbances, self.preview = self._reader.disturbances, self._reader.use

        def fed(gain: Array, acceleration: float, command: float) -> Array:
            return feedforward(model, gain, _sizes(model, parameters, acceleration), command, self._disturbances)

        free = self._constrained + self._free_less_constrained
        self._fed = fed(self._constrained, parameters.payout_acceleration, parameters.command)
        now = fed(free, parameters.free_payout_acceleration, parameters.free_command)[0]
        self._free_less_constrained_feed = now - self._fed[0]

    def _build_rows(self, model: LinearModel, winch: WinchModelParameters, delay: int, horizon_ticks: int) -> None:
        assert model.dt is not None
        dense = constrained_ticks(delay, horizon_ticks, model.dt)
        sparse = dense[::3]
        responses = _responses(model, self._constrained, self._basis, self._disturbances, self._fed)
        commanded = [tick - delay for tick in dense]
        blocks = [
            _output_rows(model, self._constrained, "payout_rate", dense, responses),
            # acceleration at the moment each command takes effect, which may be within a tick
            self._servo_rows(self._standing, winch.time_constant, commanded, responses),
            # the speed that the servo is asked for: a slow one needs more than it makes
            self._servo_rows(standing_command(model, winch), 1.0, commanded, responses),
            _output_rows(model, self._constrained, "payout", sparse, responses),
            _output_rows(model, self._constrained, "tension", sparse, responses),
        ]
        self._rows, start = [], 0
        for name, ticks in ((SPEED, dense), (ACCELERATION, dense), (SPEED, dense), (PAYOUT, sparse), (TENSION, sparse)):
            self._rows.append(_Rows(name, slice(start, start + len(ticks)), np.array(ticks) * model.dt))
            start += len(ticks)
        self._free, self._forced, self._previewed = (np.vstack(rows) for rows in zip(*blocks, strict=True))

    def _servo_rows(
        self, taken: Array, divisor: float, ticks: list[int], responses: _Responses
    ) -> tuple[Array, Array, Array]:
        """Return rows of the commands of `ticks`, less the row that is `taken` off them, over a `divisor`."""
        feedback, through = -(self._constrained + taken) / divisor, self._basis / divisor
        return (
            np.array([feedback @ responses.free[k] for k in ticks]),
            np.array([feedback @ responses.forced[k] + through[k] for k in ticks]),
            np.array([feedback @ responses.previewed[k] + responses.fed[k] / divisor for k in ticks]),
        )

    def _setup_cost(self, dt: float) -> None:
        hessian = self._basis.T @ self._basis * dt
        scale = 1.0 / np.sqrt(np.diag(hessian))
        self._scale = scale
        self._scaled_hessian = np.ascontiguousarray(hessian * scale[:, None] * scale[None, :])
        self._scaled_forced = np.ascontiguousarray(self._forced * scale[None, :])
        self._sense = np.full(len(self._forced), SOFT, dtype=np.int32)

    def reset(self) -> None:
        """Forget the plan and the solver's warm start."""
        self._start_solver()
        self._plan = np.zeros(self._basis.shape[1])
        self._plan_age = 0
        self._since_solution = 0
        self._last = LawCommand(0.0, "no solution yet")
        self._set_freedom(1.0)

    def _set_freedom(self, freedom: float) -> None:
        """Set the share [1] of the gain that is that away from the limits."""
        self._freedom = freedom
        self.gain = self._constrained + freedom * self._free_less_constrained

    def _start_solver(self) -> None:
        """Start a solver without a warm start."""
        count = len(self._forced)
        self._solver = daqp.Model()
        self._solver.settings = {
            "iter_limit": self._parameters.iteration_limit,
            "rho_soft": self._parameters.softness,
        }
        self._solver.setup(
            self._scaled_hessian,
            np.zeros(self._basis.shape[1]),
            self._scaled_forced,
            np.full(count, UNBOUNDED),
            np.full(count, -UNBOUNDED),
            self._sense,
        )

    def command(self, state: LoopState) -> LawCommand:
        """Return the command at `state`: solve when it is time, else follow the plan."""
        surprise = None if self._reader is None else self._reader.surprise(state.preview, state.x)
        if self._since_solution == 0:
            self._solve(state, surprise)
        else:
            self._plan_age += 1
        self._since_solution = (self._since_solution + 1) % self._parameters.solve_ticks
        correction = 0.0
        if self._plan_age < len(self._basis):
            correction = float(self._basis[self._plan_age] @ self._plan)
        last = self._last
        value = correction - float(self.gain @ state.x)
        if surprise is not None:
            value += float((self._fed[0] + self._freedom * self._free_less_constrained_feed) @ surprise)
        if last.status == FREE:
            taken = self._acceleration_taken(state.reference)
            value = self._spare(value, float(self._standing @ state.x) - taken * self._lag)
        return LawCommand(value, last.status, last.iterations, last.active)

    def _spare(self, value: float, standing: float) -> float:
        """Return the command that asks for no more than the acceleration limit, also at the start of the tick.

        A plan may ask for more at the start of a tick, to gain over all of it what the limit allows; noise alone should
        not. `standing` is the command [m/s] under which the drum would not accelerate, the mean payout's motion
        included.
        """
        step = (1.0 - SPARED) * self.limits.acceleration * self._lag
        return min(max(value, standing - step), standing + step)

    def _solve(self, state: LoopState, surprise: Array | None) -> None:
        free = self._free @ state.x
        if surprise is not None:
            free += self._previewed @ surprise
        lower, upper = self._bounds(state)
        if ((free <= upper) & (free >= lower)).all():
            self._set_freedom(1.0 - self._releasing * (1.0 - self._freedom))
            self._plan[:] = 0.0
            self._plan_age = 0
            self._last = LawCommand(0.0, FREE)
            return
        self._set_freedom(0.0)
        self._solver.update(bupper=upper - free, blower=lower - free)
        solution, _, flag, info = self._solver.solve()
        iterations = int(info["iterations"])
        if flag > 0 and np.all(np.isfinite(solution)):
            self._plan = np.asarray(solution) * self._scale
            self._plan_age = 0
            planned = free + self._forced @ self._plan
            self._last = LawCommand(0.0, "solved", iterations, self._active(planned, lower, upper))
        else:
            self._plan_age += 1
            status = f"not solved in {iterations} iterations: following the plan of {self._plan_age} ticks ago"
            self._last = LawCommand(0.0, status, iterations, self._last.active)
            # a solver that stopped in mid-way starts afresh
            self._start_solver()

    def _bounds(self, state: LoopState) -> tuple[Array, Array]:
        """Return lower and upper bounds of the constrained outputs, with the mean payout's share subtracted."""
        limits, reference = self.limits, state.reference
        speeds, accelerations, set_points, payouts, tensions = self._rows
        speed = limits.speed
        if math.isfinite(limits.power):
            swing = float((self._free[tensions.rows] @ state.x).max())
            speed = limits.speed_under(state.static_tension + max(swing, 0.0))
        mean = reference.payout + reference.rate * payouts.times
        least, most = limits.minimum_tension, limits.maximum_tension if state.bounds_tension else math.inf
        lower, upper = np.empty(len(self._forced)), np.empty(len(self._forced))
        lower[speeds.rows], upper[speeds.rows] = -speed - reference.rate, speed - reference.rate
        taken = self._acceleration_taken(reference)
        lower[accelerations.rows], upper[accelerations.rows] = -self._acceleration - taken, self._acceleration - taken
        reach = self._set_point_reach * speed
        asked = reference.command - self._position_gain * reference.payout
        lower[set_points.rows], upper[set_points.rows] = -reach - asked, reach - asked
        lower[payouts.rows], upper[payouts.rows] = limits.payout_minimum - mean, limits.payout_maximum - mean
        lower[tensions.rows] = least - state.static_tension if least > 0.0 else -UNBOUNDED
        upper[tensions.rows] = most - state.static_tension if math.isfinite(most) else UNBOUNDED
        return lower, upper

    def _acceleration_taken(self, reference: Reference) -> float:
        """Return the acceleration that the mean payout takes up when the next command takes effect [m/s^2]."""
        standing = reference.rate + self._position_gain * reference.payout
        return (reference.command - standing) / self._lag

    def _active(self, planned: Array, lower: Array, upper: Array) -> tuple[str, ...]:
        active = []
        for kind in self._rows:
            values, low, high = planned[kind.rows], lower[kind.rows], upper[kind.rows]
            if np.any(values >= high - ACTIVE_TOLERANCE * np.abs(high)) or np.any(
                values <= low + ACTIVE_TOLERANCE * np.abs(low)
            ):
                is_power = kind.name == SPEED and math.isfinite(self.limits.power)
                active.append(POWER if is_power and float(np.max(high)) < self.limits.speed else kind.name)
        return tuple(active)


def _hat_functions(knots: list[int], ticks: int) -> Array:
    """Return the basis of the correction, shape (ticks, knots): linear between knots."""
    time = np.arange(ticks)
    return np.column_stack([np.interp(time, knots, np.eye(len(knots))[j]) for j in range(len(knots))])


@dataclass(frozen=True)
class _Responses:
    """Per tick 0..ticks the free response of the closed loop (n, n), that to each basis function (n, m), and that to
    each surprise of a preview with the commands `fed` forward for it.
    """

    free: list[Array]
    forced: list[Array]
    previewed: list[Array]
    basis: Array
    fed: Array


def _responses(model: LinearModel, gain: Array, basis: Array, disturbances: Array, fed: Array) -> _Responses:
    closed = model.A - model.B @ gain[None, :]
    ticks, surprises = len(basis), fed.shape[1]
    # no more is known of what comes after the preview than the estimate says
    fed = np.vstack([fed, np.zeros((max(ticks - len(fed), 0), surprises))])
    free, forced = [np.eye(model.order)], [np.zeros((model.order, basis.shape[1]))]
    previewed = [np.zeros((model.order, surprises))]
    for k in range(ticks):
        free.append(closed @ free[-1])
        forced.append(closed @ forced[-1] + model.B @ basis[k][None, :])
        previewed.append(closed @ previewed[-1] + model.B @ fed[k][None, :])
        if k < len(disturbances):
            previewed[-1] += disturbances[k]
    return _Responses(free, forced, previewed, basis, fed)


def _output_rows(
    model: LinearModel, gain: Array, output: str, ticks: list[int], responses: _Responses
) -> tuple[Array, Array, Array]:
    """Return rows that give an output at `ticks` from the state now, from the correction and from a preview."""
    row, through = model.row(output), float(model.D[model.output_names.index(output), 0])
    feedback = row - through * gain
    basis, fed = responses.basis, responses.fed
    return (
        np.array([feedback @ responses.free[k] for k in ticks]),
        np.array([feedback @ responses.forced[k] + through * basis[min(k, len(basis) - 1)] for k in ticks]),
        np.array([feedback @ responses.previewed[k] + through * fed[min(k, len(fed) - 1)] for k in ticks]),
    )
