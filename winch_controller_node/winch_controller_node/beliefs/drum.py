"""The assumed winch as a drum: the nominal one of the parameters, with the values that the beliefs replace."""

from __future__ import annotations

from collections.abc import Mapping

from heave_core.watch import NO_POWER_LIMIT, Drum

from winch_controller_node.beliefs.quantities import (
    ACCELERATION_IN,
    ACCELERATION_OUT,
    BACKLASH,
    DEADBAND,
    POWER_LIMIT,
    SPEED_IN,
    SPEED_OUT,
)
from winch_controller_node.parameters.model import WinchModelParameters

QUANTITY_OF = {
    "lag": "winch.time_constant",
    "delay": "winch.command_delay",
    "gain": "winch.speed_gain",
    "hauling": "winch.hauling_gain",
    "creep": "winch.creep",
    "speed_out": SPEED_OUT,
    "speed_in": SPEED_IN,
    "acceleration_out": ACCELERATION_OUT,
    "acceleration_in": ACCELERATION_IN,
    "deadband": DEADBAND,
    "backlash": BACKLASH,
    "power": POWER_LIMIT,
}
"""Quantity of each field of `Drum`."""


def drum_of(winch: WinchModelParameters, assumed: Mapping[str, float] | None = None) -> Drum:
    """Return the drum of the nominal `winch` with the `assumed` values, by quantity, in their place."""
    drum = Drum(
        lag=winch.time_constant,
        delay=winch.command_delay,
        gain=winch.speed_gain,
        hauling=winch.hauling_gain,
        creep=winch.creep,
        speed_out=winch.speed_limit,
        speed_in=winch.speed_limit,
        acceleration_out=winch.acceleration_limit,
        acceleration_in=winch.acceleration_limit,
        reach=winch.set_point_reach,
        power=winch.power_limit if winch.power_limit > 0.0 else NO_POWER_LIMIT,
    )
    held = assumed or {}
    return drum._replace(**{name: held[quantity] for name, quantity in QUANTITY_OF.items() if quantity in held})
