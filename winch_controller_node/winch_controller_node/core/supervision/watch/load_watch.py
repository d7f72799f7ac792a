"""Alarms of the load and of the winch: a slack cable, too much tension, a winch that is at its limits too long."""

from __future__ import annotations

import math
from collections.abc import Mapping

from heave_core.watch import LoadRecord
from heave_core.watch_table import LoadNews
from heave_node.interface.alarm import Alarm, Value
from heave_node.loads.strength import LEAST, ROPE, Strength, safety_factor, strengths
from heave_node.parameters import flatten

from winch_controller_node.core.supervision.landing import LEAST_RATE
from winch_controller_node.core.supervision.modes import Mode
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

    `tick_period` : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._quiet_time = QUIET_TIME

    def begins(self, is_there: bool) -> bool:
        """Take in whether it `is_there` in this tick; return whether an episode begins with it."""
        was_quiet = self._quiet_time >= QUIET_TIME
        self._quiet_time = 0.0 if is_there else self._quiet_time + self._dt
        return is_there and was_quiet


def watched(parameters: AlarmParameters, rope: Strength | None, tick_period: float) -> dict[str, float]:
    """Return the values of the core's LoadWatchDesign, of its `parameters` and a `tick_period` [s].

    `rope` : breaking force and required safety factor; None: not stated
    """
    return {
        "tick_period": tick_period,
        "quiet_time": QUIET_TIME,
        "slack_ratio": parameters.slack_ratio,
        "tension_ratio": parameters.tension_ratio,
        "saturation_time": parameters.saturation_time,
        "saturation_share": parameters.saturation_share,
        "capacity": math.nan if rope is None else rope.capacity,
        "required": math.nan if rope is None else rope.required,
        "least": LEAST,
    }


class LoadWatch:
    """Watches the tension at the top, and how much of the time the winch is at its limits, in C++ (load_watch.cpp).

    Parameters
    ----------
    parameters : thresholds
    tick_period : [s]
    rope : breaking force and required safety factor; None: not stated
    travel : bound on that of constant tension [m]
    """

    def __init__(
        self,
        parameters: AlarmParameters,
        *,
        tick_period: float,
        rope: Strength | None = None,
        travel: float = math.inf,
    ) -> None:
        self._parameters, self._rope, self._travel = parameters, rope, travel
        self._core = LoadRecord(watched(parameters, rope, tick_period))
        self.records = self._core.records  # of the core, by name

    def alarms(
        self, found: int, tension: float, static_tension: float, rate: float = 0.0, mode: Mode = Mode.STANDBY
    ) -> tuple[Alarm, ...]:
        """Return the alarms of what was `found`.

        Parameters
        ----------
        found : bits of LoadNews
        tension : newest reading at the top [N]; NaN before the first
        static_tension : under the hanging unit at rest [N]
        rate, mode : of the mean payout, positive lowers [m/s]; of the tick
        """
        if not found:
            return ()
        kilo, parameters = 1e-3 * tension, self._parameters
        share = tension / static_tension if static_tension > 0.0 else 1.0
        percent = 100.0 * float(self._core.state["at_limit"][0])
        remedy = "Check the load" if mode in (Mode.COMPENSATING, Mode.CONSTANT_TENSION) else "Compensate"
        remedy = "Lower more slowly" if rate >= LEAST_RATE else remedy
        slack: tuple[str, Mapping[str, Value]] = (
            ("SENSOR_DOUBTFUL, LOAD_CELL: negative", {"tension": kilo})
            if share < PUSH
            else ("CABLE_SLACK", {"tension": kilo, "percent": 100.0 * share, "lower_more_slowly_or_compensate": remedy})
        )
        capacity, required = (0.0, 0.0) if self._rope is None else (self._rope.capacity, self._rope.required)
        rope = {"tension": kilo, "factor": safety_factor(capacity, tension), "capacity": 1e-3 * capacity}
        news: dict[LoadNews, tuple[str, Mapping[str, Value]]] = {
            LoadNews.SLACK: slack,
            LoadNews.TENSION_HIGH: (
                "TENSION_HIGH",
                {"tension": kilo, "ratio": share, "limit": parameters.tension_ratio},
            ),
            LoadNews.SATURATED: ("WINCH_SATURATED", {"percent": percent, "time": parameters.saturation_time}),
            LoadNews.ROPE_SHORT: ("ROPE_SAFETY_LOW", {**rope, "required": required}),
            LoadNews.ROPE_OVERLOADED: ("ROPE_OVERLOADED", rope),
            LoadNews.TRAVEL_HALF: ("TENSION_TRAVEL: half", {"travel": 0.5 * self._travel}),
            LoadNews.TRAVEL_END: ("TENSION_TRAVEL: end", {"travel": self._travel}),
        }
        return tuple(ALARMS.alarm(code, **values) for bit, (code, values) in news.items() if found & bit)
