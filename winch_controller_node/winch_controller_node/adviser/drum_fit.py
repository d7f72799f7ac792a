"""The drum that explains a record: a Gauss-Newton fit with a prior about the nominal one, freed group by group.

Lag, delay and gain are always free. A limit, a dead zone, play, another gain of hauling in, or another factor of the
encoder is freed only where the record is likelier by more than its price, and dropped again where it is a passenger.
A limit has no slope where it is not reached: each is begun at the largest speed or acceleration that was read.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from heave_node.numerics.arrays import Array

from winch_controller_node.adviser.drum_record import FACTOR, FIELDS, START_PAYOUT, START_RATE, DrumRecord
from winch_controller_node.model.drum_kernel import Drum

LAG, DELAY, GAIN, DEADBAND, BACKLASH, HAULING, CREEP = (
    Drum._fields.index(name) for name in ("lag", "delay", "gain", "deadband", "backlash", "hauling", "creep")
)
SPEED_OUT, SPEED_IN, ACCELERATION_OUT, ACCELERATION_IN = LIMITS = tuple(
    Drum._fields.index(name) for name in ("speed_out", "speed_in", "acceleration_out", "acceleration_in")
)

ALWAYS = (LAG, DELAY, GAIN)

PRICES: dict[tuple[int, ...], float] = {
    **{(index,): 12.0 for index in LIMITS},
    (SPEED_OUT, SPEED_IN): 12.0,
    (ACCELERATION_OUT, ACCELERATION_IN): 12.0,
    (DEADBAND,): 6.0,
    (BACKLASH,): 6.0,
    (HAULING, CREEP): 6.0,
    (FACTOR,): 16.0,
}
"""What it costs to free a group [nats]."""

HELD = 3.0
"""What it costs to move a limit that is believed already, and what a record must say against one to drop it [nats]."""

FLOOR = 1e-3
"""Least standard deviation of what is left [m]: no drum is known better, and an encoder reads in millimetres."""

ITERATIONS, CONVERGED = 12, 1e-4
"""Largest number of Gauss-Newton steps; they end with a step of every parameter below the second."""

DIFFERENCE = 1e-4
"""Step of the sensitivities."""

SHARES_OF_STEP = (1.0, 0.5, 0.25, 0.1, 0.03)
"""Shares of a Gauss-Newton step of which the best is taken."""

SHOWN_OVER = 0.3
"""Time over which speeds are taken that a drum has shown [s]."""

LAGS = (0.4, 1.0, 2.5, 6.0)
"""Lags over the believed one at which a fit is begun again where much is left."""

UNEXPLAINED = 4e-3
"""Standard deviation that is much [m]."""

LEAST_BEFORE = 1.0
"""Time before a sudden change of the encoder that must be on record [s]: only then is it sudden."""

ROUNDS = 5
"""Largest number of groups that are freed."""


@dataclass(frozen=True)
class DrumPrior:
    """What is known of a drum before it has moved: fields of `Drum` and the factor, shape (FIELDS + 1,) each.

    Attributes
    ----------
    nominal, sigmas, lowest, highest : the nominal one, how sure that is, and what can be at all
    """

    nominal: Array
    sigmas: Array
    lowest: Array
    highest: Array


@dataclass(frozen=True)
class DrumFit:
    """A drum.

    Attributes
    ----------
    theta : shape (FIELDS + 3,)
    squares : sum of squared residuals [m^2]; count : of them
    record : it was found in
    free : what was found
    sigmas : standard deviation of each of `free`
    prior : (theta - nominal)^2 / sigma^2 / 2, summed [nats]
    """

    theta: Array
    squares: float
    count: int
    record: DrumRecord = field(repr=False)
    free: tuple[int, ...]
    sigmas: Array
    prior: float

    @property
    def residual(self) -> float:
        """Standard deviation of what is left [m]."""
        return math.sqrt(self.squares / max(self.count, 1))

    @property
    def loss(self) -> float:
        """Of the record, the noise profiled out, one independent value a second, and of the prior [nats]."""
        return self.record.duration * math.log(math.hypot(self.residual, FLOOR) / FLOOR) + self.prior


def fit_drum(record: DrumRecord, prior: DrumPrior, start: Array, free: Sequence[int]) -> DrumFit:
    """Return the drum that fits a record best; payout and rate at the start of it are always found.

    Parameters
    ----------
    record, prior : what was read, and what can be
    start : theta at which it begins, shape (FIELDS + 3,)
    free : places of theta that are found; the others stay
    """
    theta = start.copy()
    columns = [*free, START_PAYOUT, START_RATE]
    lowest = np.concatenate([prior.lowest, [-np.inf, -np.inf]])
    highest = np.concatenate([prior.highest, [np.inf, np.inf]])
    nominal = np.concatenate([prior.nominal, [0.0, 0.0]])
    sigmas = np.concatenate([prior.sigmas, [np.inf, 2.0]])
    precision = 1.0 / np.square(sigmas[columns])
    count = int(np.count_nonzero(record.seen))
    # readings in a row that are off are not independent
    per_second = count / max(record.duration, record.dt)
    information = np.eye(len(columns))
    for _ in range(ITERATIONS):
        residual, slopes = _linearised(record, theta, columns)
        squares = float(residual @ residual)
        weight = 1.0 / (per_second * (squares / count + FLOOR**2))
        information = weight * slopes.T @ slopes + np.diag(precision)
        pull = weight * slopes.T @ residual + precision * (nominal[columns] - theta[columns])
        step = _solved(information, pull)
        blocked = ((theta[columns] <= lowest[columns]) & (step < 0.0)) | (
            (theta[columns] >= highest[columns]) & (step > 0.0)
        )
        if np.any(blocked):
            # what cannot go further must not shape the step of the others
            step[blocked] = 0.0
            step[~blocked] = _solved(information[np.ix_(~blocked, ~blocked)], pull[~blocked])
        trials = np.tile(theta, (len(SHARES_OF_STEP), 1))
        trials[:, columns] += np.outer(SHARES_OF_STEP, step)
        trials = np.clip(trials, lowest, highest)
        costs = 0.5 * weight * np.sum(np.square(record.residuals(trials)), axis=1)
        costs += 0.5 * np.sum(precision * np.square(trials[:, columns] - nominal[columns]), axis=1)
        before = 0.5 * weight * squares + 0.5 * float(precision @ np.square(theta[columns] - nominal[columns]))
        best = int(np.argmin(costs))
        if costs[best] >= before:
            break
        moved = float(np.max(np.abs(trials[best] - theta)))
        theta = trials[best]
        if moved < CONVERGED:
            break
    squares = float(np.sum(np.square(record.residuals(theta[None, :]))))
    spread = np.sqrt(np.abs(np.diag(np.linalg.pinv(information, hermitian=True))))
    off = np.square((theta[:FIELDS] - prior.nominal[:FIELDS]) / prior.sigmas[:FIELDS])
    return DrumFit(theta, squares, count, record, tuple(free), spread[: len(free)], 0.5 * float(np.sum(off)))


def _solved(information: Array, pull: Array) -> Array:
    """Return the step of an information matrix, which may be singular."""
    size = np.sqrt(np.diag(information)) + 1e-12
    step = np.linalg.pinv(information / np.outer(size, size), hermitian=True) @ (pull / size)
    return np.asarray(step / size)


def _linearised(record: DrumRecord, theta: Array, columns: Sequence[int]) -> tuple[Array, Array]:
    """Return the residuals, shape (count,), and how the record goes with each of `columns`, (count, columns)."""
    steps = np.array([-DIFFERENCE if column in LIMITS else DIFFERENCE for column in columns])
    thetas = np.tile(theta, (len(columns) + 1, 1))
    thetas[np.arange(1, len(thetas)), list(columns)] += steps
    left = record.residuals(thetas)
    return left[0], ((left[0] - left[1:]) / steps[:, None]).T


def identify(record: DrumRecord, prior: DrumPrior, believed: Array) -> DrumFit:
    """Return the drum that a record shows.

    Parameters
    ----------
    record, prior : what was read, and what can be
    believed : of the drum so far, shape (FIELDS + 1,)
    """
    start = begun(record, believed)
    # what is believed is found anew, but limits stay where the record does not reach them
    kept = [i for i in (DEADBAND, BACKLASH, HAULING, CREEP) if start[i] != prior.nominal[i]]
    best = fit_drum(record, prior, start, (*ALWAYS, *kept))
    if best.residual > UNEXPLAINED:
        for factor in LAGS:
            other = start.copy()
            other[LAG] = min(max(factor * start[LAG], prior.lowest[LAG]), prior.highest[LAG])
            best = min(best, fit_drum(record, prior, other, (*ALWAYS, *kept)), key=lambda fit: fit.loss)
    held_limits = {index for index in LIMITS if believed[index] < prior.nominal[index]}
    best, freed = _with_groups(prior, best, held_limits)
    return _without_held(prior, _without_passengers(prior, best, freed), held_limits)


def begun(record: DrumRecord, believed: Array) -> Array:
    """Return theta of a drum as it is `believed`, shape (FIELDS + 1,), that begins where the `record` does."""
    first = record.readings[record.seen]
    rate = (first[min(4, len(first) - 1)] - first[0]) / (4.0 * record.dt)
    return np.concatenate([believed, [first[0], rate]])


def _price(group: tuple[int, ...], held: set[int]) -> float:
    """Return what it costs to free a `group`: little where its limits are `held` already."""
    return HELD if set(group) <= held else PRICES[group]


def _with_groups(prior: DrumPrior, best: DrumFit, held: set[int]) -> tuple[DrumFit, set[tuple[int, ...]]]:
    """Free one group after another as long as the record is likelier by more than its price; return which."""
    freed: set[tuple[int, ...]] = set()
    for _ in range(ROUNDS):
        trials = [
            (fit.loss + _price(group, held) - best.loss, group, fit)
            for group in PRICES
            if not set(group) & set(best.free)
            for fit in [_freed(prior, best, group)]
            if fit is not None
        ]
        if not trials:
            break
        gain, group, fit = min(trials, key=lambda trial: trial[0])
        if gain >= 0.0:
            break
        best, freed = fit, freed | {group}
    return best, freed


def _freed(prior: DrumPrior, best: DrumFit, group: tuple[int, ...]) -> DrumFit | None:
    """Return the fit with a `group` free besides; None: it cannot be."""
    if group == (FACTOR,):
        return _with_factor(prior, best) if best.residual > UNEXPLAINED else None
    start, record = best.theta.copy(), best.record
    if set(group) <= set(LIMITS):
        shown = shown_limits(record)
        for index in group:
            start[index] = min(max(shown[index], prior.lowest[index]), prior.nominal[index])
        if all(start[index] >= prior.nominal[index] for index in group):
            return None
    elif group in ((DEADBAND,), (BACKLASH,)):
        start[group[0]] = max(start[group[0]], 0.01)
    return fit_drum(record, prior, start, (*best.free, *group))


def _with_factor(prior: DrumPrior, best: DrumFit) -> DrumFit | None:
    """Return the fit with another factor of the encoder from the moment on that fits best; None: too short a record."""
    record = best.record
    count = len(record.readings)
    onsets = [count - round(time / record.dt) for time in (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 11.0, 15.0)]
    fits = []
    for onset in onsets:
        if onset < round(LEAST_BEFORE / record.dt):
            continue
        shifted = replace(record, onset=onset)
        for factor in (-1.0, 0.5, 2.0):
            start = best.theta.copy()
            start[FACTOR] = factor
            fits.append(fit_drum(shifted, prior, start, (*best.free, FACTOR)))
    if not fits:
        return None
    best = min(fits, key=lambda fit: fit.loss)
    for step in (8, 4, 2, 1):
        for onset in (best.record.onset - step, best.record.onset + step):
            if 0 < onset < count - 2:
                near = fit_drum(replace(record, onset=onset), prior, best.theta, best.free)
                best = near if near.loss < best.loss else best
    return best


def shown_limits(record: DrumRecord) -> dict[int, float]:
    """Return the largest speeds [m/s] and accelerations [m/s^2] that a `record` shows, out and in, by limit."""
    speed = record.speeds(SHOWN_OVER)
    n = max(1, round(SHOWN_OVER / record.dt))
    change = (speed[n:] - speed[:-n]) / (n * record.dt)
    return {
        SPEED_OUT: float(np.nanmax(speed, initial=0.0)),
        SPEED_IN: float(np.nanmax(-speed, initial=0.0)),
        ACCELERATION_OUT: float(np.nanmax(change, initial=0.0)),
        ACCELERATION_IN: float(np.nanmax(-change, initial=0.0)),
    }


def _without_passengers(prior: DrumPrior, best: DrumFit, freed: Iterable[tuple[int, ...]]) -> DrumFit:
    """Return the fit without those of the `freed` groups that it does not need beside the others."""
    for group in sorted(freed):
        start = best.theta.copy()
        start[list(group)] = prior.nominal[list(group)]
        other = fit_drum(best.record, prior, start, tuple(i for i in best.free if i not in group))
        if other.loss - best.loss < PRICES[group]:
            best = other
    return best


def _without_held(prior: DrumPrior, best: DrumFit, held: set[int]) -> DrumFit:
    """Return the fit without those limits that are `held` and that the record speaks against."""
    for index in sorted(held - set(best.free)):
        start = best.theta.copy()
        start[index] = prior.nominal[index]
        other = fit_drum(best.record, prior, start, best.free)
        if other.loss + HELD < best.loss:
            best = other
    return best
