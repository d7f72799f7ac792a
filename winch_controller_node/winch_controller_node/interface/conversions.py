"""What was delivered to measurements, and outputs to messages. No rclpy: message classes are plain data."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from heave_msgs.msg import CompensationKpi, ControllerState, SensorHealth, WinchCommand
from heave_node.interface.preview import HeavePreview
from heave_node.interface.sensors import MRU, SENSORS, Water, WireReading, mru_reading
from heave_node.tick.tick import nanoseconds_of
from std_msgs.msg import Header

from winch_controller_node.interface.readings import (
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


def winch_reading(state: Any, nanoseconds: int) -> WinchReading:
    """Return what the winch measures of itself at a time, `nanoseconds` [ns]; the truth in the state is not looked at.

    `state` is a heave_msgs/WinchState or the virtual winch's own, which has the same names.
    """
    return WinchReading(
        time=nanoseconds * 1e-9,
        encoder_payout=state.encoder_payout,
        encoder_payout_rate=state.encoder_payout_rate,
        brake=state.brake,
        fault=int(state.fault),
        command_sequence=state.command_sequence,
        limits_hit=int(state.limits_hit),
    )


def heave_preview(message: Any) -> HeavePreview:
    """Return what a heave_msgs/HeavePreview, the `message`, tells; whether it can be used is judged later."""
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
) -> Measurements:
    """Return what came in a tick, read by the water that the controller believes in.

    Parameters
    ----------
    delivered : readings as they travelled, by sensor; those that the controller does not know are left out
    winch : newest state of the winch; None: none came
    water : believed in
    preview : newest one of the boom tip; None: none came
    """
    mru = tuple(mru_reading(reading) for reading in delivered.get(MRU.name, ()))
    scalar = {
        name: tuple(_scalar(name, reading, water) for reading in delivered[name])
        for name in SCALAR_SENSORS
        if delivered.get(name)
    }
    return Measurements(mru, scalar, winch, preview)


def _scalar(name: str, reading: WireReading, water: Water) -> ScalarReading:
    known = _KNOWN[name]
    value = SENSORS[name].from_wire(reading, water)[known.component]
    return ScalarReading(reading.time, value - water.gravity if known.includes_gravity else value)


def command_message(order: WinchOrder, stamp: Time) -> WinchCommand:
    """Return the `order` to the winch as a message of `stamp`."""
    return WinchCommand(
        header=Header(stamp=stamp),
        sequence=order.sequence,
        payout=order.payout,
        payout_rate=order.payout_rate,
        brake=order.brake,
    )


def state_message(report: Report, stamp: Time) -> ControllerState:
    """Return the `report` of what the controller believes and does as a message of `stamp`."""
    return ControllerState(
        header=Header(stamp=stamp),
        mode=report.mode,
        law=report.law,
        reason=report.reason,
        state_names=list(report.state_names),
        estimate=report.estimate,
        covariance_diagonal=report.covariance_diagonal,
        measurement_names=list(report.measurement_names),
        innovation=report.innovation,
        innovation_sigma=report.innovation_sigma,
        nis=report.nis,
        gain=report.gain,
        predicted_unit_heave=report.predicted_unit_heave,
        predicted_boom_tip_heave=report.predicted_boom_tip_heave,
        predicted_uncompensated_heave=report.predicted_uncompensated_heave,
        payout_set_point=report.payout_set_point,
        payout_rate_set_point=report.payout_rate_set_point,
        depth_set_point=report.depth_set_point,
        authority=report.authority,
        active_limits=list(report.active_limits),
        solver_status=report.solver_status,
        solver_iterations=report.solver_iterations,
        sensors=[_health_message(sensor) for sensor in report.sensors],
    )


def _health_message(sensor: SensorState) -> SensorHealth:
    return SensorHealth(
        sensor=sensor.sensor,
        level=sensor.level,
        reason=sensor.reason,
        age=sensor.age if math.isfinite(sensor.age) else math.nan,
        accepted=sensor.accepted,
        refused=sensor.refused,
    )


def kpi_message(kpi: RollingKpi, stamp: Time) -> CompensationKpi:
    """Return the rolling figures of merit `kpi` as a message of `stamp`."""
    return CompensationKpi(
        header=Header(stamp=stamp),
        window=kpi.window,
        unit_sigma=kpi.unit_sigma,
        uncompensated_sigma=kpi.uncompensated_sigma,
        boom_tip_sigma=kpi.boom_tip_sigma,
        unit_efficiency=kpi.unit_efficiency,
        outlet_efficiency=kpi.outlet_efficiency,
        significant_residual=kpi.significant_residual,
        max_abs_heave=kpi.max_abs_heave,
        winch_speed_max=kpi.winch_speed_max,
        winch_acceleration_max=kpi.winch_acceleration_max,
        power_peak=kpi.power_peak,
        power_mean=kpi.power_mean,
        tension_min=kpi.tension_min,
        tension_max=kpi.tension_max,
        time_at_limit=kpi.time_at_limit,
    )
