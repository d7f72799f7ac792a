"""Messages to the controller's readings, and its outputs to messages. No rclpy: message classes are plain data."""

from __future__ import annotations

import math
from collections.abc import Iterable

from builtin_interfaces.msg import Time
from geometry_msgs.msg import TwistWithCovarianceStamped
from heave_msgs.msg import (
    CompensationKpi,
    ControllerState,
    LoadCell,
    MruSample,
    SensorHealth,
    WinchCommand,
    WinchState,
)
from heave_node.constants import ATMOSPHERIC_PRESSURE
from heave_node.tick.tick import seconds_of
from sensor_msgs.msg import FluidPressure, Imu
from std_msgs.msg import Header

from winch_controller_node.interface.readings import (
    MruReading,
    Report,
    RollingKpi,
    ScalarReading,
    SensorState,
    WinchOrder,
    WinchReading,
)


def mru_readings(samples: Iterable[MruSample]) -> tuple[MruReading, ...]:
    """Return the MRU's samples as readings."""
    return tuple(
        MruReading(
            time=seconds_of(sample.header.stamp),
            heave=sample.heave,
            heave_rate=sample.heave_rate,
            roll=sample.roll,
            pitch=sample.pitch,
            status=sample.status,
            sequence=sample.sequence,
        )
        for sample in samples
    )


def depth_readings(
    messages: Iterable[FluidPressure], water_density: float, gravity: float
) -> tuple[ScalarReading, ...]:
    """Return depths, positive down [m], from absolute pressures."""
    per_metre = water_density * gravity
    return tuple(
        ScalarReading(seconds_of(message.header.stamp), (message.fluid_pressure - ATMOSPHERIC_PRESSURE) / per_metre)
        for message in messages
    )


def velocity_readings(messages: Iterable[TwistWithCovarianceStamped]) -> tuple[ScalarReading, ...]:
    """Return vertical velocities, positive up [m/s]."""
    return tuple(ScalarReading(seconds_of(message.header.stamp), message.twist.twist.linear.z) for message in messages)


def imu_readings(messages: Iterable[Imu], gravity: float) -> tuple[ScalarReading, ...]:
    """Return vertical accelerations, positive up, from the specific force [m/s^2]."""
    return tuple(
        ScalarReading(seconds_of(message.header.stamp), message.linear_acceleration.z - gravity) for message in messages
    )


def load_cell_readings(messages: Iterable[LoadCell]) -> tuple[ScalarReading, ...]:
    """Return top tensions [N]."""
    return tuple(ScalarReading(seconds_of(message.header.stamp), message.tension) for message in messages)


def winch_reading(message: WinchState) -> WinchReading:
    """Return what the winch measures of itself; the truth in the message is not looked at."""
    return WinchReading(
        time=seconds_of(message.header.stamp),
        encoder_payout=message.encoder_payout,
        encoder_payout_rate=message.encoder_payout_rate,
        brake=message.brake,
        fault=message.fault,
        command_sequence=message.command_sequence,
        limits_hit=message.limits_hit,
    )


def command_message(order: WinchOrder, stamp: Time) -> WinchCommand:
    """Return the order to the winch."""
    return WinchCommand(
        header=Header(stamp=stamp),
        sequence=order.sequence,
        payout=order.payout,
        payout_rate=order.payout_rate,
        brake=order.brake,
    )


def state_message(report: Report, stamp: Time) -> ControllerState:
    """Return what the controller believes and does."""
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
    """Return the rolling figures of merit."""
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
