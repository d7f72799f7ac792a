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

import numpy as np
from heave_core.law import Law, put
from heave_core.law_table import FOLLOWED, PLAN_NUMBERS, PLAN_ROWS, LawKind, RowKind
from heave_node.interface.preview import HeavePreview
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel
from heave_node.parameters import parameter

from winch_controller_node.laws.core_law import CoreLaw
from winch_controller_node.laws.law import LawCommand, LawDesign
from winch_controller_node.laws.parts.governor import drum_ahead, standing_command
from winch_controller_node.laws.parts.plan import (
    SPARED,
    UNBOUNDED,
    Planned,
    PlanRows,
    PlanSolver,
    correction_knots,
    hat_functions,
)
from winch_controller_node.laws.parts.preview import STEP, PreviewReader, PreviewUse, feedforward
from winch_controller_node.model.lqr import DesignError, output_cost
from winch_controller_node.model.regulator import acceleration_size, full_gain


@dataclass(frozen=True)
class MpcParameters:
    """The constrained law."""

    horizon: float = parameter(10.0, unit="s", minimum=1.0, maximum=60.0, description="Prediction horizon.")
    solve_ticks: int = 1  # ticks between solutions
    iteration_limit: int = 200  # iterations after which the last good plan is followed
    unit_heave: float = parameter(0.01, "m", 1e-4, 10.0,
        "Cost of law mpc: scale of unit heave. Laws lqr and lqg have weights.unit_heave.")  # fmt: skip
    payout_acceleration: float = parameter(0.5, "m/s^2", 0.0, 1e3,
        "Cost of law mpc: scale of payout acceleration; smaller saves power, 0 removes it.")  # fmt: skip
    payout: float = 50.0  # cost: scale of payout [m]
    command: float = parameter(0.3, "m/s", 1e-3, 1e3,
        "Cost of law mpc: scale of the command; a small value leaves some motion uncompensated.")  # fmt: skip
    free_payout_acceleration: float = parameter(0.6, "m/s^2", 0.0, 1e3,
        "Cost away from the winch limits: scale of payout acceleration; less saves power, 0 removes it.")  # fmt: skip
    # cost away from the winch limits: scale of the command [m/s]; it hardly matters beside the acceleration term
    free_command: float = 2.0
    # time constant with which the law returns to full effort after a limit shaped its plan [s]
    release_time: float = 60.0
    preview_time: float = parameter(0.0, "s", 0.0, 60.0,
        "Time ahead for which a boom-tip preview is used; 0: not used.")  # fmt: skip
    preview_noise: float = parameter(0.05, "m", 1e-3, 10.0, "Error of the boom-tip preview, 1 sigma.")
    softness: float = 1e-7  # reciprocal weight of a violated constraint: smaller is harder [-]


def constrained_gain(model: LinearModel, parameters: MpcParameters) -> Array:
    """Return the LQR gain with which plans at the limits are made, shape (n,), for the weights of `parameters`.

    It can be sharper than that of a law whose command is clipped: the limits are in the plan. `model` is sampled.
    """
    return _gain(model, parameters, parameters.payout_acceleration, parameters.command)


def own_gains(model: LinearModel, parameters: MpcParameters) -> dict[str, Array]:
    """Return both by name; `model` is sampled, and the weights are those of `parameters`."""
    return {"constrained": constrained_gain(model, parameters), "free": free_gain(model, parameters)}


def free_gain(model: LinearModel, parameters: MpcParameters) -> Array:
    """Return the LQR gain away from the limits, shape (n,), for the weights of `parameters`. `model` is sampled."""
    return _gain(model, parameters, parameters.free_payout_acceleration, parameters.free_command)


def _gain(model: LinearModel, parameters: MpcParameters, acceleration: float, command: float) -> Array:
    return full_gain(model, output_cost(model, _sizes(model, parameters, acceleration), command))


def _sizes(model: LinearModel, parameters: MpcParameters, acceleration: float) -> dict[str, float]:
    return {
        "unit_heave": parameters.unit_heave,
        "payout": parameters.payout,
        "payout_acceleration": acceleration_size(model, acceleration),
    }


class Planner:
    """Makes the plans of a constrained law: what the core needs of them beforehand, and the correction where they do.

    Parameters
    ----------
    design : what the law is made for; its winch is a speed servo
    parameters : horizon, ticks between solutions, caps, cost
    core : of the law, which gets all that it needs

    Raises DesignError for a first-order winch, for a horizon that the delay fills, and for one that does not fit.

    Attributes
    ----------
    basis : of the correction, shape (ticks, m)
    rows : the limits as rows of the plan
    plan : correction that is followed, shape (m,)
    last : command of the last plan, but for its value
    use : what is wanted of a preview; None: none is used
    """

    def __init__(self, design: LawDesign, parameters: MpcParameters, core: Law) -> None:
        model, winch = design.model, design.winch
        if "payout_acceleration" not in model.output_names:
            raise DesignError("law mpc bounds the winch's acceleration: set winch.law to speed_servo")
        assert model.dt is not None
        gains = design.own_gains or own_gains(model, parameters)
        self._constrained, self._free_less_constrained = gains["constrained"], gains["free"] - gains["constrained"]
        standing = drum_ahead(model, winch)[1] + standing_command(model, winch)
        self._solve_ticks = parameters.solve_ticks
        horizon_ticks = round(parameters.horizon / model.dt)
        command = model.input_names[0]
        delay = sum(name.startswith(command + "_") for name in model.state_names)
        if delay >= horizon_ticks:
            raise DesignError(
                f"mpc.horizon = {parameters.horizon:g} s must be longer than the command delay ({delay * model.dt:g} s)"
            )
        self.basis = hat_functions(correction_knots(parameters.horizon, model.dt), horizon_ticks)
        disturbances = self._prepare_preview(model, parameters)
        plan = Planned(self._constrained, self.basis, disturbances, self._fed, standing, delay)
        self.rows = PlanRows(model, winch, plan)
        self._solver = PlanSolver(
            self.basis,
            self.rows.forced,
            tick_period=model.dt,
            iteration_limit=parameters.iteration_limit,
            softness=parameters.softness,
        )
        self._core = core
        self._tell_core(standing, math.exp(-model.dt * parameters.solve_ticks / max(parameters.release_time, 1e-9)))
        self.restart()

    def _tell_core(self, standing: Array, kept: float) -> None:
        """Tell the core all of a plan: the row `standing`, and what is `kept` of a step of the gain, too."""
        free = self.rows.free
        if len(free) > PLAN_ROWS or free.size > PLAN_NUMBERS:
            raise DesignError(
                f"mpc.horizon makes a plan of {len(free)} rows of {free.shape[1]} states: {PLAN_ROWS} rows and "
                f"{PLAN_NUMBERS} numbers fit; shorten it"
            )
        put(
            self._core.law,
            {
                "constrained": self._constrained,
                "free_less_constrained": self._free_less_constrained,
                "kept": kept,
                "standing": standing,
                "spared": SPARED,
                "solve_ticks": self._solve_ticks,
                "ends": [kind.rows.stop for kind in self.rows.kinds],
                "times": self.rows.kinds[RowKind.PLANNED_PAYOUT].times,
                "rows": free.T.ravel(),
            },
        )

    def _prepare_preview(self, model: LinearModel, parameters: MpcParameters) -> Array:
        """Make what a preview needs and return what it adds to the state; without one all of it has no columns."""
        self._reader: PreviewReader | None = None
        self.use: PreviewUse | None = None
        self._fed = np.zeros((0, 0))
        if parameters.preview_time < STEP:
            return np.zeros((0, model.order, 0))
        self._reader = PreviewReader(model, parameters.preview_time, parameters.preview_noise)
        disturbances, self.use = self._reader.disturbances, self._reader.use

        def fed(gain: Array, acceleration: float, command: float) -> Array:
            return feedforward(model, gain, _sizes(model, parameters, acceleration), command, disturbances)

        free = self._constrained + self._free_less_constrained
        self._fed = fed(self._constrained, parameters.payout_acceleration, parameters.command)
        now = fed(free, parameters.free_payout_acceleration, parameters.free_command)[0]
        self._free_less_constrained_feed = now - self._fed[0]
        return disturbances

    def prepare(self) -> None:
        """Make ready, between two ticks, what `restart` takes."""
        self._solver.prepare()

    def restart(self) -> None:
        """Discard the plan and the solver's warm start."""
        self._solver.restart()
        self.plan = np.zeros(self.basis.shape[1])
        self.last = LawCommand(0.0, "no solution yet")
        self._gain, self._freedom = np.zeros(0), math.nan

    @property
    def gain(self) -> Array:
        """The active gain, shape (n,): between that of the plan and that away from the limits."""
        freedom = float(self._core.state["freedom"][0])
        if freedom != self._freedom:
            self._freedom, self._gain = freedom, self._constrained + freedom * self._free_less_constrained
        return self._gain

    def see(self, preview: HeavePreview | None, x: Array) -> None:
        """Take in a `preview` of the boom tip, where one is used and given, beside the state `x`, shape (n,)."""
        if self._reader is None:
            return
        innovation = self._reader.innovation(preview, x)
        if innovation is None:
            put(self._core.state, {"seen_now": 0.0, "seen_free": 0.0, "seen": np.zeros(len(self.rows.forced))})
            return
        seen_now, seen_free = float(self._fed[0] @ innovation), float(self._free_less_constrained_feed @ innovation)
        put(
            self._core.state,
            {"seen_now": seen_now, "seen_free": seen_free, "seen": self.rows.previewed @ innovation},
        )

    def bounds(self) -> tuple[Array, Array]:
        """Return lower and upper bounds of the rows as the core has found them, shape (r,) each."""
        count, memory = len(self.rows.forced), self._core.state[0]
        lower, upper = (np.clip(memory[name][:count], -UNBOUNDED, UNBOUNDED) for name in ("lower", "upper"))
        return lower, upper

    def plan_again(self) -> LawCommand:
        """Solve, for what the core has found, and have it followed; return the command but for its value."""
        memory = self._core.state[0]
        free = memory["planned"][: len(self.rows.forced)].copy()
        lower, upper = self.bounds()
        plan, iterations = self._solver.solve(lower - free, upper - free)
        if plan is not None:
            self.plan, age = plan, 0
            planned = free + self.rows.forced @ plan
            winch = self._core.winch[0]
            active = self.rows.active(planned, lower, upper, speed=float(winch["speed"]), power=float(winch["power"]))
            self.last = LawCommand(0.0, "solved", iterations, active)
        else:
            self.plan = self.plan if memory["has_plan"] else np.zeros(self.basis.shape[1])
            age = int(memory["plan_age"]) + 1
            status = f"not solved in {iterations} iterations: following the plan of {age} ticks ago"
            self.last = LawCommand(0.0, status, iterations, self.last.active)
        ahead = self.basis[age : age + FOLLOWED] @ self.plan
        memory["has_plan"], memory["plan_age"] = 1, age
        memory["correction"][:] = 0.0
        memory["correction"][: len(ahead)] = ahead
        return self.last


class ConstrainedLaw(CoreLaw):
    """MPC with limits on winch speed, acceleration, power, payout and tension.

    Parameters
    ----------
    design : what the law is made for; its winch is a speed servo
    parameters : horizon, ticks between solutions, caps, cost

    Raises DesignError for a first-order winch and for a horizon that the delay fills.

    Attributes
    ----------
    gain : the active one, shape (n,): between that of the plan and that away from the limits
    """

    name: ClassVar[str] = "mpc"
    summary: ClassVar[str] = "feedback of all states with the limits as constraints"
    parameters_type: ClassVar[type | None] = MpcParameters
    keeps_limits = True
    gain_names: ClassVar[tuple[str, ...]] = ("constrained", "free")

    def __init__(self, design: LawDesign, parameters: MpcParameters) -> None:
        super().__init__(design, LawKind.CONSTRAINED_LAW)
        self.planner: Planner = Planner(design, parameters, self.core)
        self.preview, self.gain = self.planner.use, self.planner.gain

    @classmethod
    def own_gains(cls, design: LawDesign, parameters: MpcParameters) -> dict[str, Array]:
        """Return the gains of plans at the limits and away from them, for a `design` and `parameters`."""
        return own_gains(design.model, parameters)

    def commanded(self, value: float, *, by_plan: float, has_plan: float) -> LawCommand:
        """See CoreLaw; the gain goes from that of a plan to the free one."""
        self.gain = self.planner.gain
        return super().commanded(value, by_plan=by_plan, has_plan=has_plan)

    def planned(self) -> LawCommand:
        """See CoreLaw."""
        found = super().planned()
        self.gain = self.planner.gain
        return found

    def reset(self) -> None:
        """Start again."""
        super().reset()
        self.gain = self.planner.gain
