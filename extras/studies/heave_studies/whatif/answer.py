"""Figures of what would have been, each with its band."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from heave_bags.analyse.events import words
from heave_node.interface.codes import COMPENSATION_LOST, MODE_CHANGED, WinchLimit
from heave_node.kpi import efficiency, significant
from heave_node.numerics.arrays import Array
from winch_controller_node.core.supervision.modes import Mode

from heave_studies.whatif.signals.record import Flags, without_move
from heave_studies.whatif.signals.smoother import Disturbance
from heave_studies.whatif.twin.replay import Replayed

MODES = (MODE_CHANGED, COMPENSATION_LOST)
"""Codes of alarms that report a mode, and not why."""

COVERED = 1.645
"""Half the width of a band of 90 % over a standard deviation."""

MODEL_LEAST, MODEL_MOST = 0.004, 0.04
"""Relative error of the twin in what it adds to a record: at least that of its mesh and drag; at most as stated."""

Band = tuple[float, float]
"""Lower and upper end."""

COUNTED = int(~WinchLimit.PAYOUT)
"""Limits of the winch that count as such: not the ends of its cable."""

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

POSSIBLE = {"unit_efficiency": (-math.inf, 1.0), "time_at_limit_percent": (0.0, 100.0)}
"""Least and largest that a figure can be; 0 and infinity for the others."""


@dataclass(frozen=True)
class Figures:
    """Figures of one loop, by the names in KEYS."""

    values: Mapping[str, float]  # as predicted
    unit: Array = field(repr=False)  # heave of the unit about its mean depth at each tick of the window (n,) [m]
    bands: Mapping[str, Band] = field(default_factory=dict)  # of 90 %, lower and upper end
    lost_at: float = math.inf  # time at which compensation was given up [s]; infinite: never
    cause: str = ""  # alarm with which it was

    def beside(self, base: Figures) -> dict[str, float]:
        """Return by how much each figure is other than that of a `base`."""
        return {key: value - base.values[key] for key, value in self.values.items()}


def unit_motion(done: Replayed, unexplained: Disturbance) -> Array:
    """Return the heave of the unit about its mean depth at each tick [m]: of the twin as `done`, and `unexplained`."""
    return without_move(done.time, done.unit + done.set_point + unexplained.heave, done.set_point)


def figures(
    done: Replayed,
    unit: Array,
    tension: Array,
    *,
    sigma: float,
    window: slice,
    uncompensated: float,
    tick_period: float,
) -> Figures:
    """Return the figures of a loop, still without bands.

    Parameters
    ----------
    done : what it did
    unit : its motion about its mean depth at each tick (n,) [m]
    tension : at the top at each tick [N]; NaN where it is not known
    sigma : standard deviation of that motion, with what is not known of it [m]
    window : ticks that are judged
    uncompensated : standard deviation of the unit with the winch locked [m]
    tick_period : [s]
    """
    rate = done.rate[window]
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
        "time_at_limit_percent": 100.0 * float(np.mean((done.limits_hit[window] & COUNTED) != 0)),
    }
    lost_at, cause = lost(done)
    return Figures(values, unit[window], {}, lost_at, cause)


def limit_words(flags: Flags) -> str:
    """Return the limits of the winch that acted in any of some ticks, given as sums of `flags`; empty: none."""
    acted = int(np.bitwise_or.reduce(flags, initial=0)) & COUNTED
    return " and ".join(words(one) for one in WinchLimit if one & acted)


def lost(done: Replayed) -> tuple[float, str]:
    """Return when a loop, as `done`, gave up compensation unrequested [s], and by which alarm; infinite: never.

    One that never began has given up at its first alarm.
    """
    for time, lost_one in done.alarms:
        if lost_one.code == COMPENSATION_LOST:
            near = [one for at, one in done.alarms if abs(at - time) < 1.0 and one.code not in MODES]
            return time, near[0].brief if near else str(lost_one.values["reason"])
    has_begun = Mode.COMPENSATING.value in done.modes or set(done.modes) <= {Mode.OFF.value, ""}
    if has_begun:
        return math.inf, ""
    causes = [(time, f"it never began: {one.brief}") for time, one in done.alarms if one.code not in MODES]
    return causes[0] if causes else (float(done.time[0]), "it never began")


@dataclass(frozen=True)
class Spread:
    """What bands are made of."""

    # what changes in the figures where the loop is closed over other plants and winches that the record allows
    loops: Sequence[Mapping[str, float]]
    # what changes in them where the same payout acts on other plants that it allows
    plants: Sequence[Mapping[str, float]]
    added: float  # standard deviation of the motion that the twins add to the record [m]
    locked: float  # the same of the winch locked [m]
    model: float  # relative error of the twins in both [-]

    def half(self, key: str) -> float:
        """Return half the width of a band of the figure `key`, by what the record allows."""
        # a t distribution of so few draws is wider than a normal one
        widths = [
            COVERED * (1.0 + 1.5 / len(draws)) * _rms([one[key] for one in draws])
            for draws in (self.loops, self.plants)
            if draws
        ]
        return max(widths, default=0.0)


def with_bands(base: Figures, spread: Spread, uncompensated: float, by_tip: float = 0.0) -> Figures:
    """Return figures with their bands: the spread of what is not known, and the twin's own error.

    What is not known of the boom tip was added to the motion; it may as well be nothing.

    Parameters
    ----------
    base : as predicted
    spread : of it
    uncompensated : standard deviation of the unit with the winch locked [m]
    by_tip : the same of what is not known of the boom tip, in the figures [m]
    """
    bands = {}
    for key, value in base.values.items():
        half = spread.half(key)
        bands[key] = (value - half, value + half)
    sigma, error = base.values["unit_sigma_m"], COVERED * spread.model * spread.added
    without_tip = math.sqrt(max(sigma**2 - by_tip**2, 0.0))
    above = math.hypot(sigma, error) - sigma + 0.5 * error
    below = math.hypot(min(0.5 * error, 0.5 * sigma), sigma - without_tip)
    half = spread.half("unit_sigma_m")
    low, high = sigma - math.hypot(half, below), sigma + math.hypot(half, above)
    bands["unit_sigma_m"], bands["significant_residual_m"] = (low, high), (significant(low), significant(high))
    value = base.values["unit_efficiency"]
    if uncompensated > 0.0:
        half = spread.half("unit_efficiency")
        by_off = COVERED * spread.model * spread.locked * (1.0 - value) / uncompensated
        bands["unit_efficiency"] = (
            value - math.hypot(half, above / uncompensated, by_off),
            value + math.hypot(half, below / uncompensated, by_off),
        )
    return Figures(base.values, base.unit, possible(bands), base.lost_at, base.cause)


def possible(bands: Mapping[str, Band]) -> dict[str, Band]:
    """Return the part of some `bands` in which their figures can be."""
    found = {}
    for key, (low, high) in bands.items():
        least, largest = POSSIBLE.get(key, (0.0, math.inf))
        found[key] = (max(low, least), min(high, largest))
    return found


def _rms(values: Sequence[float]) -> float:
    """Return the root of the mean square of `values`."""
    return math.sqrt(float(np.mean(np.square(values))))
