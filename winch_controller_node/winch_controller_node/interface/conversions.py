"""What was delivered to measurements, and outputs to serialised messages.

Each table names the fields of a message, which are those of the plain data too.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import fields
from operator import attrgetter
from typing import Any

import numpy as np
from heave_node.cdr.packer import Packer
from heave_node.interface import topics
from heave_node.interface.preview import HeavePreview
from heave_node.interface.sensors import MRU, SENSORS, Water, WireReading, mru_reading
from heave_node.tick.tick import nanoseconds_of

from winch_controller_node.interface.readings import (
    ON_TIME,
    Lateness,
    Measurements,
    Report,
    RollingKpi,
    ScalarReading,
    SensorState,
    WinchOrder,
    WinchReading,
)
from winch_controller_node.interface.sensors import SCALAR_SENSORS, KnownSensors

_KNOWN = KnownSensors().by_name()


WINCH_STATE = ("encoder_payout", "encoder_payout_rate", "brake", "fault", "command_sequence", "limits_hit")
"""Fields that the winch measures; the truth in its state is not read."""
_winch_values = attrgetter(*WINCH_STATE)

_ORDER_FIELDS = WinchOrder._fields
_order_values = attrgetter(*_ORDER_FIELDS)
_COMMAND = Packer(topics.WINCH_COMMAND.type, ("header.stamp", *_ORDER_FIELDS))

_REPORT_FIELDS = tuple(name for name in Report._fields if name not in ("sensors", "is_inhibited"))
_report_values = attrgetter(*_REPORT_FIELDS)
_STATE = Packer(topics.CONTROLLER_STATE.type, ("header.stamp", "sensors", "execution_time", *_REPORT_FIELDS))

_KPI_FIELDS = tuple(field.name for field in fields(RollingKpi))
_kpi_values = attrgetter(*_KPI_FIELDS)
_KPI = Packer(topics.CONTROLLER_KPI.type, ("header.stamp", *_KPI_FIELDS))


def winch_reading(state: Any, nanoseconds: int) -> WinchReading:
    """Return what the winch measures of itself, by the `state` of the virtual winch at a time, `nanoseconds` [ns]."""
    return winch_reading_of(WireReading(nanoseconds, _winch_values(state)))


def winch_reading_of(reading: WireReading) -> WinchReading:
    """Return the state in a `reading` of the fields WINCH_STATE."""
    payout, rate, brake, fault, sequence, limits = reading.numbers
    return WinchReading(reading.time, payout, rate, bool(brake), int(fault), int(sequence), int(limits))


def winch_order_of(reading: WireReading) -> WinchOrder:
    """Return the command in a `reading` of the fields of a WinchOrder."""
    sequence, payout, rate, brake, mean = reading.numbers
    return WinchOrder(int(sequence), payout, rate, bool(brake), mean)


def heave_preview(message: Any) -> HeavePreview:
    """Return the preview in a heave_msgs/HeavePreview, the `message`; whether it can be used is decided later."""
    return HeavePreview(
        np.asarray(message.ahead, dtype=float),
        np.asarray(message.heave, dtype=float),
        nanoseconds_of(message.header.stamp),
    )


def measurements(
    delivered: Mapping[str, Iterable[WireReading]],
    winch: WinchReading | None,
    water: Water,
    preview: HeavePreview | None = None,
    lateness: Lateness = ON_TIME,
) -> Measurements:
    """Return what came in a tick, converted with the water that the controller assumes.

    Parameters
    ----------
    delivered : readings as they travelled, by sensor; those that the controller does not know are left out
    winch : newest state of the winch; None: none came
    water : assumed
    preview : newest one of the boom tip; None: none came
    lateness : of the ticks
    """
    mru = tuple(mru_reading(reading) for reading in delivered.get(MRU.name, ()))
    scalar = {
        name: tuple(_scalar(name, reading, water) for reading in delivered[name])
        for name in SCALAR_SENSORS
        if delivered.get(name)
    }
    return Measurements(mru, scalar, winch, preview, lateness)


def _scalar(name: str, reading: WireReading, water: Water) -> ScalarReading:
    known = _KNOWN[name]
    value = SENSORS[name].from_wire(reading, water)[known.component]
    return ScalarReading(reading.time, value - water.gravity if known.includes_gravity else value)


def command_message(order: WinchOrder, stamp: int) -> bytes:
    """Return the `order` to the winch as a message of `stamp` [ns]."""
    return _COMMAND.pack(stamp, *_order_values(order))


def state_message(report: Report, stamp: int, execution_time: float = math.nan) -> bytes:
    """Return the `report` of the controller's estimates and actions as a message of `stamp` [ns].

    `execution_time` is the wall time that it took [s].
    """
    sensors = [_health(sensor) for sensor in report.sensors]
    return _STATE.pack(stamp, sensors, execution_time, *_report_values(report))


def _health(sensor: SensorState) -> tuple[str, int, str, float, int, int]:
    """Return the fields of heave_msgs/SensorHealth in their order."""
    age = sensor.age if math.isfinite(sensor.age) else math.nan
    return (sensor.sensor, sensor.level, sensor.reason, age, sensor.accepted, sensor.refused)


def kpi_message(kpi: RollingKpi, stamp: int) -> bytes:
    """Return the rolling figures of merit `kpi` as a message of `stamp` [ns]."""
    return _KPI.pack(stamp, *_kpi_values(kpi))
