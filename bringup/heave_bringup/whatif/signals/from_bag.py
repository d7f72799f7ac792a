"""A record of sensors from a bag: only what a ship has is asked for, by topic and by field.

Truth of a simulator is not read: `winch/state` carries some (payout, its acceleration, tension), other topics nothing
else. A bag without them gives the same record to the last bit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from heave_bags.cdr.columns import Columns
from heave_bags.mcap.reader import LOG_TIME, TIME, Bag, Progress, no_progress
from heave_bags.record.provenance import SCENARIO_ATTACHMENT
from heave_node.interface import topics
from heave_node.interface.sensors import MRU, SENSORS, Water, WireReading
from heave_node.numerics.arrays import Array
from winch_controller_node.interface.conversions import WINCH_STATE, measurements, winch_reading_of
from winch_controller_node.interface.readings import WinchOrder, WinchReading
from winch_controller_node.interface.sensors import INPUTS
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_bringup.errors import CommandError
from heave_bringup.whatif.signals.record import SensorRecord

ORDER = ("sequence", "payout", "payout_rate", "brake")
CONTROLLER = ("mode", "depth_set_point")
WINCH, COMMAND, STATE = topics.WINCH_STATE.name, topics.WINCH_COMMAND.name, topics.CONTROLLER_STATE.name
BELIEFS = topics.CONTROLLER_BELIEFS.name

SELECTION: dict[str, tuple[str, ...]] = {
    WINCH: WINCH_STATE,
    COMMAND: ORDER,
    STATE: CONTROLLER,
    BELIEFS: ("asked",),
    **{SENSORS[name].topic.name: SENSORS[name].values for name in INPUTS},
}
"""Topics that are read of a bag, and no others: sensors, orders, and the controller's reports."""

_SECOND = 1_000_000_000


def read_record(bag: Bag, nominal: WinchControllerParameters, *, progress: Progress = no_progress) -> SensorRecord:
    """Return the record of sensors in a `bag` of a run whose controller had the `nominal` parameters.

    `progress` is called with the share of the bag that is read. Raises CommandError where the bag lacks what every
    answer needs, or is no record of a run in lockstep.
    """
    _check_topics(bag)
    period = _period(bag)
    selection = {topic: fields for topic, fields in SELECTION.items() if bag.has(topic)}
    columns = bag.columns(selection, progress=progress)
    ticks = {topic: found[LOG_TIME] // period for topic, found in columns.items()}
    orders = _orders(columns[COMMAND], ticks[COMMAND])
    first, last = min(orders), max(orders)
    given = _readings(columns, ticks)
    winches = _winches(columns[WINCH], period)
    water = Water(nominal.water_density, nominal.gravity)
    taken = tuple(measurements(given.get(tick, {}), winches.get(tick), water) for tick in range(first, last + 1))
    modes, set_points = _controller(columns.get(STATE), ticks.get(STATE), first, last)
    return SensorRecord(
        period / _SECOND,
        first,
        taken,
        tuple(orders.get(tick) for tick in range(first, last + 1)),
        set_points,
        modes,
        has_adviser=BELIEFS in columns and len(columns[BELIEFS][TIME]) > 0,
    )


def _check_topics(bag: Bag) -> None:
    """Refuse a bag without one of the topics that every answer needs."""
    needed = {
        MRU.topic.name: "the boom tip's motion is not known",
        SENSORS["depth"].topic.name: "the unit's motion is not measured, so it cannot be predicted",
        WINCH: "what the drum did is not known",
        COMMAND: "what the winch was ordered is not known",
    }
    for topic, why in needed.items():
        if not bag.has(topic):
            raise CommandError(f"{bag.path}: holds no {topic}: {why}; record it")
    if bag.has(topics.CRANE_POSE.name):
        raise CommandError(f"{bag.path}: holds {topics.CRANE_POSE.name}: of a crane that moves no answer can be given")


def _period(bag: Bag) -> int:
    """Return the tick period of the run in a `bag` [ns]; raise CommandError where it was not run in lockstep."""
    run = bag.run
    if run.get("pacing") != "lockstep":
        raise CommandError(
            f"{bag.path}: what the controller was given in each tick is known of runs in lockstep only; this bag is of "
            f"pacing {run.get('pacing') or 'unknown'}"
        )
    try:
        return round(float(run.get("tick_period_s", "")) * _SECOND)
    except ValueError as error:
        raise CommandError(f"{bag.path}: does not say its tick period") from error


def _orders(columns: Columns, ticks: Array) -> dict[int, WinchOrder]:
    """Return the order of each tick."""
    rows = zip(*(columns[name].tolist() for name in ORDER), strict=True)
    return {
        int(tick): WinchOrder(int(sequence), payout, rate, bool(brake))
        for tick, (sequence, payout, rate, brake) in zip(ticks.tolist(), rows, strict=True)
    }


def _readings(columns: Mapping[str, Columns], ticks: Mapping[str, Array]) -> dict[int, dict[str, list[WireReading]]]:
    """Return the readings that were delivered in each tick, by sensor."""
    found: dict[int, dict[str, list[WireReading]]] = {}
    for name in INPUTS:
        sensor = SENSORS[name]
        table = columns.get(sensor.topic.name)
        if table is None:
            continue
        stamps = np.rint(table[TIME] * 1e9).astype(np.int64).tolist()
        rows: Any = zip(*(table[value].tolist() for value in sensor.values), strict=True)
        for tick, stamp, numbers in zip(ticks[sensor.topic.name].tolist(), stamps, rows, strict=True):
            found.setdefault(int(tick), {}).setdefault(name, []).append(WireReading(stamp, numbers))
    return found


def _winches(columns: Columns, period: int) -> dict[int, WinchReading]:
    """Return what the winch said of itself at the start of each tick: its state is stamped with its end."""
    stamps = np.rint(columns[TIME] * 1e9).astype(np.int64).tolist()
    rows: Any = zip(*(columns[name].tolist() for name in WINCH_STATE), strict=True)
    readings = [winch_reading_of(WireReading(stamp, numbers)) for stamp, numbers in zip(stamps, rows, strict=True)]
    return {stamp // period: reading for stamp, reading in zip(stamps, readings, strict=True)}


def _controller(columns: Columns | None, ticks: Array | None, first: int, last: int) -> tuple[tuple[str, ...], Array]:
    """Return mode and mean payout of the controller in each tick, as far as it said them."""
    modes, set_points = [""] * (last - first + 1), np.full(last - first + 1, math.nan)
    if columns is not None and ticks is not None:
        for tick, mode, point in zip(
            ticks.tolist(), columns["mode"].tolist(), columns["depth_set_point"].tolist(), strict=True
        ):
            if first <= tick <= last:
                modes[int(tick) - first], set_points[int(tick) - first] = str(mode), point
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
