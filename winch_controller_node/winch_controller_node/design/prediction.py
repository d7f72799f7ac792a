"""What a design promises: stationary standard deviations of the LQG loop with its sensors, their rates and delays.

The filter's covariance is carried through one period of the sensors' pattern until it repeats; readings that come late
are modelled by past values as states, so that nothing is approximated. With P the covariance of the error and X that
of the estimate, the state has P + X, and X[k+1] = (A - B G) X[k] (A - B G)' + (P before - P after the readings of
k+1).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel, with_feedback

from winch_controller_node.design.design import ControllerDesign
from winch_controller_node.model.estimator import MeasurementModel
from winch_controller_node.model.lqr import DesignError, output_cost
from winch_controller_node.model.regulator import full_gain, is_sensor_state

LONGEST_PATTERN = 240
"""Ticks after which the pattern of all sensors must repeat."""

SETTLED = 1e-9
"""Relative change of a covariance over a pattern at which it counts as stationary."""

PERIODS_TO_SETTLE = 40_000
"""Ticks after which a covariance that still changes is a design that cannot be predicted."""


ErrorCovariances = list[tuple[Array, Array]]
"""Covariance of the estimate's error before and after the readings, for each tick of the sensors' pattern."""


@dataclass(frozen=True)
class LoopPrediction:
    """Stationary behaviour of a loop in its linear regime."""

    sigma: dict[str, float]  # standard deviation of each output of the model
    command_sigma: float  # standard deviation of the command, in its unit
    estimate_error: dict[str, float]  # standard deviation of the error of each state's estimate, by name


def predicted_covariance(P: Array, F: Array, Q: Array) -> Array:
    """Return the covariance a step ahead, F P F' + Q, shape (n, n)."""
    return np.asarray(F @ P @ F.T + Q)


def filter_gain(P: Array, H: Array, variances: Array) -> Array:
    """Return the gain K = P H' (H P H' + R)^-1, shape (n, m), for readings of rows H (m, n), R = diag(variances)."""
    across = H @ P
    return np.asarray(np.linalg.solve(across @ H.T + np.diag(variances), across).T)


def corrected_covariance(P: Array, K: Array, H: Array, variances: Array) -> Array:
    """Return the covariance after readings, (I - K H) P (I - K H)' + K R K' (Joseph's form), R = diag(variances)."""
    rest = np.eye(len(P)) - K @ H
    P = rest @ P @ rest.T + K * variances @ K.T
    return np.asarray(0.5 * (P + P.T))


def sensor_periods(design: ControllerDesign) -> dict[str, tuple[int, int]]:
    """Return the period and the age at arrival of the readings of each sensor of `design` [ticks]."""
    dt = design.tick_period
    return {
        name: (max(1, round(sensor.period(dt) / dt)), round(sensor.age() / dt))
        for name, sensor in design.parameters.sensors.by_name().items()
    }


@dataclass(frozen=True, eq=False)
class FilterModel:
    """The model with past values of late measurements as states, and the rows measured at each tick of the pattern."""

    A: Array  # transition over a tick, past values among the states, shape (n, n)
    Q: Array  # covariance of the process noise of a tick, shape (n, n)
    rows: list[Array]  # of the readings at each tick of the pattern, shape (m, n)
    variances: list[Array]  # of their noise, shape (m,)
    names: list[list[str]]  # of their measurements


def error_covariances(design: ControllerDesign) -> ErrorCovariances:
    """Return the covariances of the estimate's error for each tick of the sensors' pattern, before and after readings.

    Covers the states of `design.model`; MRU scale and lever arm are taken as known.

    Raises DesignError where it does not settle.
    """
    model = design.model
    past = filter_model(design)
    n = len(past.A)
    P = np.zeros((n, n))
    P[: model.order, : model.order] = design.initial_covariance
    pattern = len(past.rows)
    previous = np.inf
    for _ in range(0, PERIODS_TO_SETTLE, pattern):
        pairs = []
        for rows, variances in zip(past.rows, past.variances, strict=True):
            prior = predicted_covariance(P, past.A, past.Q)
            P = _corrected(prior, rows, variances)
            pairs.append((prior[: model.order, : model.order], P[: model.order, : model.order]))
        level = _seen(design.model, P)
        if abs(level - previous) < SETTLED * level:
            return pairs
        previous = level
    raise DesignError("the covariance of the estimate does not converge: the sensors do not determine the state")


def _seen(model: LinearModel, P: Array) -> float:
    """Return the sum of the outputs' standard deviations under a covariance of the error.

    Waves have states that no output shows, because the sea's filter has its zeros at the origin; their covariance
    settles as slowly as one over time, and matters to nobody.
    """
    n = model.order
    variances = np.einsum("ij,jk,ik->i", model.C, P[:n, :n], model.C)
    return float(np.sum(np.sqrt(np.maximum(variances, 0.0))))


def _corrected(P: Array, rows: Array, variances: Array) -> Array:
    """Return the covariance after readings of `rows`; there may be none."""
    return corrected_covariance(P, filter_gain(P, rows, variances), rows, variances) if len(rows) else P


def filter_model(design: ControllerDesign, *, every_tick: bool = False) -> FilterModel:
    """Return the filter of a `design` as the pattern of its sensors repeats; `every_tick`: all of them at the tick."""
    model = design.model
    periods = sensor_periods(design)
    known = [m for m in design.measurements if np.any(m.row)]
    pattern = 1 if every_tick else math.lcm(*[periods[m.sensor][0] for m in known])
    if pattern > LONGEST_PATTERN:
        raise DesignError(
            f"the pattern of the sensors repeats only after {pattern} ticks, and at most {LONGEST_PATTERN} can be "
            "predicted: choose rates that are multiples of one another"
        )
    A, Q = model.A, model.noise_covariance
    rows: list[tuple[Array, MeasurementModel]] = []
    for measurement in known:
        age = periods[measurement.sensor][1]
        A, Q, row = _with_past(A, Q, measurement.row, age)
        rows.append((row, measurement))
    n = len(A)
    padded = [(np.pad(row, (0, n - len(row))), m) for row, m in rows]
    by_tick = [
        [(r, m) for r, m in padded if every_tick or tick % periods[m.sensor][0] == 0] for tick in range(1, pattern + 1)
    ]
    return FilterModel(
        np.ascontiguousarray(A),
        np.ascontiguousarray(Q),
        [np.array([row for row, _ in due]).reshape(-1, n) for due in by_tick],
        [np.array([m.sigma**2 for _, m in due]) for due in by_tick],
        [[m.name for _, m in due] for due in by_tick],
    )


def _with_past(A: Array, Q: Array, row: Array, age: int) -> tuple[Array, Array, Array]:
    """Append the last `age` values of row x as states; return the row of the oldest."""
    n = len(A)
    row = np.pad(row, (0, n - len(row)))
    if age == 0:
        return A, Q, row
    longer = np.zeros((n + age, n + age))
    longer[:n, :n] = A
    longer[n, :n] = row
    for i in range(1, age):
        longer[n + i, n + i - 1] = 1.0
    oldest = np.zeros(n + age)
    oldest[-1] = 1.0
    return longer, np.pad(Q, ((0, age), (0, age))), oldest


@dataclass(frozen=True, eq=False)
class EquivalentFilter:
    """A stationary Kalman filter at the tick: x = A x + B u, then x += K (y - H x).

    Past values of late readings are states.
    """

    A: Array
    H: Array
    K: Array


def equivalent_filter(design: ControllerDesign) -> EquivalentFilter:
    """Return the stationary filter of `design` with slow sensors replaced by ones at the tick.

    They tell as much per second.
    """
    periods = sensor_periods(design)
    model = filter_model(design, every_tick=True)
    n = design.model.order
    P = np.zeros_like(model.A)
    P[:n, :n] = design.initial_covariance
    H = model.rows[0]
    known = [m for m in design.measurements if np.any(m.row)]
    variances = np.array([m.sigma**2 * periods[m.sensor][0] for m in known])
    previous = np.inf
    for _ in range(PERIODS_TO_SETTLE):
        prior = predicted_covariance(P, model.A, model.Q)
        P = _corrected(prior, H, variances)
        level = _seen(design.model, P)
        if abs(level - previous) < SETTLED * level:
            return EquivalentFilter(model.A, H, filter_gain(prior, H, variances))
        previous = level
    raise DesignError("the covariance of the estimate does not converge: the sensors do not determine the state")


def predict_loop(
    design: ControllerDesign, gain: Array | None = None, errors: ErrorCovariances | None = None
) -> LoopPrediction:
    """Return the stationary standard deviations under u = -gain (estimate).

    Sigmas are root mean squares over the ticks of the sensors' pattern.

    Parameters
    ----------
    design : of estimator and model
    gain : shape (n,); None: that of the design
    errors : `error_covariances(design)`, to save their computation; None: they are computed

    Raises DesignError where covariance or loop is not stable.
    """
    gain = design.gain if gain is None else gain
    pairs = error_covariances(design) if errors is None else errors
    keep = [i for i, name in enumerate(design.model.state_names) if not is_sensor_state(name)]
    plant = design.model.select_states([design.model.state_names[i] for i in keep])
    closed = with_feedback(plant, gain[None, keep])
    estimates = _estimate_covariances(closed.A, [(before - after)[np.ix_(keep, keep)] for before, after in pairs])
    remaining = [after[np.ix_(keep, keep)] for _, after in pairs]
    variances = np.mean(
        [_output_variances(plant, closed, P, X) for P, X in zip(remaining, estimates, strict=True)], axis=0
    )
    command = np.mean([gain[keep] @ X @ gain[keep] for X in estimates])
    error = np.sqrt(np.mean([np.diag(after) for _, after in pairs], axis=0))
    return LoopPrediction(
        sigma=dict(zip(plant.output_names, np.sqrt(np.maximum(variances, 0.0)).tolist(), strict=True)),
        command_sigma=float(np.sqrt(command)),
        estimate_error=dict(zip(design.model.state_names, error.tolist(), strict=True)),
    )


def _estimate_covariances(closed: Array, corrections: list[Array]) -> list[Array]:
    """Return the stationary covariance of the estimate after the readings of each tick of the pattern."""
    if np.max(np.abs(np.linalg.eigvals(closed))) >= 1.0:
        raise DesignError("the closed loop of this gain is not stable: nothing can be predicted for it")
    whole, noise = np.eye(len(closed)), np.zeros_like(closed)
    for correction in corrections:
        whole = closed @ whole
        noise = closed @ noise @ closed.T + correction
    X = scipy.linalg.solve_discrete_lyapunov(whole, noise)
    covariances = []
    for correction in corrections:
        X = closed @ X @ closed.T + correction
        covariances.append(X)
    return covariances


def _output_variances(plant: LinearModel, closed: LinearModel, P: Array, X: Array) -> Array:
    """Variance of y = C x + D u = C (x - estimate) + (C - D G) estimate; error and estimate are independent."""
    variances: Array = np.einsum("ij,jk,ik->i", plant.C, P, plant.C) + np.einsum("ij,jk,ik->i", closed.C, X, closed.C)
    return variances


def estimation_bound(design: ControllerDesign, errors: ErrorCovariances | None = None) -> float:
    """Return s_est [m]: the least unit sigma any controller reaches with these sensors and delay, without limits.

    It is the LQG optimum for unit heave alone, the command being free (its weight as small as numbers allow).
    `errors` are `error_covariances(design)`, to save their computation.
    """
    errors = error_covariances(design) if errors is None else errors
    best = math.inf
    for command_size in (1e3, 1e4, 1e5):
        cost = output_cost(design.model, {"unit_heave": 0.01, "payout": 1e4}, command_size)
        try:
            best = min(best, predict_loop(design, full_gain(design.model, cost), errors).sigma["unit_heave"])
        except DesignError:
            break
    if not math.isfinite(best):
        raise DesignError("the estimation bound has no solution for this model")
    return best
