"""The figures of merit (KPIs) of one run: each is one entry of one table, with its key, words, unit and formula.

To add a KPI, add an entry to KPI_DEFINITIONS: evaluation, JSON, text tables and the report follow it. Pure numpy; the
formulas are those of `heave_node.kpi`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence, Sized
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from heave_node import kpi
from heave_node.interface.codes import WinchLimit
from heave_node.loads.cycles import DAMAGE_EXPONENT, LoadCycles, load_cycles
from heave_node.loads.strength import ATTACHMENT, ROPE, WINCH_PULL, safety_factor
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray

from heave_bags.signals import RunSignals, Signal

NOT_KNOWN = math.nan
SOURCES = ("estimated", "measured", "true")
"""Sources of a motion, the least certain first."""


AFTER_CHANGE = 10.0
"""Time after a change of mode that counts to it [s]."""


class Window:
    """A part of a run, and what several KPIs take from it, worked out once.

    Parameters
    ----------
    run : the signals
    start, end : both ends included [s]
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

    @property
    def baseline_efficiency(self) -> float:
        """Efficiency at the unit of the baseline law in the same sea."""
        baseline = self.run.baseline
        return NOT_KNOWN if baseline is None else Window(baseline, self.start, self.end).unit_efficiency

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
        return safety_factor(rope, _largest(peaks))

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


def _least(values: Array) -> float:
    return float(values.min()) if values.size else NOT_KNOWN


def _largest(values: Array) -> float:
    return float(values.max()) if values.size else NOT_KNOWN


def _count(signal: Signal, events: Sized) -> float:
    """Return how many events there are; NaN where the signal that shows them was not recorded."""
    return float(len(events)) if signal.size else NOT_KNOWN


def _mean(values: Array) -> float:
    return float(values.mean()) if values.size else NOT_KNOWN


@dataclass(frozen=True)
class KpiDefinition:
    """One figure of merit.

    Attributes
    ----------
    key : its name in JSON, which ends in the SI unit
    title : its name for people, in words alone
    unit : in which a table shows it
    group : under which heading a report shows it
    formula : its value over a `Window` of a run, or over what another table of figures is made from; NaN where it
        cannot be known
    scale, digits : a table shows `scale` times the value, with `digits` decimals
    is_count : a whole number
    heading : its name in a table of windows; "" keeps it out of there
    is_seldom : people see it only where it is not 0
    needs : what a run must have for it to be known, in words; "": nothing that people could miss
    symbols : the formula in the symbols of the field, for those who know them; "": the title says it all
    """

    key: str
    title: str
    unit: str
    group: str
    formula: Callable[[Any], float]
    scale: float = 1.0
    digits: int = 3
    is_count: bool = False
    heading: str = ""
    is_seldom: bool = False
    needs: str = ""
    symbols: str = ""

    def text(self, value: float) -> str:
        """Return the value as a table shows it; a dash for one that could not be computed."""
        if not math.isfinite(value):
            return "-"
        return f"{round(value * self.scale, self.digits) + 0.0:.{self.digits}f}"  # + 0.0: no sign before a zero

    def bound(self, value: float) -> str:
        """Return a bound, the SI `value`, in the unit of the table, no digit lost, with that unit."""
        return f"{value * self.scale:.6g} {self.unit}".rstrip()


def _time_at(limit: WinchLimit, key: str, where: str) -> KpiDefinition:
    """Return the share of time at a `limit` that few winches have or reach, by its `key`; `where` that is, in words."""
    return KpiDefinition(
        key,
        f"time {where}",
        "%",
        WINCH,
        lambda w: kpi.percent_true(w.at(limit)),
        is_seldom=True,
    )


UNIT, TENSION, WINCH, ENERGY, WEAR, ESTIMATE, TIMING, LANDING, CHANGES, DRIVEN = GROUPS = (
    "Unit",
    "Tension",
    "Winch",
    "Energy",
    "Wear of the rope",
    "Estimate",
    "Timing",
    "Landing",
    "Changes of mode",
    "Driven motion",
)
COUNT_OF_EVENTS = {LANDING: "landings", CHANGES: "mode_changes"}
"""Figures that count the events of a group; people see the group only where there are any."""

KPI_DEFINITIONS: tuple[KpiDefinition, ...] = (
    KpiDefinition(
        "unit_sigma_m",
        "unit heave, standard deviation",
        "cm",
        UNIT,
        lambda w: w.unit_sigma,
        100.0,
        2,
        heading="s(z)",
        symbols="s(z)",
    ),
    KpiDefinition(
        "uncompensated_sigma_m",
        "uncompensated unit heave, standard deviation",
        "cm",
        UNIT,
        lambda w: kpi.sigma(w.uncompensated_heave),
        100.0,
        2,
        heading="s(z_off)",
        symbols="s(z_off)",
    ),
    KpiDefinition(
        "unit_efficiency",
        "unit efficiency",
        "%",
        UNIT,
        lambda w: w.unit_efficiency,
        100.0,
        2,
        heading="unit eff.",
        symbols="1 - s(z)/s(z_off)",
    ),
    KpiDefinition(
        "worst_minute",
        f"worst {kpi.WORSE_WINDOW:g} s, unit heave over uncompensated",
        "",
        UNIT,
        lambda w: w.worst_minute,
        1.0,
        3,
        needs=f"{kpi.WORSE_WINDOW:g} s after the transient",
        symbols="largest s(z)/s(z_off)",
    ),
    KpiDefinition(
        "baseline_efficiency",
        "unit efficiency of an industrial controller, same sea",
        "%",
        UNIT,
        lambda w: w.baseline_efficiency,
        100.0,
        2,
        heading="baseline",
        symbols="law industrial",
    ),
    KpiDefinition(
        "outlet_efficiency",
        "outlet efficiency (cable at the boom tip)",
        "%",
        UNIT,
        lambda w: w.outlet_efficiency,
        100.0,
        2,
        heading="outlet eff.",
        symbols="1 - s(z0-p)/s(z0)",
    ),
    KpiDefinition(
        "significant_residual_m",
        "significant residual",
        "cm",
        UNIT,
        lambda w: kpi.significant(w.unit_sigma),
        100.0,
        2,
        symbols="4 s(z)",
    ),
    KpiDefinition(
        "max_abs_heave_m",
        "largest unit heave about the mean",
        "cm",
        UNIT,
        lambda w: kpi.max_abs(w.heave),
        100.0,
        2,
        heading="max |z|",
    ),
    KpiDefinition(
        "uncompensated_max_abs_heave_m",
        "largest uncompensated unit heave about the mean",
        "cm",
        UNIT,
        lambda w: kpi.max_abs(w.uncompensated_heave),
        100.0,
        2,
    ),
    KpiDefinition(
        "heave_p999_m", "99.9th percentile of unit heave", "cm", UNIT, lambda w: kpi.percentile_abs(w.heave), 100.0, 2
    ),
    KpiDefinition(
        "boom_tip_sigma_m", "boom-tip heave, standard deviation", "cm", UNIT, lambda w: w.boom_tip_sigma, 100.0, 2
    ),
    KpiDefinition(
        "outlet_sigma_m",
        "outlet residual (cable at the boom tip), standard deviation",
        "cm",
        UNIT,
        lambda w: w.outlet_sigma,
        100.0,
        2,
        symbols="s(z0-p)",
    ),
    KpiDefinition(
        "kappa",
        "kappa, ratio to the best possible",
        "",
        UNIT,
        lambda w: kpi.kappa(w.unit_sigma, w.run.sensor_bound, w.run.actuator_bound),
        1.0,
        2,
        symbols="s(z) / bound",
    ),
    KpiDefinition(
        "tension_min_n",
        "top tension, smallest",
        "kN",
        TENSION,
        lambda w: _least(w.tension.value),
        1e-3,
        2,
        heading="T min",
    ),
    KpiDefinition("tension_mean_n", "top tension, mean", "kN", TENSION, lambda w: _mean(w.tension.value), 1e-3, 2),
    KpiDefinition(
        "tension_max_n",
        "top tension, largest",
        "kN",
        TENSION,
        lambda w: _largest(w.peak_tension.value),
        1e-3,
        2,
        heading="T max",
    ),
    KpiDefinition(
        "tension_sigma_n", "top tension, standard deviation", "kN", TENSION, lambda w: kpi.sigma(w.tension.value), 1e-3
    ),
    KpiDefinition(
        "rope_safety_factor",
        "safety factor of the rope",
        "",
        TENSION,
        lambda w: w.factors.get(ROPE, NOT_KNOWN),
        digits=2,
        symbols="breaking force / Tmax",
    ),
    KpiDefinition(
        "winch_pull_factor",
        "rated pull of the winch over largest tension",
        "",
        TENSION,
        lambda w: w.factors.get(WINCH_PULL, NOT_KNOWN),
        digits=2,
        symbols="rated pull / Tmax",
    ),
    KpiDefinition(
        "attachment_safety_factor",
        "safety factor of the unit's attachment",
        "",
        TENSION,
        lambda w: w.factors.get(ATTACHMENT, NOT_KNOWN),
        digits=2,
        symbols="breaking force / largest load",
    ),
    KpiDefinition(
        "tension_ratio_min",
        "smallest tension over static",
        "",
        TENSION,
        lambda w: w.tension_ratios[0],
        symbols="rT = Tmin/Tstatic",
    ),
    KpiDefinition(
        "dynamic_amplification",
        "largest tension over static",
        "",
        TENSION,
        lambda w: w.tension_ratios[1],
        symbols="DAF = Tmax/Tstatic",
    ),
    KpiDefinition("slack_percent", "time with a slack cable", "%", TENSION, lambda w: w.slack_percent),
    KpiDefinition("snaps", "snaps", "", TENSION, lambda w: w.snaps(w.tension, w.peak_tension), digits=0, is_count=True),
    KpiDefinition(
        "uncompensated_rope_safety_factor",
        "safety factor of the rope, uncompensated",
        "",
        TENSION,
        lambda w: w.uncompensated_rope_factor,
        digits=2,
    ),
    KpiDefinition(
        "uncompensated_tension_ratio_min",
        "smallest tension over static, uncompensated",
        "",
        TENSION,
        lambda w: w.uncompensated_tension_ratios[0],
        symbols="rT",
    ),
    KpiDefinition(
        "uncompensated_dynamic_amplification",
        "largest tension over static, uncompensated",
        "",
        TENSION,
        lambda w: w.uncompensated_tension_ratios[1],
        symbols="DAF",
    ),
    KpiDefinition(
        "uncompensated_snaps",
        "snaps, uncompensated",
        "",
        TENSION,
        lambda w: w.snaps(w.of(w.run.uncompensated_tension), w.of(w.run.uncompensated_peak_tension())),
        digits=0,
        is_count=True,
    ),
    KpiDefinition(
        "winch_speed_max_mps",
        "winch speed, largest",
        "m/s",
        WINCH,
        lambda w: _largest(np.abs(w.rate.value)),
        heading="max |v|",
    ),
    KpiDefinition(
        "winch_acceleration_max_mps2",
        "winch acceleration, largest",
        "m/s²",
        WINCH,
        lambda w: _largest(np.abs(w.acceleration)),
    ),
    KpiDefinition(
        "time_at_speed_limit_percent",
        "time at the speed limit",
        "%",
        WINCH,
        lambda w: kpi.percent_true(w.at_speed_limit),
    ),
    KpiDefinition(
        "time_at_acceleration_limit_percent",
        "time at the acceleration limit",
        "%",
        WINCH,
        lambda w: kpi.percent_true(w.at_acceleration_limit),
    ),
    _time_at(WinchLimit.PAYOUT, "time_at_payout_limit_percent", "at the end of its payout"),
    _time_at(WinchLimit.POWER, "time_at_power_limit_percent", "at the power limit"),
    _time_at(WinchLimit.TORQUE, "time_at_torque_limit_percent", "at the torque limit"),
    _time_at(WinchLimit.PRESSURE, "time_at_pressure_limit_percent", "at the pressure limit"),
    _time_at(WinchLimit.FLOW, "time_at_flow_limit_percent", "at the flow limit"),
    KpiDefinition(
        "time_at_limit_percent",
        "time at any winch limit",
        "%",
        WINCH,
        lambda w: kpi.percent_true(w.at_any_limit),
        heading="at limit",
    ),
    KpiDefinition(
        "compensating_percent",
        "time with compensation active",
        "%",
        WINCH,
        lambda w: kpi.percent_true(w.of(w.run.compensating).value),
        digits=1,
    ),
    KpiDefinition(
        "time_above_half_rating_percent",
        "time above half of rated speed or power",
        "%",
        WINCH,
        lambda w: w.loaded_percent,
        digits=1,
    ),
    KpiDefinition(
        "power_peak_w", "winch power, peak", "kW", ENERGY, lambda w: w.power.peak, 1e-3, 2, symbols="max |T v|"
    ),
    KpiDefinition(
        "power_mean_abs_w",
        "winch power, mean magnitude",
        "kW",
        ENERGY,
        lambda w: w.power.mean_abs,
        1e-3,
        2,
        symbols="mean |T v|",
    ),
    KpiDefinition("power_rms_w", "winch power, root mean square", "kW", ENERGY, lambda w: w.power.rms, 1e-3, 2),
    KpiDefinition("energy_wh_per_h", "energy, motoring, per hour", "kWh/h", ENERGY, lambda w: w.power.motoring, 1e-3),
    KpiDefinition(
        "energy_regenerated_wh_per_h",
        "energy, regenerated, per hour",
        "kWh/h",
        ENERGY,
        lambda w: w.power.regenerated,
        1e-3,
    ),
    KpiDefinition(
        "rope_travel_m_per_h", "rope over the sheave, per hour", "m/h", WEAR, lambda w: w.wear.travel, digits=0
    ),
    KpiDefinition(
        "reversals_per_h", "changes of direction, per hour", "1/h", WEAR, lambda w: w.wear.reversals, digits=0
    ),
    KpiDefinition(
        "bending_cycles_per_h",
        "bending over the sheave, cycles per hour",
        "1/h",
        WEAR,
        lambda w: w.wear.bending_cycles,
        digits=0,
    ),
    KpiDefinition(
        "tension_cycles_per_h",
        "cycles of the top tension, per hour",
        "1/h",
        WEAR,
        lambda w: w.load_cycles.per_hour,
        digits=0,
        symbols="rainflow",
    ),
    KpiDefinition(
        "tension_range_equivalent_n",
        "damage-equivalent tension range at 1 Hz",
        "kN",
        WEAR,
        lambda w: w.load_cycles.equivalent_range,
        1e-3,
        symbols=f"S-N slope m = {DAMAGE_EXPONENT:g}",
    ),
    KpiDefinition(
        "nis_in_band_percent",
        "time with a consistent estimator",
        "%",
        ESTIMATE,
        lambda w: kpi.percent_true(w.of(w.run.nis_in_band).value),
        digits=1,
        symbols="NIS inside its 95 % band",
    ),
    KpiDefinition("real_time_factor", "real-time factor", "", TIMING, lambda w: w.run.real_time_factor, digits=1),
    KpiDefinition("loop_age_p50_s", "loop age, p50", "ms", TIMING, lambda w: w.run.loop_age[0], 1e3, 2),
    KpiDefinition("loop_age_p99_s", "loop age, p99", "ms", TIMING, lambda w: w.run.loop_age[1], 1e3, 2),
    KpiDefinition("loop_age_max_s", "loop age, largest", "ms", TIMING, lambda w: w.run.loop_age[2], 1e3, 2),
    KpiDefinition(
        "controller_tick_p999_s",
        "controller's tick, p99.9",
        "ms",
        TIMING,
        lambda w: kpi.percentiles(w.of(w.run.execution_time).value, (99.9,))[0],
        1e3,
        2,
    ),
    KpiDefinition(
        "controller_tick_max_s",
        "controller's tick, largest",
        "ms",
        TIMING,
        lambda w: kpi.percentiles(w.of(w.run.execution_time).value, (100.0,))[0],
        1e3,
        2,
    ),
    KpiDefinition(
        "missed_deadlines",
        "missed deadlines",
        "",
        TIMING,
        lambda w: w.run.missed_deadlines,
        digits=0,
        is_count=True,
    ),
    KpiDefinition(
        "late_commands", "late winch commands", "", TIMING, lambda w: w.run.late_commands, digits=0, is_count=True
    ),
    KpiDefinition(
        "landings", "landings", "", LANDING, lambda w: _count(w.run.touchdown, w.landings), digits=0, is_count=True
    ),
    KpiDefinition(
        "landings_held",
        "landings after which tension was held",
        "",
        LANDING,
        lambda w: _count(w.run.touchdown, [time for time in w.times_to_tension if math.isfinite(time)]),
        digits=0,
        is_count=True,
    ),
    KpiDefinition(
        "touchdown_speed_mps",
        "speed of the unit at touchdown",
        "m/s",
        LANDING,
        lambda w: w.landed(lambda one: one.speed),
    ),
    KpiDefinition(
        "touchdown_rebound_m",
        "rebound above the place of touchdown",
        "cm",
        LANDING,
        lambda w: w.landed(lambda one: one.rebound),
        100.0,
        2,
    ),
    KpiDefinition(
        "lift_offs",
        "contact lost before the unit was lifted off",
        "",
        LANDING,
        lambda w: w.landed(lambda one: one.lift_offs),
        digits=0,
        is_count=True,
    ),
    KpiDefinition(
        "landing_to_tension_s",
        "from touchdown until tension is held",
        "s",
        LANDING,
        lambda w: max(w.times_to_tension, default=NOT_KNOWN),
        digits=2,
    ),
    KpiDefinition(
        "mode_changes",
        "changes of mode",
        "",
        CHANGES,
        lambda w: _count(w.run.mode_changes, w.mode_changes),
        digits=0,
        is_count=True,
    ),
    KpiDefinition(
        "compensation_losses",
        "losses of compensation that nobody had requested",
        "",
        CHANGES,
        lambda w: _count(w.run.losses, np.flatnonzero(w.of(w.run.losses).value)),
        digits=0,
        is_count=True,
    ),
    KpiDefinition(
        "mode_change_heave_max_m",
        f"largest unit heave within {AFTER_CHANGE:g} s of a change",
        "cm",
        CHANGES,
        lambda w: w.after_changes(w.run.unit_heave),
        100.0,
        2,
    ),
    KpiDefinition(
        "mode_change_acceleration_max_mps2",
        f"largest winch acceleration within {AFTER_CHANGE:g} s of a change",
        "m/s²",
        CHANGES,
        lambda w: (
            kpi.largest_after(w.rate.time, w.acceleration, w.mode_changes, AFTER_CHANGE)
            if w.acceleration.size == w.rate.size
            else NOT_KNOWN
        ),
    ),
    KpiDefinition(
        "unit_heave_amplitude_m",
        "unit heave, first harmonic",
        "cm",
        DRIVEN,
        lambda w: w.harmonics[0].amplitude,
        100.0,
        digits=3,
    ),
    KpiDefinition(
        "unit_heave_phase_deg",
        "unit heave, lead over the boom tip",
        "deg",
        DRIVEN,
        lambda w: kpi.phase_lead_degrees(w.harmonics[0], w.harmonics[1]),
    ),
    KpiDefinition(
        "top_tension_mean_n", "top tension, mean of the fit", "kN", DRIVEN, lambda w: w.harmonics[2].mean, 1e-3, 4
    ),
    KpiDefinition(
        "top_tension_amplitude_n",
        "top tension, first harmonic",
        "kN",
        DRIVEN,
        lambda w: w.harmonics[2].amplitude,
        1e-3,
        digits=4,
    ),
)
"""All KPIs in the order of a table."""

UNIT_HEAVE, FREE_HEAVE, TIP_HEAVE = "unit heave", "uncompensated unit heave", "boom-tip heave"
TOP_TENSION, PAYOUT = "top tension", "payout"
_OF_TENSION = (
    *("tension_min_n", "tension_mean_n", "tension_max_n", "tension_sigma_n", "tension_ratio_min"),
    *("dynamic_amplification", "snaps", "top_tension_mean_n", "top_tension_amplitude_n"),
    *("tension_cycles_per_h", "tension_range_equivalent_n", ROPE, WINCH_PULL),
)
MOTIONS_OF: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(("unit_sigma_m", "significant_residual_m", "max_abs_heave_m", "heave_p999_m"), (UNIT_HEAVE,)),
    **dict.fromkeys(("uncompensated_sigma_m", "uncompensated_max_abs_heave_m"), (FREE_HEAVE,)),
    **dict.fromkeys(("outlet_sigma_m", "outlet_efficiency"), (TIP_HEAVE, PAYOUT)),
    **dict.fromkeys(("boom_tip_sigma_m",), (TIP_HEAVE,)),
    **dict.fromkeys(("kappa", "unit_heave_amplitude_m"), (UNIT_HEAVE,)),
    "unit_efficiency": (UNIT_HEAVE, FREE_HEAVE),
    "unit_heave_phase_deg": (UNIT_HEAVE, TIP_HEAVE),
    **dict.fromkeys(_OF_TENSION, (TOP_TENSION,)),
    **dict.fromkeys(("winch_speed_max_mps", "winch_acceleration_max_mps2"), (PAYOUT,)),
}
"""Motions that figures are made from, by key."""


def source_of(key: str, sources: Mapping[str, str]) -> str:
    """Return what figure `key` is made from, by the `sources` of a run's motions: the least certain; "" for others."""
    found = [sources[motion] for motion in MOTIONS_OF.get(key, ()) if motion in sources]
    return next((source for source in SOURCES if source in found), "")


QUANTITIES: Mapping[str, tuple[str, float]] = {
    "m": ("cm", 100.0),
    "N": ("kN", 1e-3),
    "m/s": ("m/s", 1.0),
    "m/s²": ("m/s²", 1.0),
    "W": ("kW", 1e-3),
}
"""Unit in which each quantity is shown everywhere, and that over its SI unit: motion, force, ... power."""

DEFINITION_OF: Mapping[str, KpiDefinition] = {definition.key: definition for definition in KPI_DEFINITIONS}


def evaluate(run: RunSignals, start: float = -math.inf, end: float = math.inf) -> dict[str, float]:
    """Return every KPI (keys of KPI_DEFINITIONS) of a `run` over the window `start` to `end` [s], both ends included.

    NaN where it cannot be known.
    """
    window = Window(run, start, end)
    return {definition.key: definition.formula(window) for definition in KPI_DEFINITIONS}


def evaluate_run(run: RunSignals, start: float, end: float) -> dict[str, float]:
    """Return every KPI of a `run` that is judged from `start` to `end` [s].

    As `evaluate`, but the safety factors are those of the largest load of the whole run, as in the verdict: a part that
    is overloaded during the transient is overloaded.
    """
    whole = {check.strength.key: check.factor for check in run.load_checks()}
    return {**evaluate(run, start, end), **whole}


def to_json(values: Mapping[str, float]) -> dict[str, float | int | None]:
    """Return the KPIs `values` as JSON takes them: counts as whole numbers, None for what is not known."""
    return {
        key: None if not math.isfinite(value) else int(value) if DEFINITION_OF[key].is_count else float(value)
        for key, value in values.items()
    }


def shown(columns: Sequence[Mapping[str, float]]) -> list[KpiDefinition]:
    """Return the figures that people see of the KPIs of one or several runs, `columns`, in order.

    Left out is what no run has a value of, what counts events that there were none of, and what is seldom, where it
    is 0 in all runs.
    """

    def has_events(group: str) -> bool:
        count = COUNT_OF_EVENTS.get(group)
        return count is None or any(column.get(count, 0.0) > 0.0 for column in columns)

    def is_reported(definition: KpiDefinition, column: Mapping[str, float]) -> bool:
        value = column.get(definition.key, math.nan)
        return math.isfinite(value) and not (definition.is_seldom and value == 0.0)

    return [
        definition
        for definition in KPI_DEFINITIONS
        if has_events(definition.group) and any(is_reported(definition, column) for column in columns)
    ]


def table(
    columns: Mapping[str, Mapping[str, float]],
    sources: Mapping[str, Mapping[str, str]] = MappingProxyType({}),
    *,
    keys: Sequence[str] | None = None,
    notes: Mapping[str, str] = MappingProxyType({}),
) -> str:
    """Return KPIs as a text table; rows without any value are left out.

    Parameters
    ----------
    columns : KPIs of one or several runs, by name
    sources : where the motions of each run come from; a figure that is not made from the truth says so
    keys : of the figures in the table, in order; None: of all
    notes : on figures, by key
    """
    rows = [("", "", *columns)]
    for definition in shown(list(columns.values())) if keys is None else [DEFINITION_OF[key] for key in keys]:
        cells = [definition.text(values.get(definition.key, math.nan)) for values in columns.values()]
        marks = {source_of(definition.key, of_run) for of_run in sources.values()} - {"", SOURCES[-1]}
        beside = [definition.unit, ", ".join(sorted(marks)), notes.get(definition.key, "")]
        rows.append((definition.title, "  ".join(text for text in beside if text), *cells))
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    lines = [
        f"{row[0]:<{widths[0]}}  "
        + "  ".join(f"{c:>{w}}" for c, w in zip(row[2:], widths[2:], strict=True))
        + f"  {row[1]}"
        for row in rows
    ]
    return "\n".join(line.rstrip() for line in lines)
