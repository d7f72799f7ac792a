"""The set-point of a drive through a ramp, as winch controls have it: the drive is asked for no more acceleration.

A hydraulic drive has no reference of its own; a step of its set-point would be answered with all the pressure there is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from cable_sim_node.winch.drives.interface import Drive, DriveCommand, DriveState, check_step
from heave_node.interface.codes import WinchLimit

PART = 0.01
"""The reference moves in steps of at most this [s]."""
REFERENCE_TIME = 0.05
"""Lag of the reference behind the set-point [s], so that the steps of a command from tick to tick meet no limit."""


class RampedDrive:
    """A drive whose speed set-point moves within an acceleration limit; under the brake it follows the drum.

    Parameters
    ----------
    drive : without a position gain of its own
    speed_limit : [m/s]
    acceleration_limit : [m/s^2]
    position_gain : from payout error to speed [1/s]
    """

    def __init__(self, drive: Drive, *, speed_limit: float, acceleration_limit: float, position_gain: float) -> None:
        self._drive = drive
        self._speed_limit = speed_limit
        self._acceleration_limit = acceleration_limit
        self._gain = position_gain
        self._reference = 0.0
        self.state: DriveState = drive.state

    def instruments(self) -> Mapping[str, float]:
        """Return what the drive's own instruments read."""
        return self._drive.instruments()

    def step(self, command: DriveCommand, duration: float, tension: float) -> DriveState:
        """See `Drive.step`."""
        check_step(command, duration, tension)
        parts = math.ceil(duration / PART - 1e-9)
        limits, supplied = WinchLimit.NONE, 0.0
        for _ in range(parts):
            limits |= self._move(command, duration / parts)
            state = self._drive.step(DriveCommand(self._reference, brake=command.brake), duration / parts, tension)
            limits |= state.limits
            supplied += state.supply_power / parts
        self.state = state._replace(limits=limits, supply_power=supplied)
        return self.state

    def _move(self, command: DriveCommand, duration: float) -> WinchLimit:
        """Move the reference for `duration` [s]; return the limits that act on it."""
        state = self._drive.state
        if command.brake:
            self._reference = state.payout_rate
            return WinchLimit.NONE
        wanted = command.payout_rate + self._gain * (command.payout - state.payout)
        speed = min(max(wanted, -self._speed_limit), self._speed_limit)
        pull = (speed - self._reference) * -math.expm1(-duration / REFERENCE_TIME)
        largest = self._acceleration_limit * duration
        change = min(max(pull, -largest), largest)
        limits = WinchLimit.SPEED if speed != wanted else WinchLimit.NONE
        if change != pull:
            limits |= WinchLimit.ACCELERATION
        self._reference += change
        return limits
