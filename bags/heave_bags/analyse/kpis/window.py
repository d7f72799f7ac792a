"""A part of a run, and what several figures of merit take from it. Pure numpy; the formulas are `heave_node.kpi`'s."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cached_property

import numpy as np
from heave_node import kpi
from heave_node.interface.codes import WinchLimit
from heave_node.loads.cycles import LoadCycles, load_cycles
from heave_node.loads.strength import ROPE, safety_factor
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray

from heave_bags.analyse.kpis.definition import NOT_KNOWN, largest
from heave_bags.signals import RunSignals, Signal

AFTER_CHANGE = 10.0
"""Time after a change of mode that counts to it [s]."""


class Window:
    """The part of a `run` from `start` to `end` [s], both included, and what several KPIs take from it, worked out
    once.
    """

    def __init__(self, run: RunSignals, start: float, end: float) -> None:
        self.run = run
        self.start = start
        self.end = end
        self.heave = self.of(run.unit_heave).value
        self.uncompensated_heave = self.of(run.uncompensated_heave).value
        self.tension = self.of(run.tension)
        self.peak_tension = self.of(run.peak_tension())
        self.rate = self.of(run.payout_rate)
        self.acceleration = self.of(run.payout_acceleration).value

    def of(self, signal: Signal) -> Signal:
        """Return the part of a signal that lies in the window."""
        return signal.window(self.start, self.end)

    @cached_property
    def unit_sigma(self) -> float:
        """Standard deviation of the unit's heave [m]."""
        return kpi.sigma(self.heave)

    @cached_property
    def boom_tip_sigma(self) -> float:
        """Standard deviation of the boom tip's heave [m]."""
        return kpi.sigma(self.of(self.run.boom_tip_heave).value)

    @cached_property
    def outlet_sigma(self) -> float:
        """Standard deviation of what the winch leaves of the boom tip's heave [m]."""
        boom_tip = self.of(self.run.boom_tip_heave)
        return kpi.sigma(boom_tip.value - self.run.payout.at(boom_tip)) if self.run.payout.size else NOT_KNOWN

    def hanging(self, signal: Signal) -> Array:
        """Return the values of a signal while the bottom does not carry the unit."""
        part, touchdown = self.of(signal), self.of(self.run.touchdown)
        if not touchdown.value.any():
            return part.value
        return np.asarray(part.value[touchdown.at(part) == 0.0])

    @cached_property
    def unit_efficiency(self) -> float:
        """Efficiency at the unit, while it hangs: a unit on the bottom lies still by itself."""
        free = kpi.sigma(self.hanging(self.run.uncompensated_heave))
        return kpi.efficiency(kpi.sigma(self.hanging(self.run.unit_heave)), free)

    def of_baseline(self, figure: str) -> float:
        """Return the efficiency that is called `figure` here, of the baseline law in the same sea."""
        baseline = self.run.baseline
        return NOT_KNOWN if baseline is None else float(getattr(Window(baseline, self.start, self.end), figure))

    @cached_property
    def compensating_percent(self) -> float:
        """Share of time in which compensation was active [%]."""
        return kpi.percent_true(self.of(self.run.compensating).value)

    @cached_property
    def worst_minute(self) -> float:
        """Largest `s(z) / s(z_off)` of any minute."""
        heave = self.of(self.run.unit_heave)
        off = self.run.uncompensated_heave
        if not (heave.size and off.size):
            return NOT_KNOWN
        _, ratios = kpi.window_ratios(heave.time, heave.value, off.at(heave), self.start, floor=kpi.WORSE_FLOOR)
        return float(ratios.max()) if ratios.size else NOT_KNOWN

    @cached_property
    def outlet_efficiency(self) -> float:
        """Efficiency at the top of the cable, while the unit hangs."""
        if not self.run.payout.size:
            return NOT_KNOWN
        tip = self.run.boom_tip_heave
        left = Signal(tip.time, tip.value - self.run.payout.at(tip))
        return kpi.efficiency(kpi.sigma(self.hanging(left)), kpi.sigma(self.hanging(tip)))

    @cached_property
    def tension_ratios(self) -> tuple[float, float]:
        """Smallest and largest tension over static tension."""
        return self._ratios(self.tension, self.peak_tension)

    @cached_property
    def uncompensated_tension_ratios(self) -> tuple[float, float]:
        """Smallest and largest tension over static tension, winch locked."""
        return self._ratios(self.of(self.run.uncompensated_tension), self.of(self.run.uncompensated_peak_tension()))

    def _ratios(self, tension: Signal, peaks: Signal) -> tuple[float, float]:
        static = self.run.static_at(tension)
        return kpi.tension_ratios(tension.value, static)[0], kpi.tension_ratios(peaks.value, static)[1]

    @cached_property
    def factors(self) -> Mapping[str, float]:
        """Capacity over largest load of the parts whose strength is stated, by key."""
        return {check.strength.key: check.factor for check in self.run.load_checks(self.start, self.end)}

    @property
    def uncompensated_rope_factor(self) -> float:
        """Breaking force of the rope over the largest tension with the winch locked."""
        peaks = self.of(self.run.uncompensated_peak_tension()).value
        rope = next((one.capacity for one in self.run.strengths if one.key == ROPE), NOT_KNOWN)
        return safety_factor(rope, largest(peaks))

    def snaps(self, tension: Signal, peaks: Signal) -> float:
        """Return how often the cable snapped taut, by a tension over static tension and its peaks in between."""
        if not tension.size:
            return NOT_KNOWN
        return float(kpi.snap_times(tension.time, tension.value, self.run.static_at(tension), peaks.value).size)

    @cached_property
    def slack_percent(self) -> float:
        """Share of time in which a part of the cable carries no tension [%]."""
        slack = self.of(self.run.slack)
        return kpi.percent_true(slack.value if slack.size else self.tension.value <= 0.0)

    @cached_property
    def limits_hit(self) -> NDArray[np.int64]:
        """Flags of the limits that act, as the winch reports them; empty where it reports none."""
        return self.of(self.run.limits_hit).value.astype(np.int64)

    @cached_property
    def tells_of_rates(self) -> bool:
        """Whether the winch reports its limits of speed and acceleration: both, or neither."""
        of_rates = WinchLimit.SPEED | WinchLimit.ACCELERATION
        return bool(np.any(self.run.limits_hit.value.astype(np.int64) & of_rates))

    def at(self, limit: WinchLimit) -> NDArray[np.bool_]:
        """Return at which samples of its state the winch reports that a `limit` acts."""
        return np.asarray((self.limits_hit & limit) != 0, dtype=bool)

    @cached_property
    def at_speed_limit(self) -> NDArray[np.bool_]:
        """Samples at the speed limit, by the winch's own word, or else by the rate."""
        if self.tells_of_rates:
            return self.at(WinchLimit.SPEED)
        return kpi.at_limit(self.rate.value, self.run.speed_limit)

    @cached_property
    def at_acceleration_limit(self) -> NDArray[np.bool_]:
        """Samples at the acceleration limit, by the winch's own word, or else by the acceleration."""
        if self.tells_of_rates:
            return self.at(WinchLimit.ACCELERATION)
        is_known = self.acceleration.size == self.rate.size
        return kpi.at_limit(self.acceleration if is_known else np.empty(0), self.run.acceleration_limit)

    @cached_property
    def at_any_limit(self) -> NDArray[np.bool_]:
        """Samples at which any limit acts."""
        parts = [part for part in (self.limits_hit != 0, self.at_speed_limit, self.at_acceleration_limit) if part.size]
        found = parts[0] if parts else np.empty(0, dtype=bool)
        return np.asarray(np.any([part for part in parts if part.size == found.size] or [found], axis=0), dtype=bool)

    @cached_property
    def landings(self) -> list[kpi.Landing]:
        """Landings of the unit on the bottom."""
        height, touchdown = self.of(self.run.unit_height), self.of(self.run.touchdown)
        if height.size != touchdown.size or not height.size:
            return []
        return kpi.landings(height.time, height.value, touchdown.value)

    def landed(self, figure: Callable[[kpi.Landing], float]) -> float:
        """Return the largest of a figure of all landings; NaN where there is none."""
        return max((figure(landing) for landing in self.landings), default=NOT_KNOWN)

    @cached_property
    def times_to_tension(self) -> list[float]:
        """Time from the first contact of each landing until a tension is held [s]; NaN where none was."""
        held = self.run.holds_tension
        found = []
        for landing in self.landings:
            part = held.window(landing.time, landing.end)
            times = part.time[part.value != 0.0]
            found.append(float(times[0] - landing.time) if times.size else NOT_KNOWN)
        return found

    @cached_property
    def mode_changes(self) -> Array:
        """Times at which the controller changed its mode [s]."""
        changes = self.of(self.run.mode_changes)
        return np.asarray(changes.time[changes.value != 0.0])

    def after_changes(self, signal: Signal) -> float:
        """Return the largest absolute value of a signal about its mean within AFTER_CHANGE of a change of mode."""
        part = self.of(signal)
        if not part.size:
            return NOT_KNOWN
        return kpi.largest_after(part.time, part.value - part.value.mean(), self.mode_changes, AFTER_CHANGE)

    @cached_property
    def tension_at_rate(self) -> Array:
        """Tension at the samples of the winch's rate [N]; empty where either is not known."""
        return self.run.tension.at(self.rate) if self.run.tension.size else np.empty(0)

    @cached_property
    def power(self) -> kpi.WinchPower:
        """Power at the drum."""
        return kpi.winch_power(self.tension_at_rate, self.rate.value if self.tension_at_rate.size else [])

    @cached_property
    def loaded_percent(self) -> float:
        """Share of time above half of what the winch is rated for, in speed or power [%]."""
        if not self.tension_at_rate.size:
            return NOT_KNOWN
        power = self.tension_at_rate * self.rate.value
        return kpi.percent_loaded(power, self.rate.value, self.run.power_limit, self.run.speed_limit)

    @cached_property
    def load_cycles(self) -> LoadCycles:
        """Cycles of the top tension."""
        return load_cycles(self.tension.time, self.tension.value)

    @cached_property
    def wear(self) -> kpi.RopeWear:
        """What the winch's motion costs the rope."""
        payout = self.of(self.run.payout)
        return kpi.rope_wear(payout.time, payout.value)

    @cached_property
    def harmonics(self) -> tuple[kpi.Harmonic, kpi.Harmonic, kpi.Harmonic]:
        """First harmonics of unit heave, boom-tip heave and tension of a driven run; NaN for others."""
        signals = (self.run.unit_heave, self.run.boom_tip_heave, self.run.tension)
        none = kpi.Harmonic(NOT_KNOWN, NOT_KNOWN, NOT_KNOWN)
        if not math.isfinite(self.run.driving_omega):
            return none, none, none
        try:
            parts = [self.of(signal) for signal in signals]
            unit, tip, tension = (kpi.fit_harmonic(part.time, part.value, self.run.driving_omega) for part in parts)
        except ValueError:  # shorter than a period
            return none, none, none
        return unit, tip, tension
