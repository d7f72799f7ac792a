"""The drive that a winch's parameters choose."""

from __future__ import annotations

from heave_node.parameters import ParameterError

from cable_sim_node.winch.drives.interface import Drive
from cable_sim_node.winch.drives.speed_servo import SpeedServo
from cable_sim_node.winch.installed_drives import SERVO, installed_drives
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
    name = parameters.drive
    if name == SERVO:
        return SpeedServo(parameters)
    try:
        driven: Drive = installed_drives()[name].make(parameters, getattr(parameters, name), tension)
    except ValueError as error:
        raise ParameterError(
            f"drive = {name} cannot hold the cable's {tension:.0f} N at the start: {error}; make it stronger"
        ) from error
    return driven
