"""The drum that explains a record best: a Gauss-Newton fit of what is free, with a prior about the nominal one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from heave_core.watch import NO_POWER_LIMIT, Drum
from heave_node.numerics.arrays import Array

from winch_controller_node.adviser.drum.drum_record import FIELDS, START_PAYOUT, START_RATE, DrumRecord
from winch_controller_node.beliefs.drum import QUANTITY_OF, drum_of
from winch_controller_node.beliefs.quantities import ENCODER_SCALE, range_of
from winch_controller_node.node_parameters import WinchControllerParameters

LAG, DELAY, GAIN, DEADBAND, BACKLASH, HAULING, CREEP = (
    Drum._fields.index(name) for name in ("lag", "delay", "gain", "deadband", "backlash", "hauling", "creep")
)
SPEED_OUT, SPEED_IN, ACCELERATION_OUT, ACCELERATION_IN, POWER = LIMITS = tuple(
    Drum._fields.index(name) for name in ("speed_out", "speed_in", "acceleration_out", "acceleration_in", "power")
)


FLOOR = 1e-3
"""Least standard deviation of what is left [m]: no drum is known better, and an encoder reads in millimetres."""

ITERATIONS, CONVERGED = 12, 1e-4
"""Largest number of Gauss-Newton steps; they end with a step of every parameter below the second."""

DIFFERENCE = 1e-4
"""Step of the sensitivities; of a power relative."""

SINGULAR = 1e-15
"""Share of the largest eigenvalue of an information matrix below which one is none."""

SHARES_OF_STEP = (1.0, 0.5, 0.25, 0.1, 0.03)
"""Shares of a Gauss-Newton step of which the best is taken."""


@dataclass(frozen=True, eq=False)
class DrumPrior:
    """What is known of a drum before it has moved: fields of `Drum` and the factor, shape (FIELDS + 1,) each."""

    nominal: Array  # the nominal drum
    sigmas: Array  # how sure that is, 1 sigma
    lowest: Array  # lowest values that can be at all
    highest: Array  # highest values that can be at all


@dataclass(frozen=True, eq=False)
class DrumFit:
    """A drum."""

    theta: Array  # shape (FIELDS + 3,)
    squares: float  # sum of squared residuals [m^2]
    count: int  # of them
    record: DrumRecord = field(repr=False)  # it was found in
    free: tuple[int, ...]  # what was found
    sigmas: Array  # standard deviation of each of `free`
    prior: float  # how unlikely that is [nats]

    @property
    def residual(self) -> float:
        """Standard deviation of what is left [m]."""
        return math.sqrt(self.squares / max(self.count, 1))

    @property
    def loss(self) -> float:
        """Of the record, the noise profiled out, one independent value a second, and of the prior [nats]."""
        return self.record.duration * math.log(math.hypot(self.residual, FLOOR) / FLOOR) + self.prior


def fit_drum(
    record: DrumRecord, prior: DrumPrior, start: Array, free: Sequence[int], *, enough: float = 0.0
) -> DrumFit:
    """Return the drum that fits a record best; payout and rate at the start of it are always found.

    Parameters
    ----------
    record, prior : what was read, and what can be
    start : theta at which it begins, shape (FIELDS + 3,)
    free : places of theta that are found; the others stay
    enough : residual below which no better fit is looked for [m]
    """
    theta = start.copy()
    columns = [*free, START_PAYOUT, START_RATE]
    lowest = np.concatenate([prior.lowest, [-np.inf, -np.inf]])
    highest = np.concatenate([prior.highest, [np.inf, np.inf]])
    nominal = np.concatenate([prior.nominal, [0.0, 0.0]])
    sigmas = np.concatenate([prior.sigmas, [np.inf, 2.0]])
    nominal, sigmas = nominal[columns], sigmas[columns]
    count = int(np.count_nonzero(record.seen))
    # readings in a row that are off are not independent
    per_second = count / max(record.duration, record.dt)
    information = np.eye(len(columns))
    for _ in range(ITERATIONS):
        residual, slopes = linearised(record, theta, columns)
        squares = float(residual @ residual)
        weight = 1.0 / (per_second * (squares / count + FLOOR**2))
        precision = _precision(theta[columns] - nominal, sigmas)
        information = weight * slopes.T @ slopes + np.diag(precision)
        pull = weight * slopes.T @ residual + precision * (nominal - theta[columns])
        step = _solved(information, pull)
        blocked = ((theta[columns] <= lowest[columns]) & (step < 0.0)) | (
            (theta[columns] >= highest[columns]) & (step > 0.0)
        )
        if np.any(blocked):
            # what cannot go further must not shape the step of the others
            step[blocked] = 0.0
            step[~blocked] = _solved(information[np.ix_(~blocked, ~blocked)], pull[~blocked])
        trials = np.repeat(theta[None, :], len(SHARES_OF_STEP), axis=0)
        trials[:, columns] += np.outer(SHARES_OF_STEP, step)
        trials = np.minimum(np.maximum(trials, lowest), highest)
        costs = 0.5 * weight * np.sum(np.square(record.residuals(trials)), axis=1)
        costs += _improbability(trials[:, columns] - nominal, sigmas)
        before = 0.5 * weight * squares + float(_improbability(theta[columns] - nominal, sigmas))
        best = int(np.argmin(costs))
        if costs[best] >= before:
            break
        moved = float(np.max(np.abs(trials[best] - theta) / _sizes(theta)))
        theta = trials[best]
        # no step makes it worse than this, what it gains by a likelier drum included
        if moved < CONVERGED or 2.0 * costs[best] < weight * count * enough**2:
            break
    squares = float(np.sum(np.square(record.residuals(theta[None, :]))))
    spread = np.sqrt(np.abs(np.diag(_inverse(information)))) if free else np.zeros(0)
    unlikely = float(_improbability(theta[:FIELDS] - prior.nominal[:FIELDS], prior.sigmas[:FIELDS]))
    return DrumFit(theta, squares, count, record, tuple(free), spread[: len(free)], unlikely)


def _improbability(off: Array, sigmas: Array) -> Array:
    """Return log(1 + z^2/2) of what is `off` by z sigmas, summed over the last axis [nats].

    Near nominal it is a normal distribution's; but what is far off is seldom, not impossible: a servo may be ten times
    as slow as stated.
    """
    return np.asarray(np.sum(np.log1p(0.5 * np.square(off / sigmas)), axis=-1))


def _precision(off: Array, sigmas: Array) -> Array:
    """Return the weights of squares that have its slope there: of reweighted least squares."""
    return np.asarray(1.0 / (np.square(sigmas) * (1.0 + 0.5 * np.square(off / sigmas))))


def _solved(information: Array, pull: Array) -> Array:
    """Return the step of an information matrix, which may be singular."""
    size = np.sqrt(np.diag(information)) + 1e-12
    return np.asarray(_inverse(information / np.outer(size, size)) @ (pull / size) / size)


def _inverse(matrix: Array) -> Array:
    """Return the pseudo-inverse of a symmetric `matrix`: numpy's `pinv` to the bit, in half its time."""
    values, vectors = np.linalg.eigh(matrix)
    sizes = np.abs(values)
    order = np.argsort(sizes)[::-1]
    vectors, sizes = vectors[:, order], sizes[order]
    inverse = np.divide(1.0, sizes, where=sizes > SINGULAR * sizes[0], out=np.zeros(len(sizes)))
    return np.asarray((vectors * np.sign(values[order])) @ (inverse[:, None] * vectors.T))


def _sizes(theta: Array) -> Array:
    """Return what a step of each place of `theta` is to be compared with: a power with itself."""
    sizes = np.ones(len(theta))
    sizes[POWER] = theta[POWER]
    return sizes


def linearised(record: DrumRecord, theta: Array, columns: Sequence[int]) -> tuple[Array, Array]:
    """Return what `theta` leaves of a `record`, (count,), and how it falls with each of `columns`, (count, columns)."""
    steps = np.array([-DIFFERENCE if column in LIMITS else DIFFERENCE for column in columns]) * _sizes(theta)[columns]
    thetas = np.repeat(theta[None, :], len(columns) + 1, axis=0)
    thetas[np.arange(1, len(thetas)), list(columns)] += steps
    left = record.residuals(thetas)
    return left[0], ((left[0] - left[1:]) / steps[:, None]).T


SIGMAS = Drum(0.05, 0.1, 0.2, 0.02, np.inf, np.inf, np.inf, np.inf, 0.005, np.inf, 0.2, 0.05, np.inf)
"""Prior standard deviation of each quantity of the drum about nominal; infinite for limits, which are unknown."""

LEAST_POWER = 1.0
"""Least power limit of a winch [W]."""


def prior_of(parameters: WinchControllerParameters) -> DrumPrior:
    """Return the prior of a drum like that of the `parameters`: what can be is the range of each quantity."""
    nominal = drum_of(parameters.winch)
    ranges = {name: range_of(quantity, parameters) for name, quantity in QUANTITY_OF.items()}
    lowest = nominal._replace(**{name: lowest for name, (lowest, _) in ranges.items()})
    highest = nominal._replace(**{name: min(highest, NO_POWER_LIMIT) for name, (_, highest) in ranges.items()})
    lowest = lowest._replace(power=max(lowest.power, LEAST_POWER))
    factors = range_of(ENCODER_SCALE, parameters)
    return DrumPrior(
        _with_factor(nominal, 1.0),
        _with_factor(SIGMAS, np.inf),
        _with_factor(lowest, factors[0]),
        _with_factor(highest, factors[1]),
    )


def _with_factor(drum: Drum, factor: float) -> Array:
    return np.array([*drum, factor], dtype=float)
