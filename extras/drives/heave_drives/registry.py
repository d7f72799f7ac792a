"""The drives as `virtual_winch.drive` chooses them: each is an entry point of `heave.drives`."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any

from cable_sim_node.winch.installed_drives import DriveEntry

from heave_drives.parameters import (
    ElectricDriveParameters,
    ElectricParameters,
    MotionParameters,
    PumpControlledParameters,
    PumpDriveParameters,
    ValveControlledParameters,
    ValveDriveParameters,
)

if TYPE_CHECKING:
    from cable_sim_node.winch.drives.interface import Drive
    from cable_sim_node.winch.parameters import WinchParameters


def _make_electric(winch: WinchParameters, own: ElectricParameters, tension: float) -> Drive:
    from heave_drives.electric import ElectricDrive  # noqa: PLC0415 - compiles: only where it is chosen

    motion, limit = _motion(winch, winch.position_gain), winch.acceleration_limit
    parameters = ElectricDriveParameters(**_values(own), motion=motion, acceleration_limit=limit)
    return ElectricDrive(parameters, tension=tension)


def _make_pump(winch: WinchParameters, own: PumpControlledParameters, tension: float) -> Drive:
    from heave_drives.pump_controlled import PumpDrive  # noqa: PLC0415

    return _ramped(PumpDrive(PumpDriveParameters(**_values(own), motion=_motion(winch)), tension=tension), winch)


def _make_valve(winch: WinchParameters, own: ValveControlledParameters, tension: float) -> Drive:
    from heave_drives.valve_controlled import ValveDrive  # noqa: PLC0415

    return _ramped(ValveDrive(ValveDriveParameters(**_values(own), motion=_motion(winch)), tension=tension), winch)


ELECTRIC = DriveEntry(ElectricParameters, _make_electric, lambda winch, own: own.spool.check_rope(winch.payout_maximum))
# hydraulic drives refuse nothing beside their own parameters
PUMP_CONTROLLED = DriveEntry(PumpControlledParameters, _make_pump, lambda *_: None)
VALVE_CONTROLLED = DriveEntry(ValveControlledParameters, _make_valve, lambda *_: None)


def _motion(winch: WinchParameters, position_gain: float = 0.0) -> MotionParameters:
    return MotionParameters(
        speed_limit=winch.speed_limit,
        payout_minimum=winch.payout_minimum,
        payout_maximum=winch.payout_maximum,
        stop_deceleration=winch.deceleration,
        position_gain=position_gain,
    )


def _ramped(drive: Drive, winch: WinchParameters) -> Drive:
    from heave_drives.ramp import RampedDrive  # noqa: PLC0415

    return RampedDrive(
        drive,
        speed_limit=winch.speed_limit,
        acceleration_limit=winch.acceleration_limit,
        position_gain=winch.position_gain,
    )


def _values(parameters: object) -> dict[str, Any]:
    """Return a parameter set's own fields, groups as they are."""
    return {field.name: getattr(parameters, field.name) for field in fields(parameters)}  # type: ignore[arg-type]
