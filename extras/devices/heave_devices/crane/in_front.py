"""The crane in front of the controller: the MRU of the boom tip goes in, and the lift is asked for as a move.

The mean payout is asked to be carried along at v = l' + (l - m) / tau, for a lift l of which it has made up m: so the
unit keeps its depth. Governor, range and envelope see it as they see every move, and it has an operator's share of the
winch. What the boom moves while the winch stands comes back slowly once the winch compensates.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from heave_node.crane.pose import CranePose
from heave_node.interface.alarm import Alarm
from winch_controller_node.core.component import WinchController
from winch_controller_node.core.operator_requests import OPERATED
from winch_controller_node.core.supervision.modes import loop_words
from winch_controller_node.in_front import MotionSourceEntry
from winch_controller_node.interface.readings import Measurements, Outputs, WinchReading
from winch_controller_node.motion.mean_motion import RETURN_SPEED

from heave_devices.crane.pose_watch import ALARMS
from heave_devices.crane.tip_carry import TipCarry

CATCH_UP = 2.0
"""Time tau in which what the winch is behind the lift is made up for [s]."""

SWING_MEMORY = 60.0
"""Time in which the largest swing of the drum for the sea fades from memory [s]: some waves of a swell."""

LEAST_LEFT = 0.1
"""Lift that is not made up for below which no alarm is given [m]: what the drum's lag leaves of a lift that starts."""


class CraneInFront:
    """A crane that moves, in front of a `controller` with ticks of `tick_period` [s]; `carry` has its boom tip."""

    def __init__(self, controller: WinchController, tick_period: float) -> None:
        parameters = controller.parameters
        self._controller, self._dt = controller, tick_period
        self._is_fitted, self._delay = parameters.crane.is_fitted, parameters.winch.command_delay
        self.carry = TipCarry(parameters.crane, parameters.sensors.mru)
        self._swing = self._left_over = 0.0
        self._reported = ""

    def step(self, tick: int, measurements: Measurements, poses: Sequence[CranePose] = ()) -> Outputs:
        """Do tick k of the controller with the `measurements` delivered at it, and `poses` of the crane."""
        now = tick * self._dt
        if not self._is_fitted:
            alarms = self._refused(poses)
        else:
            measurements = self.carry.carried(now, measurements, poses)
            alarms = self.carry.pose.news()
            if self.carry.place is not None:
                alarms += self._ask_for_lift(now, measurements.winch)
        outputs = self._controller.step(tick, measurements)
        if not alarms:
            return outputs
        does = loop_words(self._controller.mode, is_damped_blind=False)
        return outputs._replace(alarms=(*(alarm.reported(does) for alarm in alarms), *outputs.alarms))

    def health(self) -> Mapping[str, tuple[bool, str]]:
        """Return how it is with the pose; nothing before one has come."""
        pose = self.carry.pose
        return {"crane": (not pose.fault, pose.words)} if pose.has_come or pose.fault else {}

    def _refused(self, poses: Sequence[CranePose]) -> list[Alarm]:
        """Return the alarm of `poses` that come for a crane without lengths, once."""
        if not poses or self._reported:
            return []
        self._reported = "lengths"
        return [ALARMS.alarm("CRANE_LENGTHS_MISSING")]

    def _ask_for_lift(self, now: float, winch: WinchReading | None) -> list[Alarm]:
        """Have the mean payout go with the lift of `now` [s]; return the alarm where it cannot.

        `winch` is its state as read, by which it is known how much of the range compensation needs.
        """
        (lift, rate), controller = self.carry.lift(now), self._controller
        behind, payout = lift - controller.carried, controller.mean.point.payout + controller.carried
        self._swing *= 1.0 - self._dt / SWING_MEMORY
        if winch is not None and math.isfinite(winch.encoder_payout):
            self._swing = max(self._swing, abs(winch.encoder_payout - payout))
        if controller.mode not in OPERATED:
            self._left_over = behind
            return []
        self._left_over = math.copysign(max(abs(self._left_over) - RETURN_SPEED * self._dt, 0.0), self._left_over)
        wanted = rate + (behind - self._left_over + rate * self._delay) / CATCH_UP
        asked, bounds = controller.carry_mean(wanted, self._swing)
        if abs(behind - self._left_over) < LEAST_LEFT:
            self._reported = ""
        elif abs(wanted) > bounds.speed and not self._reported:
            self._reported = "speed"
            return [ALARMS.alarm("CRANE_TOO_FAST", rate=abs(rate), limit=bounds.speed)]
        elif asked != min(max(wanted, -bounds.speed), bounds.speed) and self._reported != "range":
            self._reported = "range"
            end, remedy = (bounds.payout_maximum, "raise") if behind > 0.0 else (bounds.payout_minimum, "lower")
            return [ALARMS.alarm("CRANE_BEYOND_RANGE", payout=payout + behind, limit=end, raise_or_lower=remedy)]
        return []


CRANE = MotionSourceEntry(CraneInFront, ALARMS)
"""The crane, for `heave.motion_sources`."""
