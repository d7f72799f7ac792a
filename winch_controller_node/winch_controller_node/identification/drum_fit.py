"""The drum that explains a record best: Gauss-Newton on servo and delay, and a search for limits that it has reached.

A limit has no slope where it is not reached, so that no descent finds it: a grid of lower limits is tried first. A
lower limit stays only where the record is much less likely without it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray

from winch_controller_node.identification.drum_kernel import Drum, drum_records

LAG, DELAY, GAIN, DEADBAND, BACKLASH, HAULING, CREEP = (
    Drum._fields.index(name) for name in ("lag", "delay", "gain", "deadband", "backlash", "hauling", "creep")
)
SPEEDS = (Drum._fields.index("speed_out"), Drum._fields.index("speed_in"))
ACCELERATIONS = (Drum._fields.index("acceleration_out"), Drum._fields.index("acceleration_in"))
LIMITS = (*SPEEDS, *ACCELERATIONS)
START_PAYOUT, START_RATE = len(Drum._fields), len(Drum._fields) + 1

ITERATIONS = 15
"""Largest number of Gauss-Newton steps."""

CONVERGED = 1e-4
"""Iteration ends with a step of every parameter below this."""

DIFFERENCE = 1e-4
"""Step of the sensitivities."""

SHARES_OF_STEP = (1.0, 0.5, 0.25, 0.1)
"""Shares of a Gauss-Newton step of which the best is taken."""

CORRELATED = 4.0
"""Residuals in a row that count as one: they are not white."""

RESOLUTION = 3e-4
"""Least standard deviation of what is left [m]: an encoder of 1 mm."""

GRID = (1.0, 0.85, 0.7, 0.55, 0.42, 0.32)
"""Lower limits that are tried, over the believed ones; those of speed over the highest speed asked for, if lower."""

LAG_FACTORS = (0.4, 0.7, 1.0, 1.5, 2.0, 3.0, 6.0, 12.0)
DELAY_CHANGES = (-0.16, -0.12, -0.08, -0.04, 0.0, 0.04, 0.08, 0.12, 0.16, 0.24)
"""Lags over the believed one and delays less the believed one [s] that a descent may begin with."""

MANY_TIMES = 5.0
"""A servo that is so many times slower than believed is another one."""

TRIED = 3
"""Starts of the grid from which the descent begins."""

LIKELIHOOD = 30.0
"""A lower limit stays if the record without it is less likely by a factor of exp(-LIKELIHOOD/2) at least."""

UNREACHED = 4.0
"""A limit that is known is where it was if the record is less likely so by a factor of exp(-UNREACHED/2) at most."""

SEEN_OVER, SEEN_ERROR = 0.5, 0.002
"""Time over which the speed of the encoder is taken [s], and the error of the difference of two readings [m]."""

EXPLAINED = 0.006
"""A record of which less than this is left is explained: it proves no limit; of more, nothing is learnt [m]."""

CREST = 0.015
"""And a second of which more than this is left shows a limit that was just reached, however long the record [m]."""

LOWERED = 0.9
"""A known limit that is below this share of what it was is no longer the one that was proved."""

IMPROVEMENT = 1.5
"""And if without it the mean square of what is left is so many times as large: no model is exact."""


@dataclass(frozen=True)
class DrumRecord:
    """What a drum was sent and what its encoder read.

    Attributes
    ----------
    payouts, rates : set-points of the ticks, oldest first, more of them than readings by the longest delay [m], [m/s]
    readings : of the encoder at the end of the last ticks [m]; NaN: none
    position_gain : of the servo's position loop [1/s]
    dt : tick period [s]
    told : fields of `Drum` that are limits of which the winch itself says that it has reached them
    is_load_limited : the winch says that a limit acted which goes with the load, as that of its power
    """

    payouts: Array
    rates: Array
    readings: Array
    position_gain: float
    dt: float
    told: tuple[int, ...] = ()
    is_load_limited: bool = False

    def worst_second(self, drum: Array) -> float:
        """Return the largest root mean square over a second of what a `drum` leaves, shape (14,) [m]."""
        left = np.square(np.nan_to_num(self.readings - self.simulated(drum[np.newaxis])[0]))
        count = min(max(1, round(1.0 / self.dt)), left.size)
        sums = np.cumsum(np.append(0.0, left))
        return math.sqrt(max(float(np.max(sums[count:] - sums[:-count])), 0.0) / count)

    @property
    def seen(self) -> Array:
        """Where there is a reading, shape (count,)."""
        return np.isfinite(self.readings)

    def simulated(self, drums: Array) -> Array:
        """Return the readings of `drums` with payout and rate at their start, shape (m, 14), as (m, count) [m]."""
        return np.asarray(
            drum_records(
                self.payouts,
                self.rates,
                np.ascontiguousarray(drums[:, :START_PAYOUT]),
                np.ascontiguousarray(drums[:, START_PAYOUT:]),
                self.position_gain,
                len(self.readings),
                self.dt,
            )
        )

    def squares(self, drums: Array) -> Array:
        """Return the sums of squared residuals of `drums`, shape (m,) [m^2]."""
        seen = self.seen
        return np.asarray(np.sum(np.square(self.readings[seen] - self.simulated(drums)[:, seen]), axis=1))


@dataclass(frozen=True)
class DrumBelief:
    """What is believed of a drum before it has moved: the nominal one, how sure that is, and what can be at all.

    Attributes
    ----------
    nominal, sigmas, lowest, highest : fields of `Drum`, shape (12,)
    """

    nominal: Array
    sigmas: Array
    lowest: Array
    highest: Array

    def lowered(self, drum: Array) -> list[int]:
        """Return the indices of the limits of a `drum` that are lower than the nominal ones."""
        return [i for i in LIMITS if drum[i] < self.nominal[i]]

    def near(self, drum: Array) -> DrumBelief:
        """Return the belief for a `drum` whose servo is many times slower: no lag so far off is less likely."""
        if drum[LAG] < MANY_TIMES * self.nominal[LAG]:
            return self
        nominal = self.nominal.copy()
        nominal[LAG] = drum[LAG]
        return replace(self, nominal=nominal)


def proved_belief(record: DrumRecord, belief: DrumBelief) -> DrumBelief:
    """Return the `belief` with no limit that may be lower than what the encoder has shown the drum to do in a `record`.

    A drum that lags otherwise than its model, or not the same way out and in, is off by some millimetres after a while,
    and a limit that cuts a wave's crest explains that as well. But a drum has at least the speed that it had.
    """
    n = max(1, round(SEEN_OVER / record.dt))
    window, lowest = n * record.dt, belief.lowest.copy()
    speed = (record.readings[n:] - record.readings[:-n]) / window
    acceleration = (speed[n:] - speed[:-n]) / window
    for limits, shown, error in (
        (SPEEDS, speed, SEEN_ERROR / window),
        (ACCELERATIONS, acceleration, 2.0 * SEEN_ERROR / window**2),
    ):
        known = shown[np.isfinite(shown)]
        for index, sign in zip(limits, (1.0, -1.0), strict=True):
            most = float(np.max(sign * known, initial=0.0)) - error
            lowest[index] = min(max(lowest[index], most), belief.nominal[index])
    return replace(belief, lowest=lowest)


def told_belief(record: DrumRecord, belief: DrumBelief, found: Array) -> DrumBelief:
    """Return the `belief` with no limit lower than `found` before, where the winch tells of others only.

    A winch that says when it is at its limit of acceleration would say so of its speed as well.

    Parameters
    ----------
    record, belief : of the drum
    found : fields of `Drum`, shape (12,)
    """
    lowest = belief.lowest.copy()
    for pair in (SPEEDS, ACCELERATIONS):
        if record.told and not set(pair) & set(record.told):
            lowest[list(pair)] = np.maximum(lowest[list(pair)], found[list(pair)])
    return replace(belief, lowest=lowest)


@dataclass(frozen=True)
class DrumFit:
    """The drum that fits best.

    Attributes
    ----------
    drum : fields of `Drum`, then payout and rate at the start of the record, shape (14,)
    squares : sum of the squared residuals [m^2]; count : residuals
    covariance : of lag and delay, shape (2, 2) [s^2]
    """

    drum: Array
    squares: float
    count: int
    covariance: Array

    @property
    def residual(self) -> float:
        """Standard deviation of the encoder about the model [m]."""
        return max(math.sqrt(self.squares / self.count), RESOLUTION)


def fit_drum(record: DrumRecord, belief: DrumBelief, start: Array, free: Sequence[int]) -> DrumFit:
    """Return the drum that fits a record best.

    Parameters
    ----------
    record, belief : of the drum
    start : where the descent begins, shape (14,)
    free : indices that are found, lag and delay first; the others stay; payout and rate at the start are always found
    """
    theta = start.copy()
    columns = [*free, START_PAYOUT, START_RATE]
    # the rate at the start shows for a lag only: where that is short, what is left of other causes must not drive it
    kept = [*free, START_RATE]
    nominal = np.append(belief.nominal[list(free)], 0.0)
    precision = 1.0 / np.square(np.append(belief.sigmas[list(free)], 5.0 * np.min(belief.nominal[list(SPEEDS)])))
    priors = [columns.index(index) for index in kept]
    seen = record.seen
    count = int(np.count_nonzero(seen))
    covariance = np.diag(np.square(belief.sigmas))
    for _ in range(ITERATIONS):
        residual, slopes = _linearise(record, theta, columns)
        squares = float(residual @ residual)
        weight = 1.0 / (CORRELATED * max(squares / count, RESOLUTION**2))
        information = weight * slopes.T @ slopes
        pull = weight * slopes.T @ residual
        information[priors, priors] += precision
        pull[priors] += precision * (nominal - theta[kept])
        covariance, step = _solved(information, pull)
        blocked = _blocked(theta, columns, step, belief)
        if np.any(blocked):
            # what cannot go further must not shape the step of the others
            open_ = ~blocked
            step[blocked] = 0.0
            step[open_] = _solved(information[np.ix_(open_, open_)], pull[open_])[1]
        trials = np.array([_stepped(theta, columns, share * step, belief) for share in SHARES_OF_STEP])
        costs = weight * record.squares(trials)
        costs += np.sum(precision * np.square(trials[:, kept] - nominal), axis=1)
        best = int(np.argmin(costs))
        moved = np.max(np.abs(trials[best] - theta)[columns])
        if costs[best] > weight * squares + float(precision @ np.square(theta[kept] - nominal)):
            break
        theta = trials[best]
        if moved < CONVERGED:
            break
    return DrumFit(theta, float(record.squares(theta[None, :])[0]), count, covariance[:2, :2])


def _solved(information: Array, pull: Array) -> tuple[Array, Array]:
    """Return the inverse of an information matrix, which may be singular, and the step that it gives."""
    size = np.sqrt(np.diag(information)) + 1e-12
    inverse = np.linalg.pinv(information / np.outer(size, size), hermitian=True) / np.outer(size, size)
    return inverse, inverse @ pull


def _blocked(theta: Array, columns: Sequence[int], step: Array, belief: DrumBelief) -> NDArray[np.bool_]:
    """Tell which of `columns` stand at an end of their range and would go beyond it."""
    lowest, highest = np.append(belief.lowest, [-np.inf] * 2), np.append(belief.highest, [np.inf] * 2)
    values = theta[list(columns)]
    low, high = lowest[list(columns)], highest[list(columns)]
    return np.asarray(((values <= low) & (step < 0.0)) | ((values >= high) & (step > 0.0)))


def _stepped(theta: Array, columns: Sequence[int], step: Array, belief: DrumBelief) -> Array:
    moved = theta.copy()
    moved[list(columns)] += step
    moved[:START_PAYOUT] = np.clip(moved[:START_PAYOUT], belief.lowest, belief.highest)
    return moved


def _linearise(record: DrumRecord, theta: Array, columns: Sequence[int]) -> tuple[Array, Array]:
    """Return the residuals, shape (count,), and how the record goes with each of `columns`, (count, columns)."""
    drums = np.tile(theta, (len(columns) + 1, 1))
    for row, column in enumerate(columns, start=1):
        # limits can only be lowered from where they are
        drums[row, column] += -DIFFERENCE if column in LIMITS else DIFFERENCE
    seen = record.seen
    simulated = record.simulated(drums)[:, seen]
    signs = np.array([-1.0 if column in LIMITS else 1.0 for column in columns])
    slopes = (simulated[1:] - simulated[0]).T / (DIFFERENCE * signs)
    return record.readings[seen] - simulated[0], slopes


def best_lags(record: DrumRecord, belief: DrumBelief, start: Array) -> list[Array]:
    """Return the start with those lags and delays of a coarse grid that fit best, the best first.

    At limits a descent from afar gets stuck.

    Parameters
    ----------
    record, belief : of the drum
    start : the rest of the drum, shape (14,)
    """
    trials = []
    for lag, delay in product(LAG_FACTORS, DELAY_CHANGES):
        trial = start.copy()
        trial[LAG], trial[DELAY] = lag * belief.nominal[LAG], belief.nominal[DELAY] + delay
        trial[:START_PAYOUT] = np.clip(trial[:START_PAYOUT], belief.lowest, belief.highest)
        trials.append(trial)
    order = np.argsort(record.squares(np.array(trials)), kind="stable")
    return [trials[int(k)] for k in order[:TRIED]]


def search_limits(
    record: DrumRecord, belief: DrumBelief, start: Array, free: Sequence[int], known: Sequence[int]
) -> DrumFit:
    """Return the drum with those limits without which a record cannot be explained.

    Parameters
    ----------
    record, belief, start, free : as for `fit_drum`
    known : limits that were proved before; they are at the start
    """
    bare = start.copy()
    bare[list(LIMITS)] = belief.nominal[list(LIMITS)]
    best = fit_drum(record, belief, bare, free)
    for grid in [start, *_shown_starts(belief, start), *_grid_starts(record, belief, bare)]:
        lowered = belief.lowered(grid)
        if not lowered:
            continue
        fit = fit_drum(record, belief, grid, [*free, *lowered])
        best = fit if fit.squares < best.squares else best
    best = _one_after_another(record, belief, best, free)
    best = without_needless(record, belief, best, free, bare, ())
    return _with_known(record, belief, best, start, free, known)


def _with_known(
    record: DrumRecord, belief: DrumBelief, fit: DrumFit, start: Array, free: Sequence[int], known: Sequence[int]
) -> DrumFit:
    """Return the fit with the limits that are known, as at the start, unless it is much worse.

    A limit that has just been reached explains some of what another does: none is forgotten for it.
    """
    forgotten = [i for i in known if fit.drum[i] >= belief.nominal[i]]
    if not forgotten:
        return fit
    begin = fit.drum.copy()
    begin[forgotten] = start[forgotten]
    kept = fit_drum(record, belief, begin, [*free, *belief.lowered(begin)])
    kept = without_needless(record, belief, kept, free, begin, LIMITS)
    return kept if kept.squares < IMPROVEMENT * fit.squares else fit


def _one_after_another(record: DrumRecord, belief: DrumBelief, fit: DrumFit, free: Sequence[int]) -> DrumFit:
    """Move one limit after another as long as the record is explained much better: a wave may reach all four."""
    for _ in LIMITS:
        trials = []
        for index, share in product(LIMITS, GRID):
            trial = fit.drum.copy()
            trial[index] = max(share * belief.nominal[index], belief.lowest[index])
            trials.append(trial)
        order = np.argsort(record.squares(np.array(trials)), kind="stable")
        for k in order[:TRIED]:
            trial = trials[int(k)]
            better = fit_drum(record, belief, trial, [*free, *belief.lowered(trial)])
            if IMPROVEMENT * better.squares < fit.squares:
                break
        else:
            return fit
        fit = better
    return fit


def _shown_starts(belief: DrumBelief, start: Array) -> list[Array]:
    """Return the start with the highest speeds that the drum has shown as its limits, out, in and both."""
    starts = []
    for shown in ([SPEEDS[0]], [SPEEDS[1]], list(SPEEDS)):
        starts.append(start.copy())
        starts[-1][shown] = belief.lowest[shown]
    return starts


def _grid_starts(record: DrumRecord, belief: DrumBelief, bare: Array) -> list[Array]:
    """Return the best combinations of lower limits, the best first."""
    fastest = float(np.max(np.abs(record.rates[-len(record.readings) :])))
    bases = {i: min(float(belief.nominal[i]), fastest) for i in SPEEDS}
    bases |= {i: float(belief.nominal[i]) for i in ACCELERATIONS}
    ranked = []
    for pair in (ACCELERATIONS, SPEEDS):
        # a drum at its limit shows it: the most that it has done is the first to be tried
        tried = [[bare[i], belief.lowest[i], *(share * bases[i] for share in GRID[1:])] for i in pair]
        trials = []
        for limits in product(*tried):
            trial = bare.copy()
            trial[list(pair)] = limits
            trials.append(trial)
        order = np.argsort(record.squares(np.array(trials)), kind="stable")
        ranked.append([trials[int(k)] for k in order[:TRIED]])
    mixed = []
    for by_acceleration, by_speed in product(*ranked):
        trial = by_acceleration.copy()
        trial[list(SPEEDS)] = by_speed[list(SPEEDS)]
        mixed.append(trial)
    candidates = [*ranked[0], *ranked[1], *mixed]
    order = np.argsort(record.squares(np.array(candidates)), kind="stable")
    return [candidates[int(k)] for k in order[:TRIED]]


def without_needless(
    record: DrumRecord, belief: DrumBelief, fit: DrumFit, free: Sequence[int], otherwise: Array, known: Sequence[int]
) -> DrumFit:
    """Return the fit with each limit that the record does not prove as it is otherwise.

    Parameters
    ----------
    record, belief, free : as for `fit_drum`
    fit : of the record
    otherwise : drum whose limits stand where the record proves no other ones, shape (14,)
    known : limits that were proved before: these have only to be reached. Another one, unless the winch tells it, is
        proved only by a record that is not explained without it
    """
    for index in LIMITS:
        if fit.drum[index] == otherwise[index]:
            continue
        start = fit.drum.copy()
        start[index] = otherwise[index]
        moved = [i for i in LIMITS if start[i] != otherwise[i]]
        other = fit_drum(record, belief, start, [*free, *moved])
        gain = (other.squares - fit.squares) / (CORRELATED * fit.residual**2)
        if index in known and fit.drum[index] >= LOWERED * otherwise[index]:
            is_needless = gain < UNREACHED
        else:
            is_needless = gain < LIKELIHOOD or other.squares < IMPROVEMENT * fit.squares
            is_needless |= index not in record.told and _is_explained(record, other)
        fit = other if is_needless else fit
    return fit


def _is_explained(record: DrumRecord, fit: DrumFit) -> bool:
    """Tell whether a drum explains all of a record: a wave that has just reached a limit is little of it."""
    return fit.residual < EXPLAINED and record.worst_second(fit.drum) < CREST
