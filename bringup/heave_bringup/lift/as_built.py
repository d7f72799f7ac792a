"""The bag of a lift, judged phase by phase: phases are found by the depth of the unit, in the order of the plan."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from heave_bags.analyse.kpi_set import evaluate
from heave_bags.analyse.run_record import RunRecord
from heave_bags.analyse.verdict import FAILED, PASSED, Judged
from heave_bags.signals import RunSignals, Signal
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError
from scipy.ndimage import uniform_filter1d

from heave_bringup.lift.plan import SURFACE, Phase, Plan

NOT_REACHED = "not in the bag"
ENDS = 0.5
"""Distance from the depth of its end at which a phase is done [m]."""
WAVES = 20.0
"""Length of the running mean that takes the waves out of the depth [s]."""
SHORTEST = 5.0
"""Time that a phase must have in the bag to be judged [s]."""


@dataclass(frozen=True)
class AsBuilt:
    """What became of a phase.

    Attributes
    ----------
    phase : of the plan
    start, end : in the bag [s]; NaN: it is not in it
    values : every figure of merit of that time
    judged : its criteria
    """

    phase: Phase
    start: float = math.nan
    end: float = math.nan
    values: Mapping[str, float] = field(default_factory=dict)
    judged: tuple[Judged, ...] = ()

    @property
    def state(self) -> str:
        """The verdict in a word: passed, FAILED, or not in the bag."""
        if math.isnan(self.start):
            return NOT_REACHED
        return PASSED if all(one.is_met for one in self.judged) else FAILED

    @property
    def failures(self) -> list[str]:
        """What is missed, in words."""
        return [f"{self.phase.name}: {one}" for one in self.judged if not one.is_met]

    def to_json(self) -> dict[str, object]:
        """Return it as plain data."""
        return {
            "phase": self.phase.name,
            "state": self.state,
            "start_s": self.start,
            "end_s": self.end,
            "criteria": [one.to_json() for one in self.judged],
        }


def as_built(plan: Plan, record: RunRecord) -> list[AsBuilt]:
    """Return what became of each phase of a `plan` in the `record` of a bag.

    Raises ParameterError for a bag without the depth of the unit, or with none of the phases.
    """
    height = record.signals.unit_height
    if height.size < 2:
        raise ParameterError(
            f"{record.name}: does not say how deep the unit is (unit/odometry), by which phases are found"
        )
    width = max(round(WAVES / float(np.median(np.diff(height.time)))), 1)
    depth = -uniform_filter1d(height.value, width, mode="nearest")
    found, after = [], record.start
    for phase in plan.phases:
        start, end = _window(phase, height.time, depth, after)
        if end - start < SHORTEST:
            found.append(AsBuilt(phase))
            continue
        values = evaluate(_with_static(record.signals, phase, start, end), start, end)
        judged = tuple(Judged(one, values.get(one.kpi, math.nan)) for one in phase.criteria)
        found.append(AsBuilt(phase, start, end, values, judged))
        after = end
    if all(math.isnan(one.start) for one in found):
        reach = f"{depth.min():.0f} to {depth.max():.0f} m"
        raise ParameterError(f"{record.name}: its unit is at {reach} depth, where {plan.path} has no phase")
    return found


def _with_static(signals: RunSignals, phase: Phase, start: float, end: float) -> RunSignals:
    """Return `signals` with the tension at rest of this phase: that of the start of a bag may be the weight in air.

    Through the surface the weight at the start is what loads are compared with, as in the plan.
    """
    tension = signals.tension.window(start, end)
    if phase.kind == SURFACE or not tension.size:
        return signals
    static = signals.static_at(tension)
    return replace(signals, static_tension=Signal(tension.time, static + float(np.median(tension.value - static))))


def _window(phase: Phase, time: Array, depth: Array, after: float) -> tuple[float, float]:
    """Return when a phase begins and ends, from `after` on: within its depths, until the depth of its end [s]."""
    first, last = phase.does.depth
    low, high = min(first, last) - ENDS, max(first, last) + ENDS
    inside = (time >= after) & (depth >= low) & (depth <= high)
    begun = np.flatnonzero(inside)
    if not begun.size:
        return math.nan, math.nan
    start = int(begun[0])
    left = np.flatnonzero(~inside[start:])
    end = start + (int(left[0]) if left.size else inside.size - start) - 1
    if first != last:
        done = np.flatnonzero(np.abs(depth[start : end + 1] - last) <= ENDS)
        end = start + int(done[0]) if done.size else end
    else:
        end = min(end, int(np.searchsorted(time, time[start] + phase.duration)))
    return float(time[start]), float(time[end])


def failures(found: Sequence[AsBuilt]) -> list[str]:
    """Return what the phases that were `found` miss, in words."""
    return [words for one in found for words in one.failures]
