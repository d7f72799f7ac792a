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

SEEN_SHARE = 0.5
"""Share of the window after which waves have been seen."""

SLOW_MEAN_FACTOR = 3.0
"""The mean about which motion is judged is followed this many times more slowly than the variance."""

PEAK = 3.0
"""Peak amplitude over standard deviation of a sea, over some minutes."""

SIGNIFICANT = 2.0
"""Significant amplitude over standard deviation of a narrow-banded sea."""

GROUP_PEAK = 2.2
"""Peak amplitude over standard deviation within a group of high waves."""

GROWING_PEAK = 2.35
"""Peak amplitude over standard deviation of the last waves of a growing sea: the next ones are higher."""

FIRST_LOOK = 120.0
"""Time for which a sea may be seen to grow [s]: later on, the earlier record shows whether it does."""

CONSTANTS = {
    "catch_up_time": 15.0,  # the law has to catch up with what it missed
    "left_over_time": 30.0,  # that of a sudden stop, or one not seen
    "largest_left_over": 2.0,
    "restart": 0.1,
    "beyond": 0.02,
    "out_of_reach": 2.0,
    "swing_work": 2.0,
    "least_authority": 0.5,
    "slow_mean": SLOW_MEAN_FACTOR,
    "detrend_time": 5.0,
    "full_share": 0.95,
    "peak": PEAK,
    "significant": SIGNIFICANT,
    "highest_time": 300.0,  # some thirty waves, of which one is above the significant amplitude
    "group_time": 8.0,
    "group_peak": GROUP_PEAK,
    "growing": 4.0,
    "growing_peak": GROWING_PEAK,
    "largest_demand": 1.4,
    "unshown": 10.0,
    "worth": 0.01,
}
"""Constants of the guard: meanings and units are in the core's table, GUARD_DESIGN."""


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
    """Return the values of the core's GuardDesign, of its `parameters`, the watched `loop` and a `tick_period` [s]."""
    limits, effort, first_look = loop.limits, loop.effort, round(FIRST_LOOK / tick_period)
    floor, seen_time = FLOOR_FACTOR * parameters.floor, SEEN_SHARE * parameters.window
    checks = {"swing": SWING, "depth": DEPTH, "mismatch": MISMATCH}
    return {
        "tick_period": tick_period,
        "window": parameters.window,
        "seen_ticks": round(seen_time / tick_period),
        "seen_time": seen_time,
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
        **CONSTANTS,
        "largest_step": STEPS["depth_step"],
        "step_sigmas": STEPS["sigmas"],
        "step_speed": STEPS["depth_speed"],
        "harm_ratio": parameters.harm_ratio,
        "floor": parameters.floor,
        "first_look": first_look,
        "knot_ticks": max(1, math.ceil(first_look / (KNOTS - 1))),
        "limit_use": parameters.limit_use,
        "keeps_limits": loop.keeps_limits,
    }
