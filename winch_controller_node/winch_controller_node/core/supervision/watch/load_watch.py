"""Alarms of the load and of the winch: a slack cable, too much tension, a winch that is at its limits too long."""

from __future__ import annotations

import math

from heave_node.interface.alarm import Alarm
from heave_node.loads.strength import ROPE, Strength, strengths
from heave_node.parameters import flatten

from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.laws import AlarmParameters

QUIET_TIME = 60.0
"""An alarm is given again only after its cause was away for so long [s]: the groups of a swell are one cause."""

PUSH = -0.1
"""Share of the static tension below which no cable is slack: it cannot push."""


def rope_strength(parameters: WinchControllerParameters) -> Strength | None:
    """Return what the rope of the `parameters` can bear, with the safety factor required; None: not stated."""
    return next((one for one in strengths(flatten(parameters), {}) if one.key == ROPE), None)


class Episode:
    """Reports the beginning of something that comes and goes.

    Parameters
    ----------
    tick_period : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._quiet_time = QUIET_TIME

    def begins(self, is_there: bool) -> bool:
        """Take in whether it `is_there` in this tick; return whether an episode begins with it."""
        was_quiet = self._quiet_time >= QUIET_TIME
        self._quiet_time = 0.0 if is_there else self._quiet_time + self._dt
        return is_there and was_quiet


class LoadWatch:
    """Watches the tension at the top, and how much of the time the winch is at its limits.

    Parameters
    ----------
    parameters : thresholds
    tick_period : [s]
    rope : breaking force and required safety factor; None: not stated
    """

    def __init__(self, parameters: AlarmParameters, *, tick_period: float, rope: Strength | None = None) -> None:
        self._parameters, self._rope = parameters, rope
        self._weight = tick_period / parameters.saturation_time
        self._slack, self._over, self._saturated = (Episode(tick_period) for _ in range(3))
        self._short, self._overloaded = Episode(tick_period), Episode(tick_period)
        self._share_at_limit = 0.0

    def update(self, tension: float, static_tension: float, *, is_at_limit: bool) -> tuple[Alarm, ...]:
        """Return what has just become wrong.

        Parameters
        ----------
        tension : newest reading at the top [N]; NaN before the first
        static_tension : under the hanging unit at rest [N]
        is_at_limit : a limit of the winch's speed, acceleration or power acts
        """
        parameters = self._parameters
        self._share_at_limit += self._weight * (float(is_at_limit) - self._share_at_limit)
        share = tension / static_tension if math.isfinite(tension) and static_tension > 0.0 else 1.0
        found = []
        if self._slack.begins(share < parameters.slack_ratio):
            is_pushed = share < PUSH
            found.append(
                ALARMS.alarm("LOAD_CELL_NEGATIVE", tension=1e-3 * tension)
                if is_pushed
                else ALARMS.alarm("CABLE_SLACK", tension=1e-3 * tension, percent=100.0 * share)
            )
        if self._over.begins(0.0 < parameters.tension_ratio < share):
            limit = parameters.tension_ratio
            found.append(ALARMS.alarm("TENSION_HIGH", tension=1e-3 * tension, ratio=share, limit=limit))
        if self._saturated.begins(self._share_at_limit > parameters.saturation_share):
            percent, time = 100.0 * self._share_at_limit, parameters.saturation_time
            found.append(ALARMS.alarm("WINCH_SATURATED", percent=percent, time=time))
        return (*found, *self._check_rope(tension))

    def _check_rope(self, tension: float) -> list[Alarm]:
        """Return that a `tension` [N] is more than the rope can bear, or leaves it too small a safety factor."""
        if self._rope is None:
            return []
        check = self._rope.under(tension)
        given = {"tension": 1e-3 * tension, "factor": check.factor, "capacity": 1e-3 * self._rope.capacity}
        found = []
        if self._short.begins(check.is_short):
            found.append(ALARMS.alarm("ROPE_SAFETY_LOW", **given, required=self._rope.required))
        if self._overloaded.begins(check.is_overloaded):
            found.append(ALARMS.alarm("ROPE_OVERLOADED", **given))
        return found
