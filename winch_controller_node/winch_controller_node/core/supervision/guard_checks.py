"""What the guard goes by: the loop that it watches, and when drum, unit and sea are too much (see guard.cpp)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from heave_core.look_table import KNOTS

from winch_controller_node.core.estimation.sense_design import STEPS
from winch_controller_node.laws.parts.effort import Effort
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.parameters.laws import GuardParameters


class AmplitudeLimit(NamedTuple):
    """When an amplitude is too large."""

    time: float  # memory of the amplitude [s]
    ratio: float  # largest amplitude over that of the reference [-]
    floor: float = math.inf  # amplitude that is never too large, in its unit


DRUM = AmplitudeLimit(time=2.0, ratio=1.5, floor=0.1)
"""Speed of the drum that is not intended, against that of the boom tip [m/s]."""

SWING = AmplitudeLimit(time=3.0, ratio=1.2)
"""Swing of the unit against the uncompensated one [m]; the floor of this and the next two follows `guard.floor`."""

DEPTH = AmplitudeLimit(time=6.0, ratio=1.3)
"""Heave that the depth sensor reads against the uncompensated one [m]."""

MISMATCH = AmplitudeLimit(time=8.0, ratio=0.8)
"""Depth sensor less estimate, against the uncompensated heave [m]."""

FLOOR_FACTOR = 10.0
"""Multiple of `guard.floor` below which these checks ignore heave: that is left to the comparison over waves."""

CATCH_UP_TIME = 15.0
"""Time that the drum is not checked after a lost sensor is back [s]: the law has to catch up with what it missed."""

LEFT_OVER_TIME = 30.0
"""Time in which compensation has to take out a swing that it has found [s]: that of a sudden stop, or one not seen."""

LARGEST_LEFT_OVER = 2.0
"""Largest swing that compensation may find, over the uncompensated one."""

RESTART = 0.1
"""Rest of the last allowance at which a swing that waves have left is allowed again."""

BEYOND = 0.02
"""A sea is beyond the winch's limits where so much of the largest speed is missing."""

OUT_OF_REACH = 2.0
"""Allowed error of the drum's speed at its limits, over that of a drum that follows the intended speed within them."""

SWING_WORK = 2.0
"""Speed of the drum that stops a swinging unit, over the speed of the unit."""

LEAST_AUTHORITY = 0.5
"""The drum is checked against this share of the boom tip's speed at least."""

FULL_SHARE = 0.95
"""Share of the wanted authority from which on compensation is judged over waves."""

SEEN_SHARE = 0.5
"""Share of the window after which waves have been seen."""

SLOW_MEAN_FACTOR = 3.0
"""The mean about which motion is judged is followed this many times more slowly than the variance."""

DETREND_TIME = 5.0
"""Time constant with which the mean of a sensor's heave is followed [s]."""

PEAK = 3.0
"""Peak amplitude over standard deviation of a sea, over some minutes."""

SIGNIFICANT = 2.0
"""Significant amplitude over standard deviation of a narrow-banded sea."""

HIGHEST_TIME = 300.0
"""Memory of the highest crest [s]: some thirty waves, of which one is above the significant amplitude."""

GROUP_TIME, GROUP_PEAK = 8.0, 2.2
"""Memory that sees a group of high waves come [s], and peak amplitude over standard deviation within one."""

GROWING = 4.0
"""A sea grows if the later half of what was seen of it has so many times the energy of the earlier half."""

GROWING_PEAK = 2.35
"""Peak amplitude over standard deviation of its last waves then: the next ones are higher."""

FIRST_LOOK = 120.0
"""Time for which that is asked [s]: from then on the earlier record distinguishes the two."""

LARGEST_DEMAND = 1.4
"""Demand of the sea's share over the winch that a law is given which keeps the limits by itself."""

UNSHOWN = 10.0
"""Variance of errors in compensation, over that with the winch locked, while the unit has not shown how large it is."""

WORTH = 0.01
"""Least residual that is worth less authority, over the motion with the winch locked."""


@dataclass(frozen=True)
class GuardedLoop:
    """What the guard must know of the loop it watches."""

    limits: WinchLimits  # of the winch
    effort: Effort = field(default_factory=Effort)  # of the law
    inertia: float = 0.0  # a of the two-state cable [s^2]; 0: unknown
    feeds_back_unit: bool = True  # the law feeds the unit's motion back, so that the loop can become unstable
    keeps_limits: bool = False  # it keeps the winch's limits by itself
    fade_time: float = 10.0  # shortest time over which authority goes from 0 to 1 or back [s]


def guard_design(parameters: GuardParameters, loop: GuardedLoop, tick_period: float) -> dict[str, Any]:
    """Return the values of the core's GuardDesign.

    Parameters
    ----------
    parameters : window, ratio, floor, use of the limits
    loop : that is watched
    tick_period : [s]
    """
    limits, effort, first_look = loop.limits, loop.effort, round(FIRST_LOOK / tick_period)
    floor, seen_time = FLOOR_FACTOR * parameters.floor, SEEN_SHARE * parameters.window
    checks = {"swing": SWING, "depth": DEPTH, "mismatch": MISMATCH}
    return {
        "tick_period": tick_period,
        "window": parameters.window,
        "seen_ticks": round(seen_time / tick_period),
        "seen_time": seen_time,
        "slow_mean": SLOW_MEAN_FACTOR,
        "speed": limits.speed,
        "usual_speed": limits.usual_speed,
        "acceleration": limits.acceleration,
        "effort_speed": effort.speed,
        "effort_acceleration": effort.acceleration,
        "rate_error": effort.rate_error,
        "inertia": loop.inertia,
        "fade_time": loop.fade_time,
        "feeds_back": loop.feeds_back_unit,
        "drum": DRUM._asdict(),
        **{name: limit._replace(floor=floor)._asdict() for name, limit in checks.items()},
        "catch_up_time": CATCH_UP_TIME,
        "left_over_time": LEFT_OVER_TIME,
        "largest_left_over": LARGEST_LEFT_OVER,
        "restart": RESTART,
        "beyond": BEYOND,
        "out_of_reach": OUT_OF_REACH,
        "swing_work": SWING_WORK,
        "least_authority": LEAST_AUTHORITY,
        "detrend_time": DETREND_TIME,
        "largest_step": STEPS["depth_step"],
        "step_sigmas": STEPS["sigmas"],
        "step_speed": STEPS["depth_speed"],
        "full_share": FULL_SHARE,
        "harm_ratio": parameters.harm_ratio,
        "floor": parameters.floor,
        "peak": PEAK,
        "significant": SIGNIFICANT,
        "highest_time": HIGHEST_TIME,
        "group_time": GROUP_TIME,
        "group_peak": GROUP_PEAK,
        "growing": GROWING,
        "growing_peak": GROWING_PEAK,
        "first_look": first_look,
        "knot_ticks": max(1, math.ceil(first_look / (KNOTS - 1))),
        "limit_use": parameters.limit_use,
        "largest_demand": LARGEST_DEMAND,
        "keeps_limits": loop.keeps_limits,
        "unshown": UNSHOWN,
        "worth": WORTH,
    }
