"""Linear-quadratic regulators: cost by outputs, gains by a Riccati equation, and what has no solution is refused."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel, is_stable, with_feedback

PBH_TOLERANCE = 1e-9
"""Relative size below which a singular value of a rank test counts as zero."""


class DesignError(ValueError):
    """A controller that cannot be designed; the message says why and what to change."""


@dataclass(frozen=True, eq=False)
class QuadraticCost:
    """Time average of x' Q x + 2 x' N u + u' R u.

    Thesis Eq. 6.29 as an average: its integral is infinite under noise.
    """

    Q: Array  # shape (n, n)
    N: Array  # shape (n, m)
    R: Array  # shape (m, m)


def output_cost(model: LinearModel, sizes: Mapping[str, float], command_size: float) -> QuadraticCost:
    """Return the cost sum (y_i / size_i)^2 + (u / command_size)^2 over the outputs of `model` in `sizes` [their unit].

    A size of 0 leaves an output out.

    Raises DesignError for a command size that is not positive, or when no output is weighed: the cost is singular then.
    """
    if not command_size > 0.0:
        raise DesignError("weights.command must be above 0: without a weight on the command the cost is singular")
    weighed = {name: size for name, size in sizes.items() if size > 0.0}
    if not weighed:
        raise DesignError("no output has a weight: give weights.unit_heave or another one a size above 0")
    rows = np.array([model.row(name) / size for name, size in weighed.items()])
    through = np.array([model.D[model.output_names.index(name)] / size for name, size in weighed.items()])
    R = through.T @ through + np.eye(len(model.input_names)) / command_size**2
    return QuadraticCost(rows.T @ rows, rows.T @ through, R)


def lqr_gain(model: LinearModel, cost: QuadraticCost) -> Array:
    """Return the gain G of u = -G x, shape (m, n), that minimises `cost`.

    Thesis Eq. 6.10 with the signs of its figures. Continuous or discrete by `model.dt`.

    Raises
    ------
    DesignError : singular or indefinite weights, a model that no command can stabilise, a growing state without weight
    """
    _check_weights(cost)
    check_stabilisable(model)
    check_seen_by_cost(model, cost)
    A, B = model.A, model.B
    try:
        if model.dt is None:
            X = scipy.linalg.solve_continuous_are(A, B, cost.Q, cost.R, s=cost.N)
            gain = np.linalg.solve(cost.R, B.T @ X + cost.N.T)
        else:
            X = scipy.linalg.solve_discrete_are(A, B, cost.Q, cost.R, s=cost.N)
            gain = np.linalg.solve(cost.R + B.T @ X @ B, B.T @ X @ A + cost.N.T)
    except (np.linalg.LinAlgError, ValueError) as error:
        raise DesignError(f"the Riccati equation has no solution for these weights: {error}") from error
    if not (np.all(np.isfinite(gain)) and is_stable(with_feedback(model, gain))):
        raise DesignError(
            "the Riccati equation gave no stabilising gain: decrease weights.command or increase the others"
        )
    return gain


def _check_weights(cost: QuadraticCost) -> None:
    whole = np.block([[cost.Q, cost.N], [cost.N.T, cost.R]])
    size = np.sqrt(np.maximum(np.diag(whole), 1e-300))
    if np.linalg.eigvalsh(whole / np.outer(size, size)).min() < -1e-9:
        raise DesignError("the weights are indefinite: no quadratic cost may be negative")
    if np.linalg.eigvalsh(cost.R).min() <= 0.0:
        raise DesignError("the weight on the command is singular: it must be above 0")


def check_stabilisable(model: LinearModel) -> None:
    """Raise DesignError where the command does not reach a mode of `model` that does not decay (PBH test).

    The message names its states.
    """
    lost = unreachable_modes(model.A, model.B, discrete=model.dt is not None)
    if lost is not None:
        raise DesignError(
            f"the model is not stabilisable: the command has no effect on {_names(model, lost)}, which does not decay "
            "by itself"
        )


def check_detectable(model: LinearModel, rows: Array, sensors: Sequence[str]) -> None:
    """Raise DesignError, naming the states, where no measurement shows a mode that does not decay (PBH test).

    Parameters
    ----------
    model : whose modes they are
    rows : shape (p, n), what is measured
    sensors : names of the sensors in use, for the message
    """
    lost = unreachable_modes(model.A.T, rows.T, discrete=model.dt is not None)
    if lost is not None:
        raise DesignError(
            f"the model is not detectable with the sensors {', '.join(sensors) or '(none)'}: "
            f"{_names(model, lost)} cannot be observed and does not decay by itself: add a sensor, or leave it out"
        )


def check_seen_by_cost(model: LinearModel, cost: QuadraticCost) -> None:
    """Raise DesignError where `cost` gives no weight to a mode of `model` that does not decay.

    The optimum would leave it alone.
    """
    lost = unreachable_modes(model.A.T, cost.Q, discrete=model.dt is not None)
    if lost is not None:
        raise DesignError(
            f"the weights leave {_names(model, lost)} free, which does not decay by itself: give it a weight "
            "(weights.payout)"
        )


def unreachable_modes(A: Array, B: Array, *, discrete: bool) -> Array | None:
    """Return the direction of a mode that does not decay and is out of reach of B, shape (n,), or None.

    Popov-Belevitch-Hautus: w' [A - lambda I, B] = 0 with w not 0 for such a mode. `discrete` : A is that of a step.
    """
    columns = np.linalg.norm(B, axis=0)
    reach = B / np.where(columns > 0.0, columns, 1.0)
    for value in np.linalg.eigvals(A):
        decays = abs(value) < 1.0 - 1e-9 if discrete else value.real < -1e-9
        if decays:
            continue
        test = np.hstack([A - value * np.eye(len(A)), reach])
        left, singular, _ = np.linalg.svd(test, full_matrices=False)
        if singular[-1] <= PBH_TOLERANCE * max(singular[0], 1.0):
            return np.asarray(np.abs(left[:, -1]))
    return None


def _names(model: LinearModel, direction: Array) -> str:
    largest = direction > 0.3 * direction.max()
    return " and ".join(name for name, is_part in zip(model.state_names, largest, strict=True) if is_part)
