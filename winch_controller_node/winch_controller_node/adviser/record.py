"""The last minute as the adviser keeps it: ticks and readings of whole batches, without a break."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray

from winch_controller_node.beliefs.beliefs import AS_READ, Correction, EncoderScale
from winch_controller_node.interface.observations import READING_COLUMNS, TICK_COLUMNS, Observations
from winch_controller_node.interface.sensors import KnownSensors

DELIVERED, TICK, ROW, VALUE, SHARE, OFFSET, SIGMA, IS_USED, NIS = range(len(READING_COLUMNS))
COLUMN = {name: index for index, name in enumerate(TICK_COLUMNS)}

SENSOR_OF = {row.name: name for name, sensor in KnownSensors().by_name().items() for row in sensor.rows()}
"""Sensor of each measurement."""

LENGTH = 120.0
"""Longest record that is kept [s]: the sea is identified from it."""


class Record:
    """Keeps the batches of the last two minutes; a new epoch begins a new record.

    `tick_period` : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._batches: deque[Observations] = deque()
        self._epoch = -1

    def add(self, batch: Observations) -> None:
        """Take a batch in."""
        follows = bool(self._batches) and batch.epoch == self._epoch and batch.first == self._batches[-1].last + 1
        if not follows:
            self._batches.clear()
        self._epoch = batch.epoch
        self._batches.append(batch)
        while len(self._batches) > 1 and (batch.last - self._batches[1].first) * self._dt > LENGTH:
            self._batches.popleft()

    @property
    def duration(self) -> float:
        """Length of what is kept [s]."""
        return (self._batches[-1].last + 1 - self._batches[0].first) * self._dt if self._batches else 0.0

    def last(self, duration: float) -> Excerpt:
        """Return the last `duration` [s] of it, in whole batches."""
        kept: list[Observations] = []
        for batch in reversed(self._batches):
            if kept and (kept[0].last + 1 - kept[-1].first) * self._dt >= duration - 0.5 * self._dt:
                break
            kept.append(batch)
        kept.reverse()
        # they come in the order of their delivery, and stay in it within a tick
        readings = np.concatenate([batch.readings for batch in kept])
        order = np.argsort(readings[:, TICK], kind="stable")
        ticks = np.concatenate([batch.ticks for batch in kept])
        return Excerpt(kept[0].first, ticks, kept[0].rows, readings[order], self._dt)


@dataclass(frozen=True, eq=False)
class Excerpt:
    """A record without a break."""

    first: int  # number of its first tick
    ticks: Array  # as in `Observations`
    rows: tuple[str, ...]  # as in `Observations`
    readings: Array  # as in `Observations`, in the order of their own ticks
    dt: float  # tick period [s]

    @property
    def last(self) -> int:
        """Number of its last tick."""
        return self.first + len(self.ticks) - 1

    def tick_column(self, name: str) -> Array:
        """Return the column `name` of the table of ticks."""
        return self.ticks[:, COLUMN[name]]

    def of(self, rows: tuple[str, ...]) -> Excerpt:
        """Return it with the readings of the measurements `rows` only, of its own ticks, numbered as there."""
        index = np.array([rows.index(name) if name in rows else -1 for name in self.rows])
        which = index[self.readings[:, ROW].astype(np.int64)]
        kept = (which >= 0) & (self.readings[:, TICK] >= self.first)
        readings = self.readings[kept].copy()
        readings[:, ROW] = which[kept]
        readings[:, TICK] = np.minimum(readings[:, TICK], self.last)
        return Excerpt(self.first, self.ticks, rows, readings, self.dt)

    def is_of(self, sensor: str) -> NDArray[np.bool_]:
        """Tell which readings are a `sensor`'s."""
        known = np.array([SENSOR_OF[name] == sensor for name in self.rows])
        return np.asarray(known[self.readings[:, ROW].astype(np.int64)])

    def is_row(self, name: str) -> NDArray[np.bool_]:
        """Tell which readings are those of a measurement of a `name`."""
        if name not in self.rows:
            return np.zeros(len(self.readings), dtype=np.bool_)
        return np.asarray(self.readings[:, ROW] == self.rows.index(name))

    def longest_break(self, sensor: str) -> float:
        """Return the longest time without a reading of a `sensor` [s]; of the encoder, set aside or not, by ticks."""
        if sensor == "encoder":
            read = self.first + np.flatnonzero(np.isfinite(self.tick_column("encoder")))
        else:
            read = np.sort(self.readings[self.is_of(sensor), DELIVERED])
        bounds = np.concatenate([[self.first - 1], read, [self.last + 1]])
        return float(np.max(np.diff(bounds)) - 1.0) * self.dt

    def corrected(self, assumed: SensorHistory) -> Array:
        """Return the readings under the `assumed` corrections, the mean payout's share included; delays are kept."""
        values, ticks = self.readings[:, VALUE].copy(), self.readings[:, TICK]
        for sensor, since, correction in assumed.corrections:
            mine = self.is_of(sensor) & (ticks >= since)
            values[mine] = self.readings[mine, VALUE]
            values[mine & self.is_row("mru_heave")] -= correction.offset
            values[mine] /= correction.scale
        payout = self.is_row("payout")
        values[payout] = payouts(self.readings[payout, VALUE], ticks[payout], assumed.encoder)
        return values


class SensorHistory(NamedTuple):
    """Assumed corrections of the sensors over the record."""

    # sensor, tick since which it holds, correction; the later holds
    corrections: tuple[tuple[str, int, Correction], ...] = ()
    encoder: tuple[EncoderScale, ...] = ()  # its scales, the oldest first

    def correction(self, sensor: str) -> Correction:
        """Return the newest of a `sensor`."""
        return next((found for name, _, found in reversed(self.corrections) if name == sensor), AS_READ)

    @property
    def encoder_scale(self) -> float:
        """The newest scale of the encoder."""
        return self.encoder[-1].scale if self.encoder else 1.0


def payouts(as_read: Array, ticks: Array, scales: Sequence[EncoderScale]) -> Array:
    """Return the payouts [m] that an encoder of `scales` reads `as_read` [m] at `ticks`; all have one shape."""
    found = as_read
    for one in scales:
        found = np.where(ticks >= one.since, one.payout + (as_read - one.reading) / one.scale, found)
    return found
