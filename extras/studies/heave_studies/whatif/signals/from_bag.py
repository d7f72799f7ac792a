"""A record of sensors from a bag: only what a ship has is asked for, by topic and by field.

Truth of a simulator is not read: `winch/state` carries some (payout, its acceleration, tension), other topics nothing
else. A bag without them gives the same record to the last bit. The controller's gates say in each tick how many
readings they judged and how old the newest is: so it is known in which tick a reading came, in real time too, where it
may come late, with another one, or never.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from heave_bags.analyse.events import operator_requests
from heave_bags.analyse.reading.fields import Fields
from heave_bags.cdr.columns import Columns
from heave_bags.mcap.reader import LOG_TIME, TIME, Bag, Progress, no_progress
from heave_bags.record.provenance import SCENARIO_ATTACHMENT
from heave_bringup.errors import CommandError
from heave_node.interface import topics
from heave_node.interface.codes import SensorLevel
from heave_node.interface.sensors import MRU, SENSORS, Water, WireReading
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray
from winch_controller_node.beliefs.beliefs import latency_ticks
from winch_controller_node.interface.conversions import WINCH_STATE, measurements, winch_reading_of
from winch_controller_node.interface.readings import WinchOrder
from winch_controller_node.interface.requests import Request, request_of
from winch_controller_node.interface.sensors import INPUTS
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_studies.whatif.signals.record import Loss, SensorRecord

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
        requests=requests_in(columns.get(DIAGNOSTICS), period),
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


def requests_in(diagnostics: Columns | None, period: int) -> dict[int, tuple[Request, ...]]:
    """Return what an operator has requested of the controller, by the tick in which it found that.

    `diagnostics` are the columns of that topic, None: not recorded; `period` is that of the ticks [ns].
    """
    found: dict[int, tuple[Request, ...]] = {}
    for one in operator_requests(Fields(diagnostics)):
        requests = map(request_of, one.name.split(", "))
        tick = round(one.start * _SECOND / period)
        found[tick] = found.get(tick, ()) + tuple(request for request in requests if request is not None)
    return found


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


def scenario_text(bag: Bag) -> bytes:
    """Return the scenario that a `bag` carries; raise CommandError where there is none."""
    attached = bag.attachments.get(SCENARIO_ATTACHMENT, b"")
    content: bytes = attached if isinstance(attached, bytes) else getattr(attached, "data", b"")
    if not content:
        raise CommandError(f"{bag.path}: carries no scenario: say with --scenario what its controller assumed")
    return content


def write_text(folder: Path, content: bytes) -> Path:
    """Write the `content` of a scenario to a file in a `folder` and return it."""
    path = folder / "scenario.yaml"
    path.write_bytes(content)
    return path
