"""What a winch asks of its drive, and what every drive answers.

A drive is the part between the set-points and the rope: motor, gear, drum, and the loop that makes the drum follow a
speed. It knows neither ROS nor time-outs nor encoders; those are the winch's.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple, Protocol

from heave_node.interface.codes import WinchLimit


class DriveCommand(NamedTuple):
    """Set-points, held over a step."""

    payout_rate: float = 0.0  # [m/s], positive pays out
    payout: float = 0.0  # [m]; has an effect only where the drive has a position gain
    brake: bool = False  # the service brake stops the drum at a bounded deceleration and holds it


class DriveState(NamedTuple):
    """State at the end of a step."""

    payout: float  # of the rope, positive pays out [m]
    payout_rate: float  # of the rope [m/s]
    payout_acceleration: float  # of the rope [m/s^2]
    power: float  # -tension*payout_rate at the end, positive when hauling in [W]
    supply_power: float  # drawn from the ship's supply, mean over the step [W]; negative where the drive feeds it back
    limits: WinchLimit  # limits that acted within the step
    brake: bool  # the brake holds the drum


class Drive(Protocol):
    """A drive: set-points and tension in, motion of the rope out."""

    @property
    def state(self) -> DriveState:
        """State now."""
        ...

    def instruments(self) -> Mapping[str, float]:
        """Return what the drive's own instruments read, by name with unit (`swash`, `pressure_pa`)."""
        ...

    def step(self, command: DriveCommand, duration: float, tension: float) -> DriveState:
        """Advance by `duration` [s] under a constant command and a constant tension at the drum [N].

        Raises ValueError for a duration that is not above 0, a set-point or a tension that is not finite.
        """
        ...


def check_step(command: DriveCommand, duration: float, tension: float) -> None:
    """Raise ValueError for a step that no drive makes: a `command` held for `duration` [s] under a `tension` [N]."""
    if not (math.isfinite(command.payout_rate) and math.isfinite(command.payout)):
        raise ValueError(f"set-points must be finite numbers, got {command.payout_rate} m/s and {command.payout} m")
    if not (duration > 0.0 and math.isfinite(duration)):
        raise ValueError(f"a step must last longer than 0 s, got {duration} s")
    if not math.isfinite(tension):
        raise ValueError(f"the tension at the drum must be a finite number, got {tension} N")
