"""What a run leaves, and the figures that are judged. Formulas of `heave_node.kpi`, by way of `kpi_set`."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from heave_bags.analyse import kpi_set
from heave_bags.signals import RunSignals
from heave_node import kpi
from heave_node.numerics.arrays import Array

FIGURES = (
    "unit_sigma_m",
    "uncompensated_sigma_m",
    "max_abs_heave_m",
    "largest_error_m",
    "tension_ratio_min",
    "dynamic_amplification",
    "slack_percent",
    "snaps",
    "uncompensated_snaps",
    "winch_speed_max_mps",
    "winch_acceleration_max_mps2",
    "time_at_limit_percent",
    "power_peak_w",
    "energy_wh_per_h",
    "touchdown_speed_mps",
    "lift_offs",
)
"""Figures of a run, by the names of the KPI set where they are in it. `largest_error_m` is the largest distance of the
unit from where the operator wants it, a mean error included; it is known where the rope does not stretch."""

STANDS = 0.5
"""Contact that is lost for longer than this is a lift-off, not a rebound [s]."""


@dataclass
class Outcome:
    """A run.

    Attributes
    ----------
    time : of the samples [s], shape (n,), equally spaced
    signals : what the KPI set is computed from
    error : distance of the unit from where it is wanted, positive up [m]; empty where it cannot be known
    bottom_force, unit_rate : for landings, empty where there is no bottom
    landing_end : until then the unit must stay landed once it has landed [s]
    """

    time: Array
    signals: RunSignals
    error: Array = field(default_factory=lambda: np.empty(0))
    bottom_force: Array = field(default_factory=lambda: np.empty(0))
    unit_rate: Array = field(default_factory=lambda: np.empty(0))
    landing_end: float = math.inf


def figures_of(outcome: Outcome, start: float, end: float) -> dict[str, float]:
    """Return the figures of `outcome` over the window start..end [s]; NaN for what a case does not have."""
    values = kpi_set.evaluate(outcome.signals, start, end)
    chosen = {name: values.get(name, math.nan) for name in FIGURES}
    inside = (outcome.time >= start) & (outcome.time <= end)
    if outcome.error.size:
        chosen["largest_error_m"] = float(np.abs(outcome.error[inside]).max())
    if np.any(outcome.bottom_force > 0.0):
        chosen["touchdown_speed_mps"], chosen["lift_offs"] = _landing(outcome)
    return chosen


def _landing(outcome: Outcome) -> tuple[float, float]:
    """Return the speed at the first touch [m/s], and how often the unit left the bottom before it should."""
    stands = outcome.bottom_force > 0.0
    first = int(np.argmax(stands))
    judged = (outcome.time >= outcome.time[first]) & (outcome.time < outcome.landing_end)
    period = float(outcome.time[1] - outcome.time[0])
    runs = np.diff(np.concatenate(([0], (~stands[judged]).astype(int), [0])))
    begins, ends = np.flatnonzero(runs == 1), np.flatnonzero(runs == -1)
    return abs(float(outcome.unit_rate[max(first - 1, 0)])), float(np.sum((ends - begins) * period > STANDS))


def is_lost(figures: dict[str, float]) -> bool:
    """Return whether compensation was harmful by the `figures` of a run: more motion than without, or added snaps."""
    ratio = kpi.worse([figures["unit_sigma_m"]], [figures["uncompensated_sigma_m"]])
    added = figures["snaps"] > figures["uncompensated_snaps"]
    return not ratio <= 1.0 or bool(added)
