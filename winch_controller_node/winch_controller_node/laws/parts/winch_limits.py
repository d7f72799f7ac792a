"""The active limits of the winch: its own, less what the controller does not use."""

from __future__ import annotations

import math
from dataclasses import dataclass

from heave_core.law import put
from heave_core.law_table import ACTIVE_WINCH
from heave_core.library import new

from winch_controller_node.parameters.laws import LimitParameters
from winch_controller_node.parameters.model import WinchModelParameters


@dataclass(frozen=True)
class WinchLimits:
    """Active limits: the winch's own less what the controller does not use."""

    speed: float  # largest [m/s]
    acceleration: float  # largest [m/s^2]
    payout_minimum: float  # lower end of the range that is used [m]
    payout_maximum: float  # upper end of the range that is used [m]
    power: float = math.inf  # largest [W]; infinite without a limit
    minimum_tension: float = 0.0  # least tension at the top that a plan may have [N]
    maximum_tension: float = math.inf  # highest; above it the winch gives way [N]
    static_tension: float = math.nan  # while all hangs at rest [N]; NaN: not known

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


class ActiveWinch:
    """The winch as it is active, and its limits: what governor, law and command find in the core.

    Parameters
    ----------
    winch : the assumed one
    limits : of it; attributes both
    tick_period : [s]
    """

    def __init__(self, winch: WinchModelParameters, limits: WinchLimits, tick_period: float) -> None:
        self.record = new(ACTIVE_WINCH)  # array of one `ActiveWinch` of the core
        self._dt = tick_period
        self.take(winch, limits)

    def take(self, winch: WinchModelParameters, limits: WinchLimits) -> None:
        """Go by another `winch` and its `limits` from now on."""
        self.winch = winch
        put(
            self.record,
            {
                "is_first_order": int(winch.law == "first_order"),
                "tick_period": self._dt,
                "lag": winch.time_constant,
                "position_rate": winch.position_rate,
                "position_gain": winch.position_gain,
                "gain": winch.speed_gain,
                "hauling_gain": winch.hauling_gain,
                "creep": winch.creep,
                "reach": winch.set_point_reach,
                "tick_share": -math.expm1(-self._dt / winch.time_constant),
            },
        )
        self.take_limits(limits)

    def take_limits(self, limits: WinchLimits) -> None:
        """Keep other limits of the same winch from now on."""
        self.limits = limits
        put(
            self.record,
            {
                "speed": limits.speed,
                "acceleration": limits.acceleration,
                "power": limits.power,
                "lowest": limits.payout_minimum,
                "highest": limits.payout_maximum,
                "least_tension": limits.minimum_tension,
                "most_tension": limits.maximum_tension,
                "static_tension": limits.static_tension,
                # the set-point that gains the limit over a tick of the linear servo
                "linear_step": limits.acceleration * self._dt / self.record["tick_share"][0],
            },
        )
