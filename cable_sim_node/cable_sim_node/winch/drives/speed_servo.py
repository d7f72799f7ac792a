"""The speed servo of the virtual winch behind the interface of the drives: ideal, without mass, losses or supply.

v' = clip((v_set - v)/T, acceleration_limit), v_set = clip(payout_rate + k_p (payout - u), speed_limit), solved by
`cable_sim_node.winch.drive`. What the rope takes or gives the supply gives or takes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from heave_node.interface.codes import WinchLimit

from cable_sim_node.winch import drive
from cable_sim_node.winch.drives.interface import DriveCommand, DriveState, check_step
from cable_sim_node.winch.parameters import WinchParameters


class SpeedServo:
    """The servo, at rest. Of the parameters those of brake, faults, delay and encoder are the winch's, not used here.

    Parameters
    ----------
    parameters : the winch
    """

    def __init__(self, parameters: WinchParameters) -> None:
        self._p = parameters
        self._settings = drive.as_array(drive.settings_of(parameters))
        self._time = 0.0
        self.state = DriveState(0.0, 0.0, 0.0, 0.0, 0.0, WinchLimit.NONE, False)

    def instruments(self) -> Mapping[str, float]:
        """Return nothing: the servo has no insides."""
        return {}

    def step(self, command: DriveCommand, duration: float, tension: float) -> DriveState:
        """See `Drive.step`."""
        check_step(command, duration, tension)
        p, before, settings = self._p, self.state, self._settings
        if p.drift.duration > 0.0:
            settings = drive.as_array(drive.drifted(drive.settings_of(p), p.drift, self._time))
        self._time += duration
        mode = drive.FOLLOW_SPEED if p.law == "speed_servo" else drive.FOLLOW_POSITION
        if command.brake:
            mode = drive.HOLD if before.payout_rate == 0.0 else drive.STOP
        power_speed = p.power_limit / tension if p.power_limit > 0.0 and tension > 0.0 else math.inf
        payout, rate, acceleration, limits = drive.advance_drum(
            before.payout,
            before.payout_rate,
            duration,
            mode,
            command.payout,
            command.payout_rate,
            power_speed,
            settings,
        )
        moved = payout - before.payout
        brake = command.brake and rate == 0.0
        supply = -tension * moved / duration
        acted = WinchLimit(limits) if limits else WinchLimit.NONE
        self.state = DriveState(payout, rate, acceleration, -tension * rate, supply, acted, brake)
        return self.state
