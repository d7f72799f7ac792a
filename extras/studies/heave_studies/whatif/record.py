"""A record as a ship has it: what the controller was given and what it ordered, tick by tick, from a bag. No truth.

Only what a ship has is asked for, by topic and by field. Truth of a simulator is not read: `winch/state` carries some
(payout, its acceleration, tension), other topics nothing else. The controller's gates say in each tick how many
readings they judged and how old the newest is: so it is known in which tick a reading came, in real time too, where it
may come late, with another one, or never.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
from heave_bags.analyse.events import operator_requests
from heave_bags.analyse.reading.depth_programme import has_programme, running_mean
from heave_bags.analyse.reading.fields import Fields
from heave_bags.cdr.columns import Columns
from heave_bags.mcap.reader import LOG_TIME, TIME, Bag, Progress, no_progress
from heave_bags.record.provenance import SCENARIO_ATTACHMENT
from heave_bringup.errors import CommandError
from heave_node.interface import topics
from heave_node.interface.codes import MruStatus, SensorLevel
from heave_node.interface.sensors import MRU, SENSORS, Water, WireReading
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray
from winch_controller_node.beliefs.beliefs import latency_ticks
from winch_controller_node.interface.conversions import WINCH_STATE, measurements, winch_reading_of
from winch_controller_node.interface.readings import Measurements, WinchOrder
from winch_controller_node.interface.requests import request_of
from winch_controller_node.interface.sensors import INPUTS
from winch_controller_node.node_parameters import WinchControllerParameters

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
    operated: float = math.inf  # when an operator requested something of the controller for the first time [s]
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
            operated=self.operated if self.operated < end else math.inf,
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


ORDER = ("sequence", "payout", "payout_rate", "brake")
CONTROLLER = ("mode", "depth_set_point")
GATE = ("sensor", "accepted", "refused", "age")
LEVEL = ("level", "reason")
WINCH, COMMAND, STATE = topics.WINCH_STATE.name, topics.WINCH_COMMAND.name, topics.CONTROLLER_STATE.name
BELIEFS, DIAGNOSTICS = topics.CONTROLLER_BELIEFS.name, topics.DIAGNOSTICS.name
ENCODER = "encoder"

SELECTION: dict[str, tuple[str, ...]] = {
    WINCH: WINCH_STATE,
    COMMAND: ORDER,
    STATE: (*CONTROLLER, *(f"sensors[].{name}" for name in (*GATE, *LEVEL))),
    BELIEFS: ("asked",),
    DIAGNOSTICS: ("status[].level", "status[].name", "status[].message"),
    **{SENSORS[name].topic.name: SENSORS[name].values for name in INPUTS},
}
"""Topics that are read of a bag, and no others: sensors, orders, and the controller's reports and requests."""

Stamps = NDArray[np.int64]
Delivered = dict[int, list[WireReading]]
"""Readings of a sensor by tick."""

_SECOND = 1_000_000_000


def read_record(bag: Bag, nominal: WinchControllerParameters, *, progress: Progress = no_progress) -> SensorRecord:
    """Return the record of sensors in a `bag` of a run whose controller had the `nominal` parameters.

    `progress` is called with the share of the bag that is read. Raises CommandError where the bag lacks what every
    answer needs.
    """
    _check_topics(bag)
    period = _period(bag)
    selection = {topic: fields for topic, fields in SELECTION.items() if bag.has(topic)}
    columns = bag.columns(selection, progress=progress)
    orders = _orders(columns[COMMAND], period)
    first, last = min(orders), max(orders)
    gates = _gates(columns[STATE])
    given = {
        name: _readings(columns[SENSORS[name].topic.name], SENSORS[name].values, gates.get(name), period)
        for name in INPUTS
        if SENSORS[name].topic.name in columns
    }
    winches = _readings(columns[WINCH], WINCH_STATE, gates.get(ENCODER), period)
    water = Water(nominal.water_density, nominal.gravity)
    taken = tuple(
        measurements(
            {name: of_tick.get(tick, ()) for name, of_tick in given.items()},
            winch_reading_of(winches[tick][-1]) if tick in winches else None,
            water,
        )
        for tick in range(first, last + 1)
    )
    modes, set_points = _controller(columns[STATE], period, first, last)
    return SensorRecord(
        period / _SECOND,
        first,
        taken,
        tuple(orders.get(tick) for tick in range(first, last + 1)),
        set_points,
        modes,
        has_adviser=BELIEFS in columns and len(columns[BELIEFS][TIME]) > 0,
        late=_late(columns[BELIEFS], period) if BELIEFS in columns else frozenset(),
        operated=first_request(columns.get(DIAGNOSTICS)),
        losses=_losses(columns[STATE]),
    )


def _check_topics(bag: Bag) -> None:
    """Refuse a bag without one of the topics that every answer needs."""
    needed = {
        MRU.topic.name: "the boom tip's motion is not known",
        SENSORS["depth"].topic.name: "the unit's motion is not measured, so it cannot be predicted",
        WINCH: "what the drum did is not known",
        COMMAND: "what the winch was ordered is not known",
        STATE: "what the controller was given in each tick is not known",
    }
    for topic, why in needed.items():
        if not bag.has(topic):
            raise CommandError(f"{bag.path}: holds no {topic}: {why}; record it")
    if bag.has(topics.CRANE_POSE.name):
        raise CommandError(f"{bag.path}: holds {topics.CRANE_POSE.name}: of a crane that moves no answer can be given")


def _period(bag: Bag) -> int:
    """Return the tick period of the run in a `bag` [ns]."""
    try:
        return round(float(bag.run.get("tick_period_s", "")) * _SECOND)
    except ValueError as error:
        raise CommandError(f"{bag.path}: does not say its tick period") from error


def _stamps(columns: Columns) -> Stamps:
    """Return the stamps of messages [ns]."""
    return np.asarray(np.rint(columns[TIME] * _SECOND), dtype=np.int64)


def _orders(columns: Columns, period: int) -> dict[int, WinchOrder]:
    """Return the order of each tick."""
    rows = zip(*(columns[name].tolist() for name in ORDER), strict=True)
    return {
        int(tick): WinchOrder(int(sequence), payout, rate, bool(brake))
        for tick, (sequence, payout, rate, brake) in zip(_stamps(columns) // period, rows, strict=True)
    }


class Gate(NamedTuple):
    """What the controller's gate of a sensor says in each of its ticks."""

    stamps: Stamps  # start of the tick (n,) [ns]
    judged: Stamps  # readings in it (n,)
    newest: Stamps  # stamp of the newest accepted reading so far (n,) [ns]; 0: none yet


def _gates(state: Columns) -> dict[str, Gate]:
    """Return the gate of each sensor by the controller's reports."""
    stamps, found = _stamps(state), {}
    for number in _sensors(state):
        name, accepted, refused, age = (state[f"sensors[{number}].{field}"] for field in GATE)
        total = accepted.astype(np.int64) + refused
        judged = np.diff(total, prepend=0)
        newest = np.where(np.isnan(age), 0, stamps - np.rint(np.nan_to_num(age) * _SECOND).astype(np.int64))
        # a controller that was started again counts from 0
        found[str(name[0])] = Gate(stamps, np.where(judged < 0, total, judged), newest)
    return found


def _sensors(state: Columns) -> Iterator[int]:
    """Return the places of sensors in the controller's reports."""
    return itertools.takewhile(lambda n: f"sensors[{n}].sensor" in state, itertools.count())


def _losses(state: Columns) -> tuple[Loss, ...]:
    """Return when the controller held which sensor as lost, by its reports."""
    found, time = [], state[TIME]
    for number in _sensors(state):
        name, level, reason = (state[f"sensors[{number}].{field}"] for field in ("sensor", *LEVEL))
        edges = np.diff((level == SensorLevel.LOST).astype(int), prepend=0, append=0)
        for first, end in zip(np.flatnonzero(edges > 0), np.flatnonzero(edges < 0), strict=True):
            found.append(Loss(str(name[0]), float(time[first]), float(time[end - 1]), str(reason[first])))
    return tuple(found)


def first_request(diagnostics: Columns | None) -> float:
    """Return when an operator requested something of the controller first [s]; infinite: never, or not recorded.

    `diagnostics` are the columns of that topic; None: not recorded.
    """
    asked = (one for one in operator_requests(Fields(diagnostics)) if any(map(request_of, one.name.split(", "))))
    return min((one.start for one in asked), default=math.inf)


def _readings(columns: Columns, fields: Sequence[str], gate: Gate | None, period: int) -> Delivered:
    """Return the `fields` of the readings in the `columns` of a sensor by the tick in which the controller got them.

    Those that no `gate` has judged are taken to have come in the tick in which they were recorded; `period` is that of
    the ticks [ns].
    """
    rows: Any = zip(*(columns[value].tolist() for value in fields), strict=True)
    readings = [WireReading(stamp, numbers) for stamp, numbers in zip(_stamps(columns).tolist(), rows, strict=True)]
    if gate is None:
        stamps, judged = np.unique(columns[LOG_TIME] // period * period, return_counts=True)
        gate = Gate(stamps, judged, np.zeros_like(stamps))
    return delivered(readings, gate, period)


def delivered(readings: Sequence[WireReading], gate: Gate, period: int) -> Delivered:
    """Return the `readings` of a sensor by the tick in which its `gate` judged them; `period` is that of ticks [ns].

    The newest one that was accepted is known by its stamp: what was lost on the way shifts no other. A reading that was
    refused is the next one. So is every one of a sensor with a clock of its own: it gets the stamp that the controller
    gave it.
    """
    place = {reading.stamp: number for number, reading in enumerate(readings)}
    has_own_clock = place.keys().isdisjoint(gate.newest[gate.newest > 0].tolist())
    found: Delivered = {}
    done = before = shift = 0
    for stamp, judged, newest in zip(*(one.tolist() for one in gate), strict=True):
        # of one that the bag lacks there is no place: nothing came
        end = done + judged if newest == before or has_own_clock else place.get(newest, -1) + 1
        taken = readings[max(done, end - judged) : end]
        if taken:
            shift = newest - taken[-1].stamp if newest != before and has_own_clock else shift
            found[stamp // period] = [reading._replace(stamp=reading.stamp + shift) for reading in taken]
        done, before = max(done, end), newest
    return found


def _late(columns: Columns, period: int) -> frozenset[int]:
    """Return the ticks whose observations were answered too late for the controller."""
    asked = columns["asked"]
    return frozenset(asked[columns[LOG_TIME] // period > asked + latency_ticks(period / _SECOND)].tolist())


def _controller(columns: Columns, period: int, first: int, last: int) -> tuple[tuple[str, ...], Array]:
    """Return mode and mean payout of the controller in each tick, as far as it said them."""
    modes, set_points = [""] * (last - first + 1), np.full(last - first + 1, math.nan)
    for tick, mode, point in zip(
        (_stamps(columns) // period).tolist(),
        columns["mode"].tolist(),
        columns["depth_set_point"].tolist(),
        strict=True,
    ):
        if first <= tick <= last:
            modes[tick - first], set_points[tick - first] = str(mode), point
    return tuple(modes), set_points


@contextmanager
def stored_scenario(bag: Bag, given: Path | str = "") -> Iterator[Path | str]:
    """Give the scenario of a run, a file or a shipped name: the one that is `given`, else the one that its `bag` has.

    Raises CommandError where there is none.
    """
    if given:
        yield given
        return
    attached = bag.attachments.get(SCENARIO_ATTACHMENT, b"")
    content: bytes = attached if isinstance(attached, bytes) else getattr(attached, "data", b"")
    if not content:
        raise CommandError(f"{bag.path}: carries no scenario: say with --scenario what its controller assumed")
    with TemporaryDirectory(prefix="heave-") as folder:
        path = Path(folder, "scenario.yaml")
        path.write_bytes(content)
        yield path
