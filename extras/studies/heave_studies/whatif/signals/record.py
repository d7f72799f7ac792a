"""A record as a ship has it: what the controller was given and what it ordered, tick by tick. No truth, no ROS."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from heave_bags.analyse.reading.depth_programme import has_programme, running_mean
from heave_node.interface.codes import MruStatus
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray
from winch_controller_node.interface.readings import Measurements, WinchOrder
from winch_controller_node.interface.requests import Request

Flags = NDArray[np.int64]
"""Sums of flags, one a tick."""

LOST = 1.0
"""Longest time without a sensor that is bridged [s]."""


class Loss(NamedTuple):
    """A time in which the controller did not use a sensor."""

    sensor: str  # by name
    start: float  # [s]
    end: float  # [s]
    reason: str  # in its words


@dataclass(frozen=True)
class SensorRecord:
    """A record of n ticks in a row."""

    tick_period: float  # [s]
    first: int  # number of the first tick; tick k is at k tick_period
    measurements: tuple[Measurements, ...]  # delivered to the controller in each tick, (n,)
    # that it gave to the winch in each, (n,); None: it left the tick out, being behind in real time
    orders: tuple[WinchOrder | None, ...]
    set_points: Array  # mean payout that it worked about in each, (n,) [m]; NaN: not known
    modes: tuple[str, ...]  # of the controller in each, (n,); "": not known
    has_adviser: bool = True  # the controller had one
    late: frozenset[int] = frozenset()  # ticks whose observations it answered too late
    # of an operator that the controller found in a tick, in order, by the tick's number
    requests: Mapping[int, tuple[Request, ...]] = field(default_factory=dict)
    losses: tuple[Loss, ...] = ()  # of sensors, by the controller

    @property
    def ticks(self) -> int:
        """Number of ticks."""
        return len(self.measurements)

    @property
    def duration(self) -> float:
        """Length of the record [s]."""
        return self.ticks * self.tick_period

    @cached_property
    def time(self) -> Array:
        """Time of each tick [s]."""
        return np.asarray((self.first + np.arange(self.ticks)) * self.tick_period, dtype=np.float64)

    @cached_property
    def encoder(self) -> Array:
        """Payout that the encoder reads at each tick [m]; gaps are bridged in a straight line."""
        read = [np.nan if one.winch is None else one.winch.encoder_payout for one in self.measurements]
        return bridged(np.array(read))

    @cached_property
    def limits_hit(self) -> Flags:
        """Limits of the winch that acted before each tick, sums of WinchLimit; 0 where it is not known."""
        return np.array([0 if one.winch is None else one.winch.limits_hit for one in self.measurements])

    @cached_property
    def tension(self) -> Array:
        """Newest tension that the load cell has read at each tick [N]; NaN: none yet."""
        newest, found = math.nan, np.full(self.ticks, math.nan)
        for index, of_tick in enumerate(self.measurements):
            for one in of_tick.of("load_cell"):
                newest = one.value if math.isfinite(one.value) else newest
            found[index] = newest
        return found

    @cached_property
    def mru(self) -> Array:
        """Times, heaves and heave rates that the MRU read and stands by, shape (m, 3) [s], [m], [m/s]."""
        rows = [
            (one.time, one.heave, one.heave_rate)
            for of_tick in self.measurements
            for one in of_tick.mru
            if one.status == MruStatus.OK and np.isfinite(one.heave)
        ]
        return np.array(rows).reshape(-1, 3)

    @cached_property
    def attitude(self) -> Array:
        """Times, rolls and pitches that the MRU read and stands by, shape (m, 3) [s], [rad], [rad]."""
        rows = [
            (one.time, one.roll, one.pitch)
            for of_tick in self.measurements
            for one in of_tick.mru
            if one.status == MruStatus.OK and np.isfinite(one.roll + one.pitch)
        ]
        return np.array(rows).reshape(-1, 3)

    def times_of(self, sensor: str) -> list[float]:
        """Return the times of what a `sensor`, or the encoder, has read [s]."""
        if sensor == "encoder":
            return [one.winch.time for one in self.measurements if one.winch is not None]
        return [one.time for given in self.measurements for one in (given.mru if sensor == "mru" else given.of(sensor))]

    def scalar(self, sensor: str) -> Array:
        """Return times and finite values that a `sensor` read, shape (m, 2), in its unit."""
        if sensor not in self._scalars:
            rows = [tuple(one) for given in self.measurements for one in given.of(sensor) if math.isfinite(one.value)]
            self._scalars[sensor] = np.array(rows).reshape(-1, 2)
        return self._scalars[sensor]

    @cached_property
    def _scalars(self) -> dict[str, Array]:
        return {}

    def part(self, end: float) -> SensorRecord:
        """Return the record up to a time `end` [s]."""
        count = int(np.searchsorted(self.time, end))
        return replace(
            self,
            measurements=self.measurements[:count],
            orders=self.orders[:count],
            set_points=self.set_points[:count],
            modes=self.modes[:count],
        )


def without_move(time: Array, heave: Array, set_point: Array) -> Array:
    """Return a `heave` about its running mean where the unit was moved to another depth, as the figures of a run are.

    Parameters
    ----------
    time : of each tick (n,) [s]
    heave : about the mean payout (n,) [m]
    set_point : mean payout (n,) [m]
    """
    return heave - running_mean(time, heave) if has_programme(set_point) else heave


def bridged(values: Array) -> Array:
    """Return `values` with what is not finite bridged in a straight line; unchanged where nothing is finite."""
    good = np.isfinite(values)
    if good.all() or not good.any():
        return values
    places = np.arange(len(values))
    return np.interp(places, places[good], values[good])


def at_ticks(record: SensorRecord, times: Array, values: Array) -> Array:
    """Return `values` read at `times` [s], in any order, at the ticks of a `record`, in a straight line in between."""
    order = np.argsort(times, kind="stable")
    return np.interp(record.time, times[order], values[order])
