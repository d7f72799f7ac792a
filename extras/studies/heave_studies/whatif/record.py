"""A record as a ship has it: what the controller was given and what it ordered, tick by tick, from a bag. No truth.

Only what a ship has is asked for, by topic and by field. Truth of a simulator is not read: `winch/state` carries some
(payout, its acceleration, tension), other topics nothing else. A reading is taken to have come in the tick in which it
was recorded, and not before its stamp, as the state of the winch at the end of a tick: in lockstep it did.
"""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from heave_bags.analyse.events import operator_requests
from heave_bags.analyse.reading.depth_programme import has_programme, running_mean
from heave_bags.analyse.reading.fields import Fields
from heave_bags.cdr.columns import Columns
from heave_bags.mcap.reader import LOG_TIME, TIME, Bag, Progress, no_progress
from heave_bringup.errors import CommandError
from heave_node.interface import topics
from heave_node.interface.codes import MruStatus
from heave_node.interface.sensors import MRU, SENSORS, Water, WireReading
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray
from winch_controller_node.beliefs.beliefs import Belief, Beliefs
from winch_controller_node.interface.conversions import WINCH_STATE, measurements, winch_reading_of
from winch_controller_node.interface.readings import Measurements, WinchOrder
from winch_controller_node.interface.requests import request_of
from winch_controller_node.interface.sensors import INPUTS
from winch_controller_node.node_parameters import WinchControllerParameters

Flags = NDArray[np.int64]
"""Sums of flags, one a tick."""

NOMINAL = Beliefs(asked=-1)
"""Nothing is other than nominal."""


@dataclass(frozen=True)
class SensorRecord:
    """A record of n ticks in a row."""

    tick_period: float  # [s]
    first: int  # number of the first tick; tick k is at k tick_period
    measurements: tuple[Measurements, ...]  # delivered to the controller in each tick, (n,)
    # that it gave to the winch in each, (n,); None: it left the tick out, being behind in real time
    orders: tuple[WinchOrder | None, ...]
    # mean payout that it worked about in each, (n,) [m]; between those beside it in a tick that it left out
    set_points: Array
    modes: tuple[str, ...]  # of the controller in each, (n,); "": not known
    has_adviser: bool = True  # the controller had one
    beliefs: Beliefs = field(default=NOMINAL, repr=False)  # newest of that, about the nominal parameters
    operated: float = math.inf  # when an operator requested something of the controller for the first time [s]

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
        """Times and heaves that the MRU read and stands by, shape (m, 2) [s], [m]."""
        rows = [
            (one.time, one.heave)
            for of_tick in self.measurements
            for one in of_tick.mru
            if one.status == MruStatus.OK and np.isfinite(one.heave)
        ]
        return np.array(rows).reshape(-1, 2)

    def scalar(self, sensor: str) -> Array:
        """Return times and finite values that a `sensor` read, shape (m, 2), in its unit."""
        rows = [tuple(one) for given in self.measurements for one in given.of(sensor) if math.isfinite(one.value)]
        return np.array(rows).reshape(-1, 2)

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


ORDER = ("sequence", "payout", "payout_rate", "brake")
WINCH, COMMAND, STATE = topics.WINCH_STATE.name, topics.WINCH_COMMAND.name, topics.CONTROLLER_STATE.name
BELIEFS, DIAGNOSTICS = topics.CONTROLLER_BELIEFS.name, topics.DIAGNOSTICS.name

NEEDED = {
    MRU.topic.name: "the boom tip's motion is not known",
    SENSORS["depth"].topic.name: "the unit's motion is not measured, so it cannot be predicted",
    WINCH: "what the drum did is not known",
    COMMAND: "what the winch was ordered is not known",
    STATE: "about which payout the winch worked is not known",
}
"""Topics that every answer needs, and why."""

SELECTION: dict[str, tuple[str, ...]] = {
    WINCH: WINCH_STATE,
    COMMAND: ORDER,
    STATE: ("mode", "depth_set_point"),
    BELIEFS: ("values[].quantity", "values[].value"),
    DIAGNOSTICS: ("status[].level", "status[].name", "status[].message"),
    **{SENSORS[name].topic.name: SENSORS[name].values for name in INPUTS},
}
"""Topics that are read of a bag, and no others: sensors, orders, and the controller's reports and requests."""

_SECOND = 1_000_000_000


def read_record(bag: Bag, nominal: WinchControllerParameters, *, progress: Progress = no_progress) -> SensorRecord:
    """Return the record of sensors in a `bag` of a run whose controller had the `nominal` parameters.

    `progress` is called with the share of the bag that is read. Raises CommandError where the bag lacks what every
    answer needs.
    """
    for topic, why in NEEDED.items():
        if not bag.has(topic):
            raise CommandError(f"{bag.path}: holds no {topic}: {why}; record it")
    if bag.has(topics.CRANE_POSE.name):
        raise CommandError(f"{bag.path}: holds {topics.CRANE_POSE.name}: of a crane that moves no answer can be given")
    try:
        period = round(float(bag.run.get("tick_period_s", "")) * _SECOND)
    except ValueError as error:
        raise CommandError(f"{bag.path}: does not say its tick period") from error
    columns = bag.columns({topic: of for topic, of in SELECTION.items() if bag.has(topic)}, progress=progress)
    rows = zip(*(columns[COMMAND][name].tolist() for name in ORDER), strict=True)
    orders = dict(zip((_stamps(columns[COMMAND]) // period).tolist(), (WinchOrder(*row) for row in rows), strict=True))
    ticks = range(min(orders), max(orders) + 1)
    given = {
        name: _readings(columns[SENSORS[name].topic.name], SENSORS[name].values, period)
        for name in INPUTS
        if SENSORS[name].topic.name in columns
    }
    winches = _readings(columns[WINCH], WINCH_STATE, period)
    water = Water(nominal.water_density, nominal.gravity)
    taken = tuple(
        measurements(
            {name: of_tick.get(tick, ()) for name, of_tick in given.items()},
            winch_reading_of(winches[tick][-1]) if tick in winches else None,
            water,
        )
        for tick in ticks
    )
    said = (columns[STATE][name].tolist() for name in ("mode", "depth_set_point"))
    state = dict(zip((_stamps(columns[STATE]) // period).tolist(), zip(*said, strict=True), strict=True))
    modes, set_points = zip(*(state.get(tick, ("", math.nan)) for tick in ticks), strict=True)
    return SensorRecord(
        period / _SECOND,
        ticks[0],
        taken,
        tuple(orders.get(tick) for tick in ticks),
        bridged(np.array(set_points)),
        tuple(map(str, modes)),
        BELIEFS in columns and len(columns[BELIEFS][TIME]) > 0,
        newest_beliefs(columns.get(BELIEFS)),
        first_request(columns.get(DIAGNOSTICS)),
    )


def _stamps(columns: Columns) -> NDArray[np.int64]:
    """Return the stamps of messages [ns]."""
    return np.asarray(np.rint(columns[TIME] * _SECOND), dtype=np.int64)


def newest_beliefs(columns: Columns | None) -> Beliefs:
    """Return the adviser's newest answer, by the `columns` of its topic; None: there was no adviser."""
    if columns is None or not len(columns[TIME]):
        return NOMINAL
    last = {name: values[-1] for name, values in columns.items()}
    places = itertools.takewhile(lambda n: f"values[{n}].quantity" in last, itertools.count())
    pairs = [(last[f"values[{n}].quantity"], last[f"values[{n}].value"]) for n in places]
    return Beliefs(0, values=MappingProxyType({name: Belief(name, float(value)) for name, value in pairs if name}))


def first_request(diagnostics: Columns | None) -> float:
    """Return when an operator requested something of the controller first [s]; infinite: never, or not recorded.

    `diagnostics` are the columns of that topic; None: not recorded.
    """
    asked = (one for one in operator_requests(Fields(diagnostics)) if any(map(request_of, one.name.split(", "))))
    return min((one.start for one in asked), default=math.inf)


def _readings(columns: Columns, fields: Sequence[str], period: int) -> Mapping[int, list[WireReading]]:
    """Return the `fields` of the readings in the `columns` of a sensor by tick; `period` is that of the ticks [ns]."""
    rows: Any = zip(*(columns[value].tolist() for value in fields), strict=True)
    found: dict[int, list[WireReading]] = defaultdict(list)
    for logged, stamp, numbers in zip(columns[LOG_TIME].tolist(), _stamps(columns).tolist(), rows, strict=True):
        found[max(logged, stamp) // period].append(WireReading(stamp, numbers))
    return found
