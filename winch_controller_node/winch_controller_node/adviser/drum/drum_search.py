"""Which drum a record shows: its fit is freed group by group.

Lag, delay and gain are always free. A limit, a dead zone, play, another gain of hauling in, or another factor of the
encoder is freed only where the record is likelier by more than its price, and dropped again where it is a passenger.
A limit has no slope where it is not reached: each is begun at the largest speed or acceleration that was read.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from heave_core.watch import NO_POWER_LIMIT
from heave_node.numerics.arrays import Array

from winch_controller_node.adviser.drum.drum_fit import (
    ACCELERATION_IN,
    ACCELERATION_OUT,
    BACKLASH,
    CREEP,
    DEADBAND,
    DELAY,
    GAIN,
    HAULING,
    LAG,
    LIMITS,
    POWER,
    SPEED_IN,
    SPEED_OUT,
    DrumFit,
    DrumPrior,
    fit_drum,
    linearised,
)
from winch_controller_node.adviser.drum.drum_record import FACTOR, START_PAYOUT, START_RATE, DrumRecord
from winch_controller_node.adviser.hypothesis import CLEARLY

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

SHOWN_OVER = 0.3
"""Time over which speeds are taken that a drum has shown [s]."""

LAGS = (0.4, 1.0, 2.5, 6.0)
"""Lags over the assumed one at which a fit is restarted where much is left."""

UNEXPLAINED = 4e-3
"""Standard deviation that is much [m]: no more may be left of what was before a sudden change of the encoder."""

ONSETS = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 11.0, 15.0)
"""Times before the end of the record from which on the encoder may read otherwise [s]."""

FACTORS = (0.5, 2.0)
"""First values that are tried of a factor of the encoder [-]."""

LIMITED = 0.1
"""Share of the ticks since then in which a limit may have acted: it has the drum do less than it was ordered."""

LEAST_BEFORE = 1.0
"""Time before a sudden change of the encoder that must be on record [s]."""

ROUNDS = 5
"""Largest number of groups that are freed."""


def identify(record: DrumRecord, prior: DrumPrior, assumed: Array) -> DrumFit:
    """Return the drum that a `record` shows, within its `prior`, near that `assumed` so far, shape (FIELDS + 1,)."""
    start = begun(record, assumed)
    # what is assumed is fitted again, but limits stay where the record does not reach them
    kept = [i for i in (DEADBAND, BACKLASH, HAULING, CREEP) if start[i] != prior.nominal[i]]
    best = fit_drum(record, prior, start, (*ALWAYS, *kept))
    others = _other_starts(prior, start) if best.residual > UNEXPLAINED else []
    best = min([best, *(fit_drum(record, prior, other, best.free) for other in others)], key=lambda fit: fit.loss)
    held_limits = {index for index in LIMITS if assumed[index] < prior.nominal[index]}
    onsets = _sudden(record, prior, assumed) if best.residual > UNEXPLAINED else []
    found, freed = _with_groups(prior, best, others, onsets, held_limits)
    if any(({FACTOR, *LIMITS} - held_limits) & set(group) for group in freed):
        # the drum creeps, or has crept, or its gain drifts, and nothing else is other: the next records say how much
        plain = [(best, set()), *([_with_groups(prior, best, others, [], held_limits)] if (FACTOR,) in freed else [])]
        alike = (one for one in plain if _loss_with_drift(one[0], onsets) < found.loss + CLEARLY)
        found, freed = next(alike, (found, freed))
    return _without_held(prior, _without_passengers(prior, found, freed, assumed), held_limits)


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
        is_read = np.count_nonzero(before.seen) > 2
        if is_read and fit_drum(before, prior, begun(before, assumed), ()).residual < UNEXPLAINED:
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
        for factor in FACTORS:
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


def _loss_with_drift(fit: DrumFit, onsets: Sequence[int]) -> float:
    """Return the loss of a `fit` if count or gain drift besides, all along or from near one of `onsets` on [nats]."""
    record = fit.record
    left, slopes = linearised(record, fit.theta, [*fit.free, START_PAYOUT, START_RATE])
    free, path = np.linalg.qr(slopes)[0], record.simulated(fit.theta[None, :])[0]
    count = len(record.readings)
    begins = (0, *range(min(onsets, default=count), count - 2))
    return replace(fit, squares=min(record.squares_with_drift(left, free, path, at) for at in begins)).loss


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
