"""The drive that a winch's parameters choose."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from heave_node.parameters import ParameterError

from cable_sim_node.winch.drive_parameters.electric import ElectricDriveParameters
from cable_sim_node.winch.drive_parameters.motion import MotionParameters
from cable_sim_node.winch.drive_parameters.pump import PumpDriveParameters
from cable_sim_node.winch.drive_parameters.valve import ValveDriveParameters
from cable_sim_node.winch.drives.electric import ElectricDrive
from cable_sim_node.winch.drives.interface import Drive
from cable_sim_node.winch.drives.pump_controlled import PumpDrive
from cable_sim_node.winch.drives.ramp import RampedDrive
from cable_sim_node.winch.drives.speed_servo import SpeedServo
from cable_sim_node.winch.drives.valve_controlled import ValveDrive
from cable_sim_node.winch.parameters import WinchParameters


def make_drive(parameters: WinchParameters, tension: float) -> Drive:
    """Return the drive of a winch, at rest under a tension.

    Parameters
    ----------
    parameters : the winch; its limits, payout range and position gain are the drive's
    tension : at the drum [N]

    Raises
    ------
    ParameterError : the drive is too weak for that tension.
    """
    p = parameters
    if p.drive == "speed_servo":
        return SpeedServo(p)
    motion = _motion(p)
    try:
        if p.drive == "electric":
            own = _values(p.electric)
            limit = p.acceleration_limit
            return ElectricDrive(
                ElectricDriveParameters(**own, motion=motion, acceleration_limit=limit), tension=tension
            )
        if p.drive == "pump_controlled":
            pump = PumpDriveParameters(**_values(p.pump_controlled), motion=motion)
            return _ramped(PumpDrive(pump, tension=tension), p)
        valve = ValveDriveParameters(**_values(p.valve_controlled), motion=motion)
        return _ramped(ValveDrive(valve, tension=tension), p)
    except ValueError as error:
        raise ParameterError(
            f"drive = {p.drive} cannot hold the cable's {tension:.0f} N at the start: {error}; make it stronger"
        ) from error


def _motion(p: WinchParameters) -> MotionParameters:
    return MotionParameters(
        speed_limit=p.speed_limit,
        payout_minimum=p.payout_minimum,
        payout_maximum=p.payout_maximum,
        stop_deceleration=p.deceleration,
        position_gain=p.position_gain if p.drive == "electric" else 0.0,
    )


def _ramped(drive: Drive, p: WinchParameters) -> RampedDrive:
    return RampedDrive(
        drive,
        speed_limit=p.speed_limit,
        acceleration_limit=p.acceleration_limit,
        position_gain=p.position_gain,
    )


def _values(parameters: object) -> dict[str, Any]:
    """Return a parameter set's own fields, groups as they are."""
    return {field.name: getattr(parameters, field.name) for field in fields(parameters)}  # type: ignore[arg-type]
