"""The KPI formulas of heave compensation: the one definition, used live, in reports and in campaigns.

Pure numpy. Heave and payout are in metres, heave positive up, payout positive lowering the unit, tension never
negative.

All functions take samples that are equally spaced in time over the evaluation window (after the transient). A KPI
that cannot be computed (no samples, no reference) is NaN, and None in JSON; it is never a number that looks good.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from heave_node.loads.cycles import reversals
from heave_node.numerics.arrays import Array

AT_LIMIT = 0.999
"""A rate is at its limit from this fraction of the limit on."""

SNAP_LOW = 0.1
SNAP_HIGH = 1.3
SNAP_WINDOW = 2.0
"""A snap is a tension below SNAP_LOW of the static one, then one above SNAP_HIGH of it within SNAP_WINDOW [s]."""

WORSE_WINDOW = 60.0
"""Time over which the unit's motion is held against that of the uncompensated unit [s]."""
WORSE_RATIO = 1.05
"""A unit is worse than off where its standard deviation is larger than so many times that of the uncompensated one."""
WORSE_FLOOR = 0.02
"""An uncompensated unit that moves less [m] counts as one that moves so: noise alone moves a unit that is held."""


def sigma(values: ArrayLike) -> float:
    """Return the standard deviation of `values` about their mean; NaN for fewer than two samples."""
    array = np.asarray(values, dtype=float)
    return float(array.std()) if array.size > 1 else math.nan


def efficiency(residual: float, reference: float) -> float:
    """Return `1 - residual / reference` of two standard deviations; below 0 where harmful, NaN without a reference.

    Unit efficiency is `efficiency(s(z), s(z_off))`, outlet efficiency `efficiency(s(z0 - p), s(z0))`.
    """
    return 1.0 - residual / reference if reference > 0.0 else math.nan


def significant(standard_deviation: float) -> float:
    """Return the significant double amplitude `4 s` (H_1/3 sense) [same unit as `standard_deviation`]."""
    return 4.0 * standard_deviation


def kappa(unit_sigma: float, sensor_bound: float, actuator_bound: float) -> float:
    """Return the distance from the possible, `s(z) / sqrt(s_est^2 + s_act^2)`; 1 is the best that can be.

    Parameters
    ----------
    unit_sigma : s(z), standard deviation of the unit's heave [m]
    sensor_bound : s_est, the LQG optimum of the linear system with these sensors and delay and no limits [m]
    actuator_bound : s_act, the optimum of a clairvoyant controller with these limits [m]
    """
    bound = math.hypot(sensor_bound, actuator_bound)
    return unit_sigma / bound if bound > 0.0 else math.nan


def worse(unit_sigmas: ArrayLike, uncompensated_sigmas: ArrayLike) -> float:
    """Return the largest `s(z) / s(z_off)` over seeds; above 1 the compensator was harmful.

    `unit_sigmas` and `uncompensated_sigmas` are s(z) and s(z_off) of each seed, shape (n,) [m].
    """
    ratios = np.asarray(unit_sigmas, dtype=float) / np.asarray(uncompensated_sigmas, dtype=float)
    return float(ratios.max()) if ratios.size else math.nan


def window_ratios(
    time: ArrayLike, unit: ArrayLike, uncompensated: ArrayLike, begin: float, *, floor: float = 0.0
) -> tuple[Array, Array]:
    """Return when windows of WORSE_WINDOW begin, one each second, and `s(z) / s(z_off)` over each of them.

    Parameters
    ----------
    time : of the samples, shape (n,) [s]
    unit, uncompensated : z and z_off, shape (n,) [m]
    begin : of the first window [s]
    floor : least s(z_off) that is counted with [m]
    """
    times = np.asarray(time, dtype=float)
    period = float(np.median(np.diff(times))) if times.size > 1 else math.nan
    count = round(WORSE_WINDOW / period) if 0.0 < period < WORSE_WINDOW else 0
    first = int(np.searchsorted(times, begin))
    if not 0 < count <= times.size - first:
        return np.empty(0), np.empty(0)
    step = max(1, round(1.0 / period))
    starts = np.arange(first, times.size - count + 1, step)
    sigmas = [_window_sigmas(np.asarray(values, dtype=float)[first:], count, step) for values in (unit, uncompensated)]
    with np.errstate(divide="ignore", invalid="ignore"):
        return times[starts], sigmas[0] / np.maximum(sigmas[1], floor)


def _window_sigmas(values: Array, count: int, step: int) -> Array:
    """Return the standard deviations of `values` over windows of `count` samples, one every `step` samples.

    Blocks that the windows share are squared once: n s^2 of a window is the sum over its blocks of n_b s_b^2 and of
    n_b (mean_b - mean)^2, as exact as from the samples (Chan, Golub and LeVeque, The American Statistician 37 (1983)).
    """
    size = math.gcd(count, step)
    blocks = values[: values.size // size * size].reshape(-1, size)
    shape = count // size, step // size
    means, squares = (
        np.lib.stride_tricks.sliding_window_view(of, shape[0])[:: shape[1]]
        for of in (blocks.mean(axis=1), blocks.var(axis=1))
    )
    return np.asarray(np.sqrt(means.var(axis=1) + squares.mean(axis=1)))


def max_abs(values: ArrayLike) -> float:
    """Return the largest deviation of `values` from their mean, `max |x - mean(x)|`."""
    array = np.asarray(values, dtype=float)
    return float(np.abs(array - array.mean()).max()) if array.size else math.nan


def percentile_abs(values: ArrayLike, percent: float) -> float:
    """Return the percentile `percent` [%] of the deviation of `values` from their mean."""
    array = np.asarray(values, dtype=float)
    return percentile(np.abs(array - array.mean()), percent) if array.size else math.nan


def percentile(values: ArrayLike, percent: float) -> float:
    """Return the percentile `percent` [%] of `values`; 100 is the maximum. NaN without samples."""
    array = np.asarray(values, dtype=float)
    return float(np.percentile(array, percent)) if array.size else math.nan


def percent_true(flags: ArrayLike) -> float:
    """Return the share of `flags` that are true [%]."""
    array = np.asarray(flags, dtype=bool)
    return 100.0 * float(array.mean()) if array.size else math.nan


def at_limit(rates: ArrayLike, limit: float) -> NDArray[np.bool_]:
    """Return at which samples one of `rates` is at its `limit` (same unit), to one part in a thousand."""
    return np.asarray(np.abs(np.asarray(rates, dtype=float)) >= AT_LIMIT * limit, dtype=bool)


def tension_ratios(tension: ArrayLike, static_tension: ArrayLike) -> tuple[float, float]:
    """Return `rT = min T / Tstatic` and the dynamic amplification `DAF = max T / Tstatic`.

    `static_tension` is one number, or one for each sample where the deployed length changes [same unit as `tension`].
    """
    array, static = np.asarray(tension, dtype=float), np.asarray(static_tension, dtype=float)
    if not array.size or not np.all(static > 0.0):
        return math.nan, math.nan
    ratio = array / static
    return float(ratio.min()), float(ratio.max())


def snap_times(time: ArrayLike, tension: ArrayLike, static_tension: ArrayLike, peaks: ArrayLike | None = None) -> Array:
    """Return the times [s] at which the cable snapped taut.

    A snap is `T < 0.1 Tstatic` followed by `T > 1.3 Tstatic` within 2 s; one slack counts at most one snap.

    Parameters
    ----------
    time : of the samples, shape (n,) [s]
    tension : T, shape (n,) [N]
    static_tension : Tstatic, one number or one for each sample [N]
    peaks : largest tension since the sample before, shape (n,) [N]; None: the samples
    """
    times = np.asarray(time, dtype=float)
    values, static = np.asarray(tension, dtype=float), np.asarray(static_tension, dtype=float)
    if not np.all(static > 0.0):
        return np.empty(0)
    low = values < SNAP_LOW * static
    highest = values if peaks is None else np.asarray(peaks, dtype=float)
    events = np.flatnonzero(low | (highest > SNAP_HIGH * static))
    snaps: list[float] = []
    last_low = -math.inf
    for index in events:
        if low[index]:
            last_low = times[index]
        elif times[index] - last_low <= SNAP_WINDOW:
            snaps.append(float(times[index]))
            last_low = -math.inf
    return np.asarray(snaps)


LANDING_GAP = 10.0
"""A contact with the bottom that follows the one before by more than this is a landing of its own [s]."""


@dataclass(frozen=True)
class Landing:
    """A unit that came down on the bottom."""

    time: float  # of the first contact [s]
    end: float  # of the last contact [s]
    speed: float  # downwards, just before the first contact [m/s]
    rebound: float  # height above the place of first contact that it reached before it left for good [m]
    lift_offs: int  # how often contact was lost in between


def landings(time: ArrayLike, height: ArrayLike, is_touching: ArrayLike) -> list[Landing]:
    """Return the landings of a unit; one that lies on the bottom from the first sample has not landed.

    Parameters
    ----------
    time : of the samples, shape (n,) [s]
    height : of the unit, positive up, shape (n,) [m]
    is_touching : whether the bottom carries it, shape (n,)
    """
    times, heights = np.asarray(time, dtype=float), np.asarray(height, dtype=float)
    touching = np.flatnonzero(np.asarray(is_touching, dtype=bool))
    if not touching.size:
        return []
    found: list[Landing] = []
    for part in np.split(touching, np.flatnonzero(np.diff(times[touching]) > LANDING_GAP) + 1):
        first, last = int(part[0]), int(part[-1])
        if first < 2:
            continue
        # of the two samples before the contact: the bottom has not slowed the unit down yet
        speed = (heights[first - 2] - heights[first - 1]) / (times[first - 1] - times[first - 2])
        rebound = max(float(heights[first : last + 1].max() - heights[first]), 0.0)
        lift_offs = int(np.count_nonzero(np.diff(part) > 1))
        found.append(Landing(float(times[first]), float(times[last]), float(speed), rebound, lift_offs))
    return found


def largest_after(time: ArrayLike, values: ArrayLike, events: ArrayLike, within: float) -> float:
    """Return the largest absolute value `within` [s] after any of the `events` [s]; NaN where there is none.

    Parameters
    ----------
    time : of the samples, shape (n,) [s]
    values : shape (n,)
    events : shape (m,) [s]
    within : length of what counts after each event [s]
    """
    times, array = np.asarray(time, dtype=float), np.asarray(values, dtype=float)
    counts = np.zeros(times.shape, dtype=bool)
    for event in np.asarray(events, dtype=float):
        counts |= (times >= event) & (times <= event + within)
    return float(np.abs(array[counts]).max()) if counts.any() else math.nan


@dataclass(frozen=True)
class WinchPower:
    """Power at the drum, `T v`. Hauling in under load motors, paying out under load regenerates."""

    peak: float  # largest |T v| [W]
    mean_abs: float  # mean |T v| [W]
    rms: float  # root mean square of T v, by which a motor warms [W]
    motoring: float  # mean power of positive sign [W], which is the energy per hour [Wh/h]
    regenerated: float  # mean power of negative sign [W]


RATED_SHARE = 0.5
"""A winch is loaded from this share of its rated speed or power on."""


def percent_loaded(power: ArrayLike, speed: ArrayLike, rated_power: float, rated_speed: float) -> float:
    """Return the share of time above RATED_SHARE of rated speed or power [%]; NaN for a winch with neither.

    Parameters
    ----------
    power : at the drum, shape (n,) [W]
    speed : of the rope, shape (n,) [m/s]
    rated_power, rated_speed : limits of the winch [W], [m/s]; infinite where there is none
    """
    if not (math.isfinite(rated_power) or math.isfinite(rated_speed)):
        return math.nan
    is_fast = np.abs(np.asarray(speed, dtype=float)) > RATED_SHARE * rated_speed
    is_strong = np.abs(np.asarray(power, dtype=float)) > RATED_SHARE * rated_power
    return percent_true(is_fast | is_strong)


def winch_power(tension: ArrayLike, payout_rate: ArrayLike) -> WinchPower:
    """Return the power figures of a winch from `tension` at the top [N] and `payout_rate` [m/s, positive pays out]."""
    power = np.asarray(tension, dtype=float) * np.asarray(payout_rate, dtype=float)
    if not power.size:
        return WinchPower(math.nan, math.nan, math.nan, math.nan, math.nan)
    return WinchPower(
        peak=float(np.abs(power).max()),
        mean_abs=float(np.abs(power).mean()),
        rms=float(np.sqrt(np.mean(power**2))),
        motoring=float(np.maximum(-power, 0.0).mean()),
        regenerated=float(np.maximum(power, 0.0).mean()),
    )


BENDING_STROKE = 0.01
"""Swings of the rope below this do not bend it over the sheave: they are small beside its lay [m]."""


@dataclass(frozen=True)
class RopeWear:
    """What moving costs rope and drive, per hour."""

    travel: float  # rope that goes over the sheave, both ways together [m/h]
    reversals: float  # changes of direction [1/h]
    bending_cycles: float  # of the piece of rope that is bent most, straight to bent to straight [1/h]


def rope_wear(time: ArrayLike, payout: ArrayLike) -> RopeWear:
    """Return what a motion costs the rope; NaN where the record holds no time.

    A piece of rope is bent once for each time that it comes to the sheave and leaves it again. On an arc of contact
    longer than the stroke that is how often the payout rises through the level at which this piece meets the sheave:
    the largest number of the level-crossing count of ASTM E1049 (5.1). Swings below BENDING_STROKE are left out.

    Parameters
    ----------
    time : of the samples, rising, shape (n,) [s]
    payout : at them, shape (n,) [m]
    """
    times, values = np.asarray(time, dtype=float), np.asarray(payout, dtype=float)
    if values.size < 2 or not times[-1] > times[0]:
        return RopeWear(math.nan, math.nan, math.nan)
    per_hour = 3600.0 / float(times[-1] - times[0])
    swings = _after_play(reversals(values), BENDING_STROKE)  # play asks for turns alone
    directions = np.sign(np.diff(swings))
    turns = np.diff(directions[directions != 0.0])
    return RopeWear(
        travel=per_hour * float(np.abs(np.diff(values)).sum()),
        reversals=per_hour * float(np.count_nonzero(turns)),
        bending_cycles=per_hour * _most_crossed(swings),
    )


def _after_play(values: Array, play: float) -> Array:
    """Return the motion of what is dragged along with some play: smaller swings do not move it."""
    followed, place = np.empty_like(values), float(values[0])
    for index, value in enumerate(values.tolist()):
        place = min(max(place, value - 0.5 * play), value + 0.5 * play)
        followed[index] = place
    return followed


def _most_crossed(values: Array) -> int:
    """Return how often values rise through the level that they rise through most."""
    rises = np.flatnonzero(np.diff(values) > 0.0)
    levels = np.concatenate([values[rises], values[rises + 1]])
    changes = np.repeat([1, -1], rises.size)
    order = np.lexsort((changes, levels))  # at one level a rise ends before the next begins
    return int(np.cumsum(changes[order]).max(initial=0))


@dataclass(frozen=True)
class Harmonic:
    """First harmonic of a signal: `mean + amplitude sin(omega t + phase)`; phase [rad]."""

    mean: float
    amplitude: float
    phase: float


def fit_harmonic(time: ArrayLike, values: ArrayLike, omega: float) -> Harmonic:
    """Fit the first harmonic of `values` at `omega` [rad/s] by least squares; no whole number of periods is needed.

    Raises ValueError if the samples at `time` [s] cover less than one period.
    """
    times = np.asarray(time, dtype=float)
    if times.size < 3 or times[-1] - times[0] < 2.0 * math.pi / omega * (1.0 - 1e-6):
        raise ValueError(f"a fit at {omega:g} rad/s needs at least one period, {2.0 * math.pi / omega:g} s, of samples")
    basis = np.column_stack((np.ones_like(times), np.sin(omega * times), np.cos(omega * times)))
    mean, sine, cosine = np.linalg.lstsq(basis, np.asarray(values, dtype=float), rcond=None)[0]
    return Harmonic(float(mean), math.hypot(sine, cosine), math.atan2(cosine, sine))


def phase_lead_degrees(output: Harmonic, driver: Harmonic) -> float:
    """Return by how much `output` leads `driver` [deg], from -180 (excluded) to 180."""
    lead = math.degrees(output.phase - driver.phase) % 360.0
    return lead - 360.0 if lead > 180.0 else lead
