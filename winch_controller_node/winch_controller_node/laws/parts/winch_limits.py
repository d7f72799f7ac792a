"""The active limits of the winch: its own, less what the controller does not use."""

from __future__ import annotations

import math
from dataclasses import dataclass

from winch_controller_node.parameters.laws import LimitParameters
from winch_controller_node.parameters.model import WinchModelParameters


@dataclass(frozen=True)
class WinchLimits:
    """Active limits: the winch's own less what the controller does not use.

    Attributes
    ----------
    speed, acceleration : largest [m/s], [m/s^2]
    payout_minimum, payout_maximum : ends of the range that is used [m]
    power : largest [W]; infinite without a limit
    minimum_tension : least tension at the top that a plan may have [N]
    maximum_tension : highest; above it the winch gives way [N]
    static_tension : while all hangs at rest [N]; NaN: not known
    """

    speed: float
    acceleration: float
    payout_minimum: float
    payout_maximum: float
    power: float = math.inf
    minimum_tension: float = 0.0
    maximum_tension: float = math.inf
    static_tension: float = math.nan

    @property
    def usual_speed(self) -> float:
        """Speed limit [m/s] under the static tension."""
        return self.speed_under(self.static_tension)

    def speed_under(self, tension: float) -> float:
        """Return the speed limit [m/s] under `tension` [N], the power limit included."""
        if not math.isfinite(self.power) or not tension > 0.0:
            return self.speed
        return min(self.speed, self.power / tension)


def winch_limits(winch: WinchModelParameters, limits: LimitParameters, static_tension: float) -> WinchLimits:
    """Return the active limits for a `winch`, of which `limits` are used, under a `static_tension` at the top [N]."""
    span = winch.payout_maximum - winch.payout_minimum
    highest = limits.maximum_tension_ratio
    margin = min(limits.payout_margin, 0.25 * span)
    return WinchLimits(
        speed=winch.speed_limit,
        acceleration=winch.acceleration_limit,
        payout_minimum=winch.payout_minimum + margin,
        payout_maximum=winch.payout_maximum - margin,
        power=winch.power_limit if winch.power_limit > 0.0 else math.inf,
        minimum_tension=limits.minimum_tension_ratio * static_tension,
        maximum_tension=highest * static_tension if highest > 0.0 else math.inf,
        static_tension=static_tension,
    )
