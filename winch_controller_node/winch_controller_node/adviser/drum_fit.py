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
from winch_controller_node.model.drum_kernel import NO_POWER_LIMIT, Drum

LAG, DELAY, GAIN, DEADBAND, BACKLASH, HAULING, CREEP = (
    Drum._fields.index(name) for name in ("lag", "delay", "gain", "deadband", "backlash", "hauling", "creep")
)
SPEED_OUT, SPEED_IN, ACCELERATION_OUT, ACCELERATION_IN, POWER = LIMITS = tuple(
    Drum._fields.index(name) for name in ("speed_out", "speed_in", "acceleration_out", "acceleration_in", "power")
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
"""Prior of a group of quantities that differs from nominal [nats]."""

HELD = 3.0
"""Prior of a further change of a limit that was identified before [nats]."""

FLOOR = 1e-3
"""Least standard deviation of what is left [m]: no drum is known better, and an encoder reads in millimetres."""

ITERATIONS, CONVERGED = 12, 1e-4
"""Largest number of Gauss-Newton steps; they end with a step of every parameter below the second."""

DIFFERENCE = 1e-4
"""Step of the sensitivities; of a power relative."""

SHARES_OF_STEP = (1.0, 0.5, 0.25, 0.1, 0.03)
"""Shares of a Gauss-Newton step of which the best is taken."""

SHOWN_OVER = 0.3
"""Time over which speeds are taken that a drum has shown [s]."""

LAGS = (0.4, 1.0, 2.5, 6.0)
"""Lags over the assumed one at which a fit is restarted where much is left."""

UNEXPLAINED = 4e-3
"""Standard deviation that is much [m]: no more may be left of what was before a sudden change of the encoder."""

ONSETS = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 11.0, 15.0)
"""Times before the end of the record from which on the encoder may read otherwise [s]."""

LIMITED = 0.1
"""Share of the ticks since then in which a limit may have acted: it has the drum do less than it was ordered."""

LEAST_BEFORE = 1.0
"""Time before a sudden change of the encoder that must be on record [s]."""

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
    prior : how unlikely that is [nats]
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
    nominal, sigmas = nominal[columns], sigmas[columns]
    count = int(np.count_nonzero(record.seen))
    # readings in a row that are off are not independent
    per_second = count / max(record.duration, record.dt)
    information = np.eye(len(columns))
    for _ in range(ITERATIONS):
        residual, slopes = _linearised(record, theta, columns)
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
        trials = np.tile(theta, (len(SHARES_OF_STEP), 1))
        trials[:, columns] += np.outer(SHARES_OF_STEP, step)
        trials = np.clip(trials, lowest, highest)
        costs = 0.5 * weight * np.sum(np.square(record.residuals(trials)), axis=1)
        costs += _improbability(trials[:, columns] - nominal, sigmas)
        before = 0.5 * weight * squares + float(_improbability(theta[columns] - nominal, sigmas))
        best = int(np.argmin(costs))
        if costs[best] >= before:
            break
        moved = float(np.max(np.abs(trials[best] - theta) / _sizes(theta)))
        theta = trials[best]
        if moved < CONVERGED:
            break
    squares = float(np.sum(np.square(record.residuals(theta[None, :]))))
    spread = np.sqrt(np.abs(np.diag(np.linalg.pinv(information, hermitian=True))))
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
    step = np.linalg.pinv(information / np.outer(size, size), hermitian=True) @ (pull / size)
    return np.asarray(step / size)


def _sizes(theta: Array) -> Array:
    """Return what a step of each place of `theta` is to be compared with: a power with itself."""
    sizes = np.ones(len(theta))
    sizes[POWER] = theta[POWER]
    return sizes


def _linearised(record: DrumRecord, theta: Array, columns: Sequence[int]) -> tuple[Array, Array]:
    """Return the residuals, shape (count,), and how the record goes with each of `columns`, (count, columns)."""
    steps = np.array([-DIFFERENCE if column in LIMITS else DIFFERENCE for column in columns]) * _sizes(theta)[columns]
    thetas = np.tile(theta, (len(columns) + 1, 1))
    thetas[np.arange(1, len(thetas)), list(columns)] += steps
    left = record.residuals(thetas)
    return left[0], ((left[0] - left[1:]) / steps[:, None]).T


def identify(record: DrumRecord, prior: DrumPrior, assumed: Array) -> DrumFit:
    """Return the drum that a record shows.

    Parameters
    ----------
    record, prior : what was read, and what can be
    assumed : the drum assumed so far, shape (FIELDS + 1,)
    """
    start = begun(record, assumed)
    # what is assumed is fitted again, but limits stay where the record does not reach them
    kept = [i for i in (DEADBAND, BACKLASH, HAULING, CREEP) if start[i] != prior.nominal[i]]
    best = fit_drum(record, prior, start, (*ALWAYS, *kept))
    others = _other_starts(prior, start) if best.residual > UNEXPLAINED else []
    best = min([best, *(fit_drum(record, prior, other, best.free) for other in others)], key=lambda fit: fit.loss)
    held_limits = {index for index in LIMITS if assumed[index] < prior.nominal[index]}
    onsets = _sudden(record, prior, assumed) if best.residual > UNEXPLAINED else []
    best, freed = _with_groups(prior, best, others, onsets, held_limits)
    return _without_held(prior, _without_passengers(prior, best, freed, assumed), held_limits)


def _other_starts(prior: DrumPrior, start: Array) -> list[Array]:
    """Return starts with other lags, all else nominal: a slow servo at its limits is far from what a lag alone fits."""
    starts = []
    for factor in LAGS:
        other = np.concatenate([prior.nominal, start[START_PAYOUT:]])
        other[LAG] = min(max(factor * prior.nominal[LAG], prior.lowest[LAG]), prior.highest[LAG])
        starts.append(other)
    return starts


def begun(record: DrumRecord, assumed: Array) -> Array:
    """Return theta of a drum as `assumed`, shape (FIELDS + 1,), that begins where the `record` does."""
    first = record.readings[record.seen]
    rate = (first[min(4, len(first) - 1)] - first[0]) / (4.0 * record.dt)
    return np.concatenate([assumed, [first[0], rate]])


def price_of(new: Iterable[int]) -> float:
    """Return what it costs to hold what is `new`, by the groups that cover it at the least price [nats]."""
    left, price = {index for index in new if any(index in group for group in PRICES)}, 0.0
    while left:
        group = max(PRICES, key=lambda group: len(left & set(group)) / PRICES[group])
        left, price = left - set(group), price + PRICES[group]
    return price


def _price(group: tuple[int, ...], held: set[int]) -> float:
    """Return what it costs to free a `group`: little where its limits are `held` already."""
    return HELD if set(group) <= held else PRICES[group]


def _sudden(record: DrumRecord, prior: DrumPrior, assumed: Array) -> list[int]:
    """Return the readings from which on the encoder may differ: before them the drum did what was `assumed` of it.

    A drum does not change all at once; but one that is not known, or at a limit, is weak before its encoder is wrong.
    """
    count, found = len(record.readings), []
    for time in ONSETS:
        onset = count - round(time / record.dt)
        if onset < round(LEAST_BEFORE / record.dt) or np.mean(record.limited[onset:]) > LIMITED:
            continue
        before = record.until(onset)
        if (
            np.count_nonzero(before.seen) > 2
            and fit_drum(before, prior, begun(before, assumed), ()).residual < UNEXPLAINED
        ):
            found.append(onset)
    return found


def _with_groups(
    prior: DrumPrior, best: DrumFit, others: Sequence[Array], onsets: Sequence[int], held: set[int]
) -> tuple[DrumFit, set[tuple[int, ...]]]:
    """Free one group after another as long as the record is likelier by more than its price; return which.

    `others` are starts beside what is the best so far, `onsets` readings from which on the encoder may be wrong.
    """
    freed: set[tuple[int, ...]] = set()
    for _ in range(ROUNDS):
        trials = [
            (fit.loss + _price(group, held) - best.loss, group, fit)
            for group in PRICES
            # a loss is never negative: what costs all that is left, or more, cannot be worth it
            if not set(group) & set(best.free) and _price(group, held) < best.loss
            for fit in [_with_factor(prior, best, onsets) if group == (FACTOR,) else _freed(prior, best, group, others)]
            if fit is not None
        ]
        if not trials:
            break
        gain, group, fit = min(trials, key=lambda trial: trial[0])
        if gain >= 0.0:
            break
        best, freed = fit, freed | {group}
    return best, freed


def _freed(prior: DrumPrior, best: DrumFit, group: tuple[int, ...], others: Sequence[Array]) -> DrumFit | None:
    """Return the fit with a `group` free besides; None: it cannot be."""
    begin = best.theta.copy()
    if set(group) <= set(LIMITS):
        shown = shown_limits(best.record)
        for index in group:
            begin[index] = min(max(shown[index], prior.lowest[index]), prior.nominal[index])
        if all(begin[index] >= prior.nominal[index] for index in group):
            return None
    elif group in ((DEADBAND,), (BACKLASH,)):
        begin[group[0]] = max(begin[group[0]], 0.01)
    starts = [begin]
    for other in others if best.residual > UNEXPLAINED and set(group) <= set(LIMITS) else ():
        start = other.copy()
        start[list(LIMITS)] = best.theta[list(LIMITS)]
        start[list(group)] = begin[list(group)]
        starts.append(start)
    free = (*best.free, *group)
    return min((fit_drum(best.record, prior, start, free) for start in starts), key=lambda fit: fit.loss)


def _with_factor(prior: DrumPrior, best: DrumFit, onsets: Sequence[int]) -> DrumFit | None:
    """Return the fit with another factor of the encoder from near the best of the `onsets` on; None: none fits."""
    record = best.record
    count = len(record.readings)
    fits = []
    for onset in onsets:
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
    """Return the largest speeds [m/s] and accelerations [m/s^2] that a `record` shows, out and in, and power [W].

    It shows none where the tension is not known.
    """
    speed = record.speeds(SHOWN_OVER)
    n = max(1, round(SHOWN_OVER / record.dt))
    change = (speed[n:] - speed[:-n]) / (n * record.dt)
    return {
        SPEED_OUT: float(np.nanmax(speed, initial=0.0)),
        SPEED_IN: float(np.nanmax(-speed, initial=0.0)),
        ACCELERATION_OUT: float(np.nanmax(change, initial=0.0)),
        ACCELERATION_IN: float(np.nanmax(-change, initial=0.0)),
        POWER: float(np.nanmax(np.abs(speed) * record.tensions[-len(speed) :], initial=0.0)) or NO_POWER_LIMIT,
    }


def _without_passengers(prior: DrumPrior, best: DrumFit, freed: Iterable[tuple[int, ...]], assumed: Array) -> DrumFit:
    """Return the fit without those of the `freed` groups, and of their parts, that it does not need beside the rest.

    They return to their `assumed` values.
    """
    found = {index for group in freed for index in group}
    for group in sorted(group for group in PRICES if set(group) <= found):
        start = best.theta.copy()
        start[list(group)] = assumed[list(group)]
        other = fit_drum(best.record, prior, start, tuple(i for i in best.free if i not in group))
        if other.loss - best.loss < PRICES[group]:
            best = other
    return best


def _without_held(prior: DrumPrior, best: DrumFit, held: set[int]) -> DrumFit:
    """Return the fit with those limits raised that are `held` and that the record speaks against: to what it shows.

    One that goes with the load is not gone where it was exceeded once.
    """
    shown = shown_limits(best.record)
    for index in sorted(held - set(best.free)):
        raised = min(max(shown[index], float(best.theta[index])), float(prior.nominal[index]))
        if raised == best.theta[index]:
            continue
        other = _with_limit(prior, best, index, raised)
        if other.loss + HELD < best.loss:
            best = other
    return best


def needs(prior: DrumPrior, found: DrumFit, limit: int) -> bool:
    """Return whether the record of what was `found` is explained worse without a `limit` that is known already.

    `prior` is what can be, `limit` one of LIMITS.
    """
    return limit in found.free or _with_limit(prior, found, limit, prior.nominal[limit]).loss > found.loss + HELD


def _with_limit(prior: DrumPrior, found: DrumFit, limit: int, value: float) -> DrumFit:
    """Return what was `found`, fitted again with another `value` of a `limit` that is not free."""
    start = found.theta.copy()
    start[limit] = value
    return fit_drum(found.record, prior, start, found.free)
