"""How much of the winch the crane's lift may use, and the alarms of a lift that needs more."""

from __future__ import annotations

from heave_node.interface.alarm import Alarm

from winch_controller_node.crane.lift import LiftBounds
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.parameters.crane import CraneModelParameters

SWING_MEMORY = 60.0
"""Time in which the largest swing of the drum for the sea fades from memory [s]: some waves of a swell."""

LEAST_LEFT = 0.1
"""Lift that is not made up for below which no alarm is given [m]: what the drum's lag leaves of a lift that starts."""


class LiftRoom:
    """Shares the winch between the crane's lift and compensation.

    Parameters
    ----------
    parameters : of the crane: shares of speed and acceleration
    tick_period : [s]
    """

    def __init__(self, parameters: CraneModelParameters, tick_period: float) -> None:
        self._parameters = parameters
        self._dt = tick_period
        self._swing = 0.0
        self._reported = ""
        self._news: list[Alarm] = []

    def news(self) -> list[Alarm]:
        """Return what has changed since the last call."""
        news, self._news = self._news, []
        return news

    def bounds(self, limits: WinchLimits, mean: float, swing: float) -> LiftBounds:
        """Return what the lift may use.

        Parameters
        ----------
        limits : active ones of the winch
        mean : mean payout, without that for the lift [m]
        swing : of the drum about it, by compensation [m]
        """
        self._swing = max(abs(swing), self._swing * (1.0 - self._dt / SWING_MEMORY))
        kept = min(self._swing, 0.5 * (limits.payout_maximum - limits.payout_minimum))
        return LiftBounds(
            self._parameters.lift_speed_share * limits.usual_speed,
            self._parameters.lift_acceleration_share * limits.acceleration,
            limits.payout_minimum + kept - mean,
            limits.payout_maximum - kept - mean,
        )

    def watch(self, bound: str, left: float, rate: float, bounds: LiftBounds, mean: float) -> None:
        """Give an alarm where a bound keeps the winch from making up for the lift, once until it has caught up.

        Parameters
        ----------
        bound : "speed", "range" or empty
        left : lift that the winch has not made up for [m]
        rate : at which the crane lifts the boom tip [m/s]
        bounds : of the lift
        mean : mean payout, without that for the lift [m]
        """
        if abs(left) < LEAST_LEFT:
            self._reported = ""
        elif bound == "speed" and not self._reported:
            self._reported = bound
            self._news.append(ALARMS.alarm("CRANE_TOO_FAST", rate=abs(rate), limit=bounds.speed))
        elif bound == "range" and self._reported != bound:
            self._reported = bound
            end = bounds.highest if left > 0.0 else bounds.lowest
            remedy = "raise" if left > 0.0 else "lower"
            values = {"payout": mean + end + left, "limit": mean + end}
            self._news.append(ALARMS.alarm("CRANE_BEYOND_RANGE", **values, raise_or_lower=remedy))
