"""What a drum was ordered and what its encoder read, aligned by what the winch says it has taken."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from heave_core.watch import Drum, drum_records, sent_points
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray

from winch_controller_node.adviser.record import Excerpt, SensorHistory, payouts

FIELDS = len(Drum._fields)
FACTOR, START_PAYOUT, START_RATE = FIELDS, FIELDS + 1, FIELDS + 2
"""Places in a vector theta: the fields of `Drum`, the encoder's factor, payout and rate at the start of the record."""

ENDS_EVERY = 0.5
"""Time from one end of a drift of the count that is tried to the next [s]."""


@dataclass(frozen=True, eq=False)
class DrumRecord:
    """A record."""

    payouts: Array  # set-points of the ticks, oldest first, more of them than readings by the longest delay [m]
    rates: Array  # rates of these set-points [m/s]
    late: Array  # by how much later than usual each took effect [ticks]
    tensions: Array  # at the top at the end of each of these ticks [N]; NaN: unknown
    readings: Array  # of the encoder at the end of the last ticks, as payout by its assumed scale [m]; NaN: none
    limited: NDArray[np.bool_]  # the winch says that a limit acted in the tick, same shape
    position_gain: float  # of the servo's position loop [1/s]
    dt: float  # tick period [s]
    onset: int = 0  # reading from which on the encoder's factor counts
    breaks: tuple[int, ...] = ()  # readings from which on the encoder has another scale: it may have jumped there

    @cached_property
    def seen(self) -> NDArray[np.bool_]:
        """Where there is a reading, shape (count,)."""
        return np.isfinite(self.readings)

    @cached_property
    def _sent(self) -> Array:
        """What the drum was sent, as a table."""
        return sent_points(self.payouts, self.rates, self.late, self.tensions)

    @cached_property
    def _stretches(self) -> list[tuple[int, int]]:
        """First reading that is there, and end, of each stretch in which the encoder has not jumped."""
        places = np.searchsorted(np.flatnonzero(self.seen), sorted({*self.breaks, self.onset} - {0})).tolist()
        bounds = pairwise([*places, int(np.count_nonzero(self.seen))])
        return [(first, end) for first, end in bounds if first < end]

    @property
    def duration(self) -> float:
        """Length [s] of what was read."""
        return float(np.count_nonzero(self.seen)) * self.dt

    def simulated(self, thetas: Array) -> Array:
        """Return the readings of `thetas`, shape (m, FIELDS + 3), as (m, count) [m]."""
        drums = np.ascontiguousarray(thetas[:, :FIELDS])
        starts = np.ascontiguousarray(thetas[:, START_PAYOUT:])
        count = len(self.readings)
        path = drum_records(self._sent, drums, starts, self.position_gain, count, self.dt)
        factor = thetas[:, FACTOR, None]
        if np.all(factor == 1.0):
            return np.asarray(path)
        begin = path[:, self.onset - 1, None] if self.onset > 0 else starts[:, :1]
        path[:, self.onset :] = begin + factor * (path[:, self.onset :] - begin)
        return np.asarray(path)

    def residuals(self, thetas: Array) -> Array:
        """Return what `thetas` leave of the readings that are there, (m, seen); steps where it has jumped are found."""
        left = (self.readings - self.simulated(thetas))[:, self.seen]
        for first, end in self._stretches:
            left[:, first:end] -= left[:, first:end].mean(axis=1, keepdims=True)
        return np.asarray(left)

    def squares_with_drift(self, left: Array, slopes: Array, path: Array, onset: int) -> float:
        """Return the squares of what is `left` of a `path`, less a drift of count or gain from an `onset` on [m^2].

        What is free, with orthogonal `slopes` (seen, free), is fitted besides. A count that has drifted may have
        stopped since, as a drum does that crept for a while.
        """
        time = np.arange(len(path), dtype=float)
        ends = np.arange(len(path), onset, -max(1, round(ENDS_EVERY / self.dt)), dtype=float)
        counts = np.clip(time, onset, ends[:, None]) - onset
        gain = np.cumsum(np.maximum(time - onset, 0.0) * np.diff(path, prepend=path[0]))
        # a count that drifts all along is a drum's that creeps, which is in the fit
        drifts = np.vstack([counts, gain] if onset > 0 else [gain])[:, self.seen]
        for first, end in self._stretches:
            drifts[:, first:end] -= drifts[:, first:end].mean(axis=1, keepdims=True)
        drifts -= (drifts @ slopes) @ slopes.T
        left = left - slopes @ (left @ slopes)
        return float(left @ left - np.max((drifts @ left) ** 2 / np.maximum(np.sum(drifts**2, axis=1), 1e-30)))

    def until(self, place: int) -> DrumRecord:
        """Return its beginning, without the readings from a `place` on."""
        left = len(self.readings) - place
        names = ("payouts", "rates", "late", "tensions", "readings", "limited")
        begins = {name: getattr(self, name)[:-left] for name in names}
        return replace(self, **begins, onset=0, breaks=tuple(one for one in self.breaks if one < place))

    def step(self, theta: Array) -> float:
        """Return by how much the encoder has jumped at the onset, and there alone, under `theta` [m]."""
        left = self.readings - self.simulated(theta[None, :])[0]
        end = min((one for one in self.breaks if one > self.onset), default=len(left))
        before = max((one for one in self.breaks if one < self.onset), default=None)
        # before the first break the payout at the start is found so that nothing is left
        jumped = 0.0 if before is None else float(np.nanmean(left[before : self.onset]))
        return float(np.nanmean(left[self.onset : end])) - jumped

    def speeds(self, over: float) -> Array:
        """Return the speed of the encoder over each time `over` [s] [m/s]; NaN where a reading is missing."""
        n = max(1, round(over / self.dt))
        return np.asarray((self.readings[n:] - self.readings[:-n]) / (n * self.dt))


def drum_record(excerpt: Excerpt, window: float, ahead: int, history: SensorHistory, gain: float) -> DrumRecord | None:
    """Return the record of the drum over the last `window` [s], or since it was last braked; None: there is none.

    Parameters
    ----------
    excerpt : longer than the window by the ticks ahead
    window : length of the record [s]
    ahead : the longest delay [ticks]
    history : assumed scales of the encoder over the record
    gain : of the servo's position loop [1/s]
    """
    braked = np.flatnonzero(excerpt.tick_column("brake") > 0.0)
    first = max(int(braked[-1]) + 2 if len(braked) else 0, len(excerpt.ticks) - round(window / excerpt.dt), ahead)
    begin = first - ahead
    if first >= len(excerpt.ticks) - 1:
        return None
    ticks = np.arange(excerpt.first + begin, excerpt.last + 1, dtype=float)
    readings = payouts(excerpt.tick_column("encoder")[begin:], ticks, history.encoder)
    breaks = [one.since - (excerpt.first + first) for one in history.encoder]
    return DrumRecord(
        payouts=excerpt.tick_column("order_payout")[begin:].copy(),
        rates=np.where(excerpt.tick_column("brake")[begin:] > 0.0, 0.0, excerpt.tick_column("order_rate")[begin:]),
        late=lateness(excerpt.tick_column("sequence")[begin:], excerpt.tick_column("taken")[begin:]),
        tensions=excerpt.tick_column("tension")[begin:].copy(),
        readings=readings[ahead:].copy(),
        limited=excerpt.tick_column("limits_hit")[first:] > 0.0,
        position_gain=gain,
        dt=excerpt.dt,
        breaks=tuple(place for place in breaks if 0 < place < len(excerpt.ticks) - first),
    )


def lateness(sequence: Array, taken: Array) -> Array:
    """Return by how much later than usual each order took effect [ticks], as far as the winch shows it.

    The newest order in effect at a tick brackets the moment at which each was taken, to a tick. The usual lateness is
    that which lies within most brackets: a delay that falls on the edge of a tick is in all of them.

    Parameters
    ----------
    sequence : number of the order given at each tick; taken : of the newest in effect at its end, NaN: not known
    """
    known = np.isfinite(taken)
    if np.count_nonzero(known) < 2 or np.any(np.diff(sequence) != 1.0):
        return np.zeros(len(sequence))
    place = np.arange(len(sequence), dtype=float)
    newest = np.maximum.accumulate(np.where(known, taken - sequence[0], -np.inf))
    # order q is in effect at the end of tick `seen`, and was not at that of the last known tick before
    seen = np.searchsorted(newest, place, side="left")
    last_known = np.concatenate([[-np.inf], np.maximum.accumulate(np.where(known, place, -np.inf))])
    earliest = last_known[seen] + 1.0 - place
    latest = np.where(seen < len(sequence), seen, np.inf) + 1.0 - place
    if np.max(earliest) <= np.min(latest):
        # one delay lies within all brackets
        return np.zeros(len(sequence))
    bracketed = np.isfinite(earliest) & np.isfinite(latest)
    if not np.any(bracketed):
        return np.zeros(len(sequence))
    edges = np.unique(np.concatenate([earliest[bracketed], latest[bracketed]]))
    off = [np.sum(np.abs(_outside(edge, earliest[bracketed], latest[bracketed]))) for edge in edges]
    usual = float(edges[int(np.argmin(off))])
    late = np.where(np.isfinite(earliest) | np.isfinite(latest), _outside(usual, earliest, latest), 0.0)
    effect = place + late
    # what was late and was first seen with newer orders came with the newest of them, as after a stall of the machine
    newest_seen = np.searchsorted(seen, seen, side="right") - 1
    effect = np.where(late > 0.0, np.maximum(effect, effect[newest_seen]), effect)
    # an order is never taken before the one before it
    return np.asarray(np.maximum.accumulate(effect) - place)


def _outside(usual: float, earliest: Array, latest: Array) -> Array:
    """Return by how much brackets lie later (positive) or earlier than `usual`."""
    return np.asarray(np.maximum(earliest - usual, 0.0) - np.maximum(usual - latest, 0.0))
