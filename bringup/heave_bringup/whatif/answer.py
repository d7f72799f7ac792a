"""Figures of what would have been, each with its band."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from heave_node.interface.codes import WinchLimit
from heave_node.kpi import efficiency, significant
from heave_node.numerics.arrays import Array
from winch_controller_node.supervision.modes import Mode

from heave_bringup.whatif.signals.disturbance import Disturbance
from heave_bringup.whatif.twin.replay import Replayed

LOST = (Mode.FADE_OUT.value, Mode.STOPPING.value, Mode.STOPPED.value, Mode.EMERGENCY_STOP.value)
"""Modes of a loop that has given up compensation."""

COVERED = 1.645
"""Half the width of a band of 90 % over a standard deviation."""

MODEL_LEAST, MODEL_MOST = 0.004, 0.04
"""Relative error of the twin in what it adds to a record: at least that of its mesh and drag; at most as stated."""

KEYS = (
    "unit_efficiency",
    "unit_sigma_m",
    "significant_residual_m",
    "tension_min_n",
    "tension_max_n",
    "winch_speed_max_mps",
    "winch_acceleration_max_mps2",
    "time_at_limit_percent",
)
"""Figures that are given, by their names as figures of merit."""


@dataclass(frozen=True)
class Figures:
    """Figures of one loop, by the names in KEYS.

    Attributes
    ----------
    values : as predicted
    bands : of 90 %, lower and upper end
    unit : heave of the unit about its mean depth at each tick of the window (n,) [m]
    lost_at : time at which compensation was given up [s]; infinite: never
    cause : alarm with which it was
    """

    values: Mapping[str, float]
    unit: Array = field(repr=False)
    bands: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    lost_at: float = math.inf
    cause: str = ""


def unit_motion(done: Replayed, unexplained: Disturbance) -> Array:
    """Return the heave of the unit about its mean depth at each tick [m]: of the twin as `done`, and `unexplained`."""
    return np.asarray(done.unit + done.set_point + unexplained.heave)


def figures(
    done: Replayed,
    unexplained: Disturbance,
    tension: Array,
    *,
    window: slice,
    uncompensated: float,
    tick_period: float,
) -> Figures:
    """Return the figures of a loop, still without bands.

    Parameters
    ----------
    done : what it did
    unexplained : motion of the unit in the record
    tension : at the top at each tick [N]; NaN where it is not known
    window : ticks that are judged
    uncompensated : standard deviation of the unit with the winch locked [m]
    tick_period : [s]
    """
    unit = unit_motion(done, unexplained)[window]
    sigma = math.hypot(float(np.std(unit)), unexplained.left)
    rate = done.rate[window]
    limits = done.limits_hit[window] & int(~WinchLimit.PAYOUT)
    top = tension[window]
    is_known = bool(np.isfinite(top).all())
    values = {
        "unit_efficiency": efficiency(sigma, uncompensated),
        "unit_sigma_m": sigma,
        "significant_residual_m": significant(sigma),
        "tension_min_n": float(top.min()) if is_known else math.nan,
        "tension_max_n": float(top.max()) if is_known else math.nan,
        "winch_speed_max_mps": float(np.abs(rate).max()),
        "winch_acceleration_max_mps2": float(np.abs(np.diff(rate)).max()) / tick_period,
        "time_at_limit_percent": 100.0 * float(np.mean(limits != 0)),
    }
    lost_at, cause = lost(done)
    return Figures(values, unit, {}, lost_at, cause)


def lost(done: Replayed) -> tuple[float, str]:
    """Return when a loop, as `done`, gave up compensation that had begun [s], and by which alarm; infinite: never."""
    has_begun = False
    for index, mode in enumerate(done.modes):
        has_begun |= mode == Mode.COMPENSATING.value
        if has_begun and mode in LOST:
            time = done.time[index]
            near = [alarm.brief for at, alarm in done.alarms if abs(at - time) < 1.0]
            return float(time), near[0] if near else mode
    return math.inf, ""


def with_bands(
    base: Figures, draws: Sequence[Figures], *, added: float, model: float, uncompensated: tuple[float, float]
) -> Figures:
    """Return figures with their bands: the spread of draws of what is not known, and the twin's own error.

    Parameters
    ----------
    base : as predicted
    draws : the same with other plants that the record allows
    added : standard deviation of the motion that the twins add to the record [m]
    model : relative error of the twins in it [-]
    uncompensated : standard deviation of the unit with the winch locked, and that of this figure [m]
    """
    bands: dict[str, tuple[float, float]] = {}
    # a t distribution of so few draws is wider than a normal one
    width = COVERED * (1.0 + 1.5 / max(len(draws), 1))
    for key, value in base.values.items():
        spread = _spread(value, [one.values[key] for one in draws])
        bands[key] = (value - width * spread, value + width * spread)
    sigma = base.values["unit_sigma_m"]
    spread = width * _spread(sigma, [one.values["unit_sigma_m"] for one in draws])
    error = COVERED * model * added
    above = math.hypot(sigma, error) - sigma + 0.5 * error
    below = min(0.5 * error, 0.5 * sigma)
    low, high = max(sigma - math.hypot(spread, below), 0.0), sigma + math.hypot(spread, above)
    bands["unit_sigma_m"] = (low, high)
    bands["significant_residual_m"] = (significant(low), significant(high))
    off, off_sigma = uncompensated
    ratio = sigma / off if off > 0.0 else math.nan
    by_off = COVERED * ratio * off_sigma / off if off > 0.0 else math.nan
    bands["unit_efficiency"] = (
        1.0 - ratio - math.hypot((high - sigma) / off, by_off) if off > 0.0 else math.nan,
        1.0 - ratio + math.hypot((sigma - low) / off, by_off) if off > 0.0 else math.nan,
    )
    return Figures(base.values, base.unit, bands, base.lost_at, base.cause)


def _spread(value: float, others: Sequence[float]) -> float:
    """Return the standard deviation of `others` about a `value`; 0 where there are none."""
    return math.sqrt(float(np.mean((np.array(others) - value) ** 2))) if others else 0.0
