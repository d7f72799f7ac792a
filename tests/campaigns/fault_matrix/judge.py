"""How a run with a fault is judged: from its rows, by functions that know nothing of the loop."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate

import numpy as np
from heave_node.interface.alarm import Severity
from heave_node.kpi import WORSE_FLOOR
from heave_node.numerics.arrays import Array
from heave_studies.promise.run import IDENTIFIED, NO_BLAME, PARTS, blamed_by
from winch_controller_node.model.blocks import CableModel
from winch_controller_node.parameters.envelope import EnvelopeParameters
from winch_controller_node.parameters.laws import MoveParameters

from tests.campaigns.fault_matrix.moments import Asked

MINUTE = 60.0
"""Time over which heave and motion are compared [s]."""

MARGIN = 0.3
"""Travel of the drum beyond the heave of a minute [m]."""

ENVELOPE = EnvelopeParameters()
"""Factors and margins of the bounds, as they are documented in `docs/guide/controller/envelope.md`."""

MOVE = MoveParameters()
"""Acceleration of a move."""

SETTLED = 10.0
"""Time after the beginning of a fault from which on the unit's motion counts [s]."""

STILL, LASTING = 1e-3, 5.0
"""A drum at rest is slower [m/s], with the brake on, for so long [s]."""

LARGEST_UNIT = 1.3
"""Largest motion of the unit over that of the locked one, or over that of the same run without a fault."""

ORDERLY, SUDDEN = 0.5, 0.05
"""Deceleration of an orderly stop [m/s^2]; speed beyond that from which a drum comes to rest at once [m/s]."""

TAKES_EFFECT = 1.0
"""Time in which an order takes effect, its delay included [s]."""

SHOWN = 0.1
"""Way of the drum, made or ordered, that shows a fault of what moves it [m]."""

HELD = 3.0
"""Time under the brake that shows one of the brake [s]."""

_DRUM = ("winch", "encoder")
NAMES = {
    "DEPTH_MRU_DISAGREE": ("depth", "mru"),
    "PAYOUT_DEPTH_DISAGREE": ("encoder", "depth"),
    "DRUM_OR_ENCODER: still": _DRUM,
    "DRUM_OR_ENCODER: reversed": _DRUM,
    "DRUM_OR_ENCODER: scale": _DRUM,
    "DRUM_OFF_ORDER: drift": _DRUM,
    "DRUM_OR_ENCODER: unresolved reversal": _DRUM,
    "DRUM_OR_ENCODER: unresolved scale": _DRUM,
    "DRUM_SPEED_OFF": _DRUM,
    "DRUM_OFF_ORDER: distance": _DRUM,
    "DRUM_NOT_HELD: count": _DRUM,
    "COUNT_SPEED_DISAGREE": _DRUM,
    "DRUM_NOT_HELD: hook load": ("winch", "load_cell"),
    "MRU_REVERSED": ("mru", "depth", "load_cell"),
    "MRU_UNPROVED: scale": ("mru", "depth", "load_cell"),
    "MRU_UNPROVED: alone": (),
    "WINCH_INVALID_COMMAND": ("orders",),
    "ORDER_REPLACED: not finite": ("orders",),
    "AUTHORITY_LIMITED": (),
    "WINCH_SATURATED": (),
}
"""Parts that an alarm names, where its row says fewer, or the part is not at fault."""

ALSO = ("winch", "adviser", "velocity", "imu", "loop", "network")
"""Parts that an alarm above an event names, and that are no blame by themselves."""


@dataclass(frozen=True)
class Raised:
    """An alarm of a run."""

    time: float  # [s]
    code: str  # name of its row
    part: str  # of its row
    severity: Severity  # of its row
    text: str = ""  # what it says

    @property
    def names(self) -> tuple[str, ...]:
        """Parts of which it names one."""
        if self.code in NAMES:
            return NAMES[self.code]
        if self.code == "WINCH_MODEL_UPDATED":
            return blamed_by(self, noise=True)  # type: ignore[arg-type]
        is_event = self.severity is Severity.EVENT and not self.code.startswith(IDENTIFIED)
        if is_event or self.code.partition(": ")[0] in NO_BLAME or self.part not in (*PARTS, *ALSO):
            return ()
        return (self.part,)


def named_after(alarms: Sequence[Raised], parts: Sequence[str], begin: float) -> float:
    """Return how long after `begin` [s] the first alarm came that names one of the `parts` [s]; infinite: none did."""
    times = [one.time - begin for one in alarms if one.time >= begin and set(one.names) & set(parts)]
    return min(times, default=math.inf)


def blamed(alarms: Sequence[Raised], parts: Sequence[str], begin: float) -> list[Raised]:
    """Return the alarms after `begin` [s] that name none of the `parts`, but others: those are healthy."""
    found = [one for one in alarms if one.time >= begin and not set(one.names) & set(parts)]
    return [one for one in found if set(one.names) & {*PARTS, "winch", "velocity", "imu"}]


def rolling_range(values: Array, count: int) -> Array:
    """Return largest less least of the last `count` values, or of those there are, at each."""
    padded = np.concatenate([np.full(count - 1, values[0]), values])
    windows = np.lib.stride_tricks.sliding_window_view(padded, count)
    found: Array = windows.max(axis=1) - windows.min(axis=1)
    return found


def rolling_largest(values: Array, count: int) -> Array:
    """Return the largest of the last `count` values, or of those there are, at each."""
    padded = np.concatenate([np.full(count - 1, values[0]), values])
    found: Array = np.lib.stride_tricks.sliding_window_view(padded, count).max(axis=1)
    return found


def rest_after(time: Array, rate: Array, brake: Array, begin: float) -> float:
    """Return how long after `begin` [s] the drum is at rest under its brake and stays so for `LASTING` [s].

    Parameters
    ----------
    time, rate, brake : of each tick [s], [m/s], the brake is on; shapes (n,)
    begin : of the fault [s]

    0: it was at rest already; infinite: it never is.
    """
    still = (np.abs(rate) < STILL) & np.asarray(brake, dtype=bool) & (time >= begin)
    moves = np.flatnonzero(~still)
    starts = np.concatenate([[-1], moves]) + 1
    ends = np.concatenate([moves, [time.size]])
    period = _period(time)
    for start, end in zip(starts, ends, strict=True):
        if (end - start) * period >= LASTING:
            return max(float(time[start]) - begin, 0.0)
    return math.inf


def stopped_at_once(time: Array, rate: Array, begin: float, rest: float) -> float:
    """Return how long after `begin` [s] a drum is last quicker than in an orderly stop that ends when it does.

    Infinite: it comes to rest in an orderly way, or never. 0: a drum that was not at rest stands within `TAKES_EFFECT`,
    by no order, at whatever speed, and the load is let go as by any other stop.

    Parameters
    ----------
    time, rate : of each tick [s], [m/s], shapes (n,)
    begin, rest : of the fault, and after it that of the drum [s]
    """
    left = begin + rest - time
    found = time[(time >= begin) & (left > 0.0) & (np.abs(rate) > ORDERLY * left + SUDDEN)]
    if found.size:
        return float(found[-1]) - begin
    return 0.0 if 0.0 < rest <= TAKES_EFFECT else math.inf


def past_brake(time: Array, payout: Array, ordered: Array, only_brake: Array) -> Array:
    """Return how far the drum has run past a brake that alone may hold it, up to each tick [m].

    It counts from when on a brake that holds would have brought the drum to rest. No order acts on that: after an
    emergency stop, or a fault of the drive, there is none but the brake.

    Parameters
    ----------
    time, payout : of each tick [s], [m]; shapes (n,)
    ordered : rate that the drive was sent [m/s], NaN: to brake; shape (n,)
    only_brake : nothing else may hold the drum, shape (n,)
    """
    rate, held = np.gradient(payout, time), np.isnan(ordered)
    begins = held & ~np.concatenate([[False], held[:-1]])
    begin = np.maximum.accumulate(np.where(begins, np.arange(time.size), 0))
    before = np.abs(rate[np.maximum(begin - 1, 0)])
    holds = time - time[begin] > before / ORDERLY + TAKES_EFFECT
    found: Array = np.cumsum(np.where(held & holds & only_brake, np.gradient(payout), 0.0))
    return found


def _way(time: Array, asked: Asked, begin: float) -> Array:
    """Return how far the drum may have gone by what was `asked` since `begin` [s], at each tick, at least 0 [m]."""
    found: Array = np.minimum(asked.speed * np.maximum(time - begin, 0.0), abs(asked.distance))
    return found


def beyond(time: Array, payout: Array, asked: Asked, begin: float) -> Array:
    """Return how far the drum is from where it was at `begin`, beyond what was asked of it since, at each tick [m]."""
    way = _way(time, asked, begin)
    moved = payout - payout[np.searchsorted(time, begin)]
    low, high = (0.0, way) if asked.distance >= 0.0 else (-way, 0.0)
    out = np.maximum(np.maximum(moved - high, low - moved) - asked.travel, 0.0)
    found: Array = np.where(time >= begin, out, 0.0)
    return found


def travel_ratio(time: Array, payout: Array, tip: Array, asked: Asked, begin: float, end: float) -> float:
    """Return the travel of the drum from `begin` to `end` [s] over the heave of the rolling minute and 0.3 m.

    Heave is largest less least height of the boom tip in a minute; of all minutes that end since `begin` the largest
    counts, for the drum may still have to come back from it.
    """
    heave = rolling_range(tip, round(MINUTE / _period(time)))
    since = (time >= begin) & (time <= end)
    largest = np.maximum.accumulate(heave[since])
    return float(np.max(beyond(time, payout, asked, begin)[since] / (largest + MARGIN), initial=0.0))


def lead_of(time: Array, planned: Array, stretch: Array, follows: Array, asked: Asked, cable: CableModel) -> Array:
    """Return the further travel that the envelope allows a drum that moves a load or stops its swing, at each tick [m].

    A load follows a move with a z'' + b z' + z = -payout; what it swings below a locked drum is stopped as compensation
    begins. Either fades within a minute, and comes with a speed at the load's own frequency.

    Parameters
    ----------
    time, planned, stretch : of each tick [s], mean payout [m], stretch of the cable [m], shapes (n,)
    follows : in these ticks the drum compensates, shape (n,)
    asked : since the fault
    cable : nominal
    """
    period = _period(time)
    count = round(MINUTE / period)
    rate = np.clip(np.gradient(planned, period), -asked.speed, asked.speed)
    steepest = MOVE.acceleration if asked.speed else 0.0
    slope = np.clip(np.gradient(rate, period), -steepest, steepest)
    wanted = 2.0 * cable.natural_a * np.abs(slope) + np.maximum(cable.b, cable.drag * np.abs(rate)) * np.abs(rate)
    for start in np.flatnonzero(np.diff(follows.astype(int)) > 0) + 1:
        wanted[start] = max(wanted[start], float(np.std(stretch[max(start - count, 0) : start])))
    decay = math.exp(-period / ENVELOPE.travel_time)
    return np.array(list(accumulate(wanted, lambda before, now: max(decay * before, now))))


def envelope_ratio(
    time: Array,
    payout: Array,
    planned: Array,
    tip: Array,
    asked: Asked,
    begin: float,
    lead: Array | float = 0.0,
    swing: Array | float = 0.0,
) -> float:
    """Return the largest rate or travel of the drum from `begin` [s] on, over the bounds of the envelope.

    Parameters
    ----------
    time, payout, tip : of each tick [s], [m], heave of the boom tip [m]; shapes (n,)
    planned : mean payout about which the controller works [m], shape (n,)
    asked : since then
    begin : of the fault [s]
    lead, swing : further travel that is allowed, see `lead_of`, and the speed with which it comes [m], [m/s]

    Bounds are those of `ENVELOPE`, by rate and heave of the boom tip as it was in the last minute. The travel is that
    about the asked motion, with a leak of a minute. How much of a move the drum has made is not known: anything from
    none of it to all at once, or as the mean payout makes it, no further and no faster than asked.
    """
    period, since, bounds = _period(time), time >= begin, ENVELOPE
    count = round(bounds.window / period)
    wider = 1.0 + (bounds.early_factor - 1.0) * (1.0 - np.minimum(time / bounds.window, 1.0))
    speed = rolling_largest(np.abs(np.gradient(tip, period)), count)
    heave = rolling_largest(np.abs(tip - np.mean(tip)), count)
    rate, ahead = np.gradient(payout, period), math.copysign(1.0, asked.distance)
    at_once = _way(time, asked, begin)
    made = np.clip(ahead * (planned - planned[np.searchsorted(time, begin)]), 0.0, at_once)
    moves = np.clip(np.gradient([at_once, made], period, axis=1).max(axis=0), 0.0, asked.speed)
    over = np.abs(rate) / (bounds.rate_factor * wider * speed + bounds.rate_margin + moves + swing)
    before = np.where(since, 0.0, np.gradient(planned, period))
    ways = (0.0 * time, at_once, made)
    moved = [leaky(rate - before - ahead * np.gradient(way, period), period, bounds.travel_time) for way in ways]
    out = np.maximum(np.maximum(np.min(moved, axis=0), -np.max(moved, axis=0)), 0.0)
    travel = out / (bounds.travel_factor * wider * heave + bounds.travel_margin + asked.travel + lead)
    return float(max(np.max(over[since]), np.max(travel[since])))


def leaky(rate: Array, period: float, tau: float) -> Array:
    """Return the integral of a `rate` [m/s] sampled each `period` [s], that leaks with a time constant `tau` [s]."""
    decay = math.exp(-period / tau)
    total, found = 0.0, np.empty_like(rate)
    for place, one in enumerate(rate):
        total = decay * total + one * period
        found[place] = total
    return found


def unit_ratio(time: Array, unit: Array, off: Array, begin: float) -> float:
    """Return the largest standard deviation of the `unit` from 10 s after `begin` on, over that with a locked winch.

    Parameters
    ----------
    time, unit, off : of each tick [s], heave of the unit and of the locked one [m], shapes (n,)
    begin : of the fault [s]

    The unit is taken over minutes that end each second, or over what there is since; the locked one over the same time
    or the whole minute, where it moves more. NaN: there are less than 5 s.
    """
    period = _period(time)
    first = int(np.searchsorted(time, begin + SETTLED))
    count, least = round(MINUTE / period), round(5.0 / period)
    if time.size - first < least:
        return math.nan
    ends = range(min(first + count, time.size), time.size + 1, max(1, round(1.0 / period)))
    ratios = []
    for end in ends:
        start = max(first, end - count)
        locked = max(float(np.std(off[first:end])) for first in (start, max(0, end - count)))
        ratios.append(np.std(unit[start:end]) / max(locked, WORSE_FLOOR))
    return float(max(ratios))


def path_of(time: Array, rate: Array, ordered: Array, begin: float, end: float) -> float:
    """Return how far apart the places are that the drum was at, or was to be at, from `begin` to `end` [s] [m].

    The larger of the two; a drum that goes to and fro by less is not far from any place by which a fault could show.
    """
    during = (time >= begin) & (time <= end)
    ways = [np.concatenate([[0.0], np.cumsum(one[during])]) for one in (rate, ordered)]
    return max(float(np.ptp(way)) for way in ways) * _period(time)


def asked_more(ordered: Array, rate: float, time: Array, begin: float, end: float) -> bool:
    """Return whether the drive was sent more than a `rate` [m/s] between `begin` and `end` [s]."""
    during = (time >= begin) & (time <= end)
    return bool(np.any(np.abs(ordered[during]) > rate))


def held_for(time: Array, brake: Array, begin: float, end: float) -> float:
    """Return how long the brake was on from `begin` to `end` [s]."""
    return float(np.sum(np.asarray(brake, dtype=bool)[(time >= begin) & (time <= end)])) * _period(time)


def _period(time: Array) -> float:
    return float(time[1] - time[0])
