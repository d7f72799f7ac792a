"""The bag of a lift, judged phase by phase: phases are found by the depth of the unit, in the order of the study.

A ship's bag has no truth. Depth is then that of the depth sensor, loads are those of the load cell, and the strength of
the parts is the scenario's. What these cannot tell stays unknown, and is said of each criterion.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from heave_bags.analyse.kpi_set import evaluate
from heave_bags.analyse.run_record import TRUE, RunRecord
from heave_bags.analyse.verdict import FAILED, PASSED, Judged
from heave_bags.signals import RunSignals, Signal
from heave_bringup.scenarios import Scenario
from heave_node.criteria import Criterion
from heave_node.loads.strength import strengths
from heave_node.numerics.arrays import Array
from heave_node.numerics.constants import STANDARD_GRAVITY
from heave_node.parameters import ParameterError, flatten
from scipy.ndimage import uniform_filter1d
from scipy.signal import savgol_filter

from heave_studies.study.phases import Phase

NOT_REACHED, IN_PART = "not in the bag", "passed in part"
ENDS = 0.5
"""Distance from the depth of its end at which a phase is done [m]."""
WAVES = 20.0
"""Length of the running mean that takes the waves out of the depth [s]."""
SHORTEST = 5.0
"""Time that a phase must have in the bag to be judged [s]."""
LINE = 60.0
"""Length of the running straight line, applied twice, about which a depth sensor shows the heave of the unit [s]."""
OF_UNIT = ("unit_sigma_m", "significant_residual_m", "max_abs_heave_m")
OVER_STATIC = ("dynamic_amplification", "tension_ratio_min")


@dataclass(frozen=True)
class AsBuilt:
    """What became of a phase."""

    phase: Phase  # of the lift
    start: float = math.nan  # in the bag [s]; NaN: not in it
    end: float = math.nan  # in the bag [s]; NaN: not in it
    judged: tuple[Judged, ...] = ()  # its criteria; a value that the bag cannot tell is NaN

    @property
    def state(self) -> str:
        """The verdict in words."""
        if math.isnan(self.start):
            return NOT_REACHED
        if self.failures:
            return FAILED
        return PASSED if all(one.is_met for one in self.judged) else IN_PART

    @property
    def failures(self) -> list[str]:
        """What is missed, in words."""
        return [f"{self.phase.name}: {one}" for one in self.judged if not (one.is_met or math.isnan(one.value))]

    def to_json(self) -> dict[str, object]:
        """Return it as plain data."""
        return {
            "phase": self.phase.name,
            "state": self.state,
            "start_s": self.start,
            "end_s": self.end,
            "criteria": [one.to_json() for one in self.judged],
        }


def as_built(
    phases: Sequence[Phase], criteria: Mapping[str, Sequence[Criterion]], scenario: Scenario, record: RunRecord
) -> list[AsBuilt]:
    """Return what became of each phase of a lift in the bag of it.

    Parameters
    ----------
    phases : of the lift
    criteria : of each, by its name
    scenario : of its study
    record : of the bag

    Raises ParameterError for a bag without the depth of the unit, or with none of the phases.
    """
    height = record.signals.unit_height
    if height.size < 2:
        raise ParameterError(
            f"{record.name}: does not say how deep the unit is (unit/odometry or unit/pressure), by which phases are "
            "found"
        )
    width = max(round(WAVES / float(np.median(np.diff(height.time)))), 1)
    depth = -uniform_filter1d(height.value, width, mode="nearest")
    plant, winch = (flatten(scenario.parameters[node]) for node in ("cable_sim", "virtual_winch"))
    signals = replace(record.signals, strengths=strengths(plant, winch))
    period = scenario.parameters["wave_vessel"].peak_period
    reach = 0.0 if record.sources.get("unit height", TRUE) == TRUE else _reach_of_waves(period)
    found, after = [], record.start
    for phase in phases:
        start, end = _window(phase, height.time, depth, after)
        if not end - start >= SHORTEST:
            found.append(AsBuilt(phase))
            continue
        values = _values(signals, phase, start, end, reach)
        judged = tuple(Judged(one, values[one.kpi]) for one in criteria[phase.name])
        found.append(AsBuilt(phase, start, end, judged))
        after = end
    if all(math.isnan(one.start) for one in found):
        seen = f"{depth.min():.0f} to {depth.max():.0f} m"
        raise ParameterError(f"{record.name}: its unit is at {seen} depth, where the lift has no phase")
    return found


def _reach_of_waves(period: float) -> float:
    """Return half the length of waves of a `period` [s], below which a depth sensor does not notice them [m]."""
    return STANDARD_GRAVITY * period**2 / (4.0 * math.pi)


def _values(signals: RunSignals, phase: Phase, start: float, end: float, reach: float) -> dict[str, float]:
    """Return every figure of a phase; NaN for what `signals` cannot tell: heave within the `reach` of waves [m]."""
    tension, height = (one.window(start, end) for one in (signals.tension, signals.unit_height))
    signals = replace(signals, static_tension=_static(signals, phase, tension))
    if not signals.unit_heave.size:
        signals.unit_heave = Signal(height.time, _about_line(height))
    values = evaluate(signals, start, end)
    if min(phase.does.depth) < reach:
        values.update(dict.fromkeys(OF_UNIT, math.nan))
    if phase.crosses_surface and not signals.static_tension.size:
        values.update(dict.fromkeys(OVER_STATIC, math.nan))
    if not signals.slack.size and values["slack_percent"] == 0.0:  # a load cell knows the top alone
        values["slack_percent"] = math.nan
    return values


def _static(signals: RunSignals, phase: Phase, tension: Signal) -> Signal:
    """Return the tension at rest of a phase: that of the start of a bag may be the weight in air.

    Through the surface the weight at the start is what loads are compared with: of a ship, while the unit is above
    water.
    """
    if phase.crosses_surface:
        dry = tension.value[signals.unit_height.at(tension) > 0.0] if signals.unit_height.size else tension.value
        is_told = signals.static_tension.size or not dry.size
        return signals.static_tension if is_told else Signal(tension.time[:1], np.array([np.median(dry)]))
    static = signals.static_at(tension)
    return Signal(tension.time, static + float(np.median(tension.value - static)) if tension.size else static)


def _about_line(height: Signal) -> Array:
    """Return the heave of a unit that is lowered: its height about a straight line that runs along it [m]."""
    length = min(round(LINE / float(np.median(np.diff(height.time)))), height.size)
    length -= 1 - length % 2
    slow = savgol_filter(savgol_filter(height.value, length, 1), length, 1)
    return np.asarray(height.value - slow)


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
