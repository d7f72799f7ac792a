"""The KPI set of one run: which KPIs there are, how they are named, and their values from a run's signals.

Pure numpy; the formulas are those of `heave_node.kpi`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from heave_node import kpi
from heave_node.arrays import Array

TIME_ROUNDING = 1e-9
"""Stamps are whole nanoseconds: windows include their ends to this [s]."""


@dataclass(frozen=True)
class KpiDefinition:
    """Name of a KPI in JSON (with its unit), its title, and how a table shows it: value * scale, in `unit`, with
    `digits` decimals.
    """

    key: str
    title: str
    unit: str
    scale: float = 1.0
    digits: int = 3

    def text(self, value: float) -> str:
        """Return the value as a table shows it; a dash for one that could not be computed."""
        return f"{value * self.scale:.{self.digits}f}" if math.isfinite(value) else "-"


KPI_DEFINITIONS: tuple[KpiDefinition, ...] = (
    KpiDefinition("unit_sigma_m", "unit heave, standard deviation", "cm", 100.0, 2),
    KpiDefinition("uncompensated_sigma_m", "uncompensated unit heave, standard deviation", "cm", 100.0, 2),
    KpiDefinition("unit_efficiency", "unit efficiency 1 - s(z)/s(z_off)", "%", 100.0, 2),
    KpiDefinition("outlet_efficiency", "outlet efficiency 1 - s(z0-p)/s(z0)", "%", 100.0, 2),
    KpiDefinition("significant_residual_m", "significant residual 4 s(z)", "cm", 100.0, 2),
    KpiDefinition("max_abs_heave_m", "largest unit heave about the mean", "cm", 100.0, 2),
    KpiDefinition("uncompensated_max_abs_heave_m", "largest uncompensated unit heave about the mean", "cm", 100.0, 2),
    KpiDefinition("heave_p999_m", "99.9th percentile of unit heave", "cm", 100.0, 2),
    KpiDefinition("boom_tip_sigma_m", "boom-tip heave, standard deviation", "cm", 100.0, 2),
    KpiDefinition("outlet_sigma_m", "outlet residual s(z0-p)", "cm", 100.0, 2),
    KpiDefinition("kappa", "kappa, distance from the possible", "", 1.0, 2),
    KpiDefinition("tension_min_n", "top tension, smallest", "kN", 1e-3, 2),
    KpiDefinition("tension_mean_n", "top tension, mean", "kN", 1e-3, 2),
    KpiDefinition("tension_max_n", "top tension, largest", "kN", 1e-3, 2),
    KpiDefinition("tension_sigma_n", "top tension, standard deviation", "kN", 1e-3, 3),
    KpiDefinition("tension_ratio_min", "rT = Tmin/Tstatic", "", 1.0, 3),
    KpiDefinition("dynamic_amplification", "DAF = Tmax/Tstatic", "", 1.0, 3),
    KpiDefinition("slack_percent", "slack, share of time", "%", 1.0, 3),
    KpiDefinition("snaps", "snaps", "", 1.0, 0),
    KpiDefinition("uncompensated_tension_ratio_min", "rT, uncompensated", "", 1.0, 3),
    KpiDefinition("uncompensated_dynamic_amplification", "DAF, uncompensated", "", 1.0, 3),
    KpiDefinition("uncompensated_snaps", "snaps, uncompensated", "", 1.0, 0),
    KpiDefinition("winch_speed_max_mps", "winch speed, largest", "m/s", 1.0, 3),
    KpiDefinition("winch_acceleration_max_mps2", "winch acceleration, largest", "m/s2", 1.0, 3),
    KpiDefinition("time_at_speed_limit_percent", "at the speed limit, share of time", "%", 1.0, 3),
    KpiDefinition("time_at_acceleration_limit_percent", "at the acceleration limit, share of time", "%", 1.0, 3),
    KpiDefinition("time_at_limit_percent", "at any winch limit, share of time", "%", 1.0, 3),
    KpiDefinition("power_peak_w", "winch power, peak |Tv|", "kW", 1e-3, 2),
    KpiDefinition("power_mean_abs_w", "winch power, mean |Tv|", "kW", 1e-3, 2),
    KpiDefinition("energy_wh_per_h", "energy, motoring, per hour", "kWh/h", 1e-3, 3),
    KpiDefinition("energy_regenerated_wh_per_h", "energy, regenerated, per hour", "kWh/h", 1e-3, 3),
    KpiDefinition("nis_in_band_percent", "NIS inside its 95 % band", "%", 1.0, 1),
    KpiDefinition("real_time_factor", "real-time factor", "", 1.0, 1),
    KpiDefinition("loop_age_p50_s", "loop age, p50", "ms", 1e3, 2),
    KpiDefinition("loop_age_p99_s", "loop age, p99", "ms", 1e3, 2),
    KpiDefinition("loop_age_max_s", "loop age, largest", "ms", 1e3, 2),
    KpiDefinition("missed_deadlines", "missed deadlines", "", 1.0, 0),
    KpiDefinition("unit_heave_amplitude_m", "unit heave, first harmonic", "m", 1.0, 5),
    KpiDefinition("unit_heave_phase_deg", "unit heave, lead over the boom tip", "deg", 1.0, 3),
    KpiDefinition("top_tension_mean_n", "top tension, mean of the fit", "N", 1.0, 1),
    KpiDefinition("top_tension_amplitude_n", "top tension, first harmonic", "N", 1.0, 1),
)
"""All KPIs in the order of a table. One definition: JSON keys, titles and units come from here."""

DEFINITION_OF: Mapping[str, KpiDefinition] = {definition.key: definition for definition in KPI_DEFINITIONS}


def _empty() -> Array:
    return np.empty(0)


@dataclass
class Signal:
    """One sampled scalar: times [s], non-decreasing, and values, both of shape (n,)."""

    time: Array = field(default_factory=_empty)
    value: Array = field(default_factory=_empty)

    def window(self, start: float, end: float) -> Signal:
        """Return the part with start <= time <= end (views, no copy)."""
        first, last = np.searchsorted(self.time, (start - TIME_ROUNDING, end + TIME_ROUNDING))
        return Signal(self.time[first:last], self.value[first:last])

    def at(self, other: Signal) -> Array:
        """Return this signal at the times of `other`, linear in between; exact where the stamps agree."""
        return np.interp(other.time, self.time, self.value)

    @property
    def size(self) -> int:
        """Number of samples."""
        return int(self.time.size)


def _signal() -> Signal:
    return Signal()


@dataclass
class RunSignals:
    """What the KPIs of a run are computed from; a signal nobody recorded stays empty, and its KPIs are NaN.

    Attributes
    ----------
    unit_heave, uncompensated_heave, boom_tip_heave : vertical position, positive up [m]
    payout, payout_rate, payout_acceleration : of the drum, positive pays out [m], [m/s], [m/s^2]
    tension : top tension [N]
    slack : 1 where any part of the cable carries no tension
    winch_limited : 1 where the winch itself says that a limit acts
    nis_in_band : 1 where the normalised innovation squared lies inside its 95 % band
    uncompensated_tension : top tension with the winch locked, or following the programme of depth only [N]
    static_tension : top tension at rest [N], one sample where the deployed length stays; empty takes the mean tension
    speed_limit, acceleration_limit : of the winch [m/s], [m/s^2]; infinite when unknown
    driving_omega : angular frequency of a driven scenario [rad/s]; NaN if the scenario is not driven by one
        regular motion
    sensor_bound, actuator_bound : the two bounds in kappa [m]; NaN when unknown
    real_time_factor, missed_deadlines : of the run as a whole; NaN when unknown
    loop_age : start of a tick to its last answer, wall time: p50, p99 and largest [s]; NaN when unknown
    """

    unit_heave: Signal = field(default_factory=_signal)
    uncompensated_heave: Signal = field(default_factory=_signal)
    boom_tip_heave: Signal = field(default_factory=_signal)
    payout: Signal = field(default_factory=_signal)
    payout_rate: Signal = field(default_factory=_signal)
    payout_acceleration: Signal = field(default_factory=_signal)
    tension: Signal = field(default_factory=_signal)
    uncompensated_tension: Signal = field(default_factory=_signal)
    static_tension: Signal = field(default_factory=_signal)
    slack: Signal = field(default_factory=_signal)
    winch_limited: Signal = field(default_factory=_signal)
    nis_in_band: Signal = field(default_factory=_signal)
    speed_limit: float = math.inf
    acceleration_limit: float = math.inf
    driving_omega: float = math.nan
    sensor_bound: float = math.nan
    actuator_bound: float = math.nan
    real_time_factor: float = math.nan
    missed_deadlines: float = math.nan
    loop_age: tuple[float, float, float] = (math.nan, math.nan, math.nan)

    def static_at(self, tension: Signal) -> Array:
        """Return the static tension at the samples of a tension [N]: their mean where it is not known."""
        if self.static_tension.size:
            return self.static_tension.at(tension)
        return np.full(tension.size, tension.value.mean() if tension.size else math.nan)


def evaluate(run: RunSignals, start: float = -math.inf, end: float = math.inf) -> dict[str, float]:
    """Return every KPI (keys of KPI_DEFINITIONS) over the window start..end [s], both ends included; NaN where it
    cannot be known.
    """
    values = dict.fromkeys(DEFINITION_OF, math.nan)
    values |= _motion(run, start, end)
    values |= _tension(run, start, end)
    values |= _uncompensated_tension(run, start, end)
    values |= _winch(run, start, end)
    values |= _timing(run, start, end)
    if math.isfinite(run.driving_omega):
        values |= _driven(run, start, end)
    return values


def _motion(run: RunSignals, start: float, end: float) -> dict[str, float]:
    heave = run.unit_heave.window(start, end)
    boom_tip = run.boom_tip_heave.window(start, end)
    unit_sigma = kpi.sigma(heave.value)
    without = run.uncompensated_heave.window(start, end)
    uncompensated = kpi.sigma(without.value)
    boom_tip_sigma = kpi.sigma(boom_tip.value)
    outlet_sigma = kpi.sigma(boom_tip.value - run.payout.at(boom_tip)) if run.payout.size else math.nan
    return {
        "unit_sigma_m": unit_sigma,
        "uncompensated_sigma_m": uncompensated,
        "unit_efficiency": kpi.efficiency(unit_sigma, uncompensated),
        "boom_tip_sigma_m": boom_tip_sigma,
        "outlet_sigma_m": outlet_sigma,
        "outlet_efficiency": kpi.efficiency(outlet_sigma, boom_tip_sigma),
        "significant_residual_m": kpi.significant(unit_sigma),
        "max_abs_heave_m": kpi.max_abs(heave.value),
        "uncompensated_max_abs_heave_m": kpi.max_abs(without.value),
        "heave_p999_m": kpi.percentile_abs(heave.value),
        "kappa": kpi.kappa(unit_sigma, run.sensor_bound, run.actuator_bound),
    }


def _tension(run: RunSignals, start: float, end: float) -> dict[str, float]:
    tension = run.tension.window(start, end)
    slack = run.slack.window(start, end)
    if not tension.size:
        return {"slack_percent": kpi.percent_true(slack.value)}
    ratio, amplification, snaps = _against_static(run, tension)
    slack_flags = slack.value if slack.size else tension.value <= 0.0
    return {
        "tension_min_n": float(tension.value.min()),
        "tension_mean_n": float(tension.value.mean()),
        "tension_max_n": float(tension.value.max()),
        "tension_sigma_n": kpi.sigma(tension.value),
        "tension_ratio_min": ratio,
        "dynamic_amplification": amplification,
        "slack_percent": kpi.percent_true(slack_flags),
        "snaps": snaps,
    }


def _uncompensated_tension(run: RunSignals, start: float, end: float) -> dict[str, float]:
    tension = run.uncompensated_tension.window(start, end)
    if not tension.size:
        return {}
    ratio, amplification, snaps = _against_static(run, tension)
    return {
        "uncompensated_tension_ratio_min": ratio,
        "uncompensated_dynamic_amplification": amplification,
        "uncompensated_snaps": snaps,
    }


def _against_static(run: RunSignals, tension: Signal) -> tuple[float, float, float]:
    """Return rT, DAF and the number of snaps of a tension, all over the static one."""
    static = run.static_at(tension)
    snaps = kpi.snap_times(tension.time, tension.value, static)
    return *kpi.tension_ratios(tension.value, static), float(snaps.size)


def _winch(run: RunSignals, start: float, end: float) -> dict[str, float]:
    rate = run.payout_rate.window(start, end)
    acceleration = run.payout_acceleration.window(start, end)
    if not rate.size:
        return {}
    values = {"winch_speed_max_mps": float(np.abs(rate.value).max())}
    at_speed = kpi.at_limit(rate.value, run.speed_limit)
    limited = at_speed
    values["time_at_speed_limit_percent"] = kpi.percent_true(at_speed)
    if acceleration.size == rate.size:
        at_acceleration = kpi.at_limit(acceleration.value, run.acceleration_limit)
        values["winch_acceleration_max_mps2"] = float(np.abs(acceleration.value).max())
        values["time_at_acceleration_limit_percent"] = kpi.percent_true(at_acceleration)
        limited = limited | at_acceleration
    flagged = run.winch_limited.window(start, end)
    if flagged.size == rate.size:
        limited = limited | (flagged.value != 0.0)
    values["time_at_limit_percent"] = kpi.percent_true(limited)
    if run.tension.size:
        power = kpi.winch_power(run.tension.at(rate), rate.value)
        values |= {
            "power_peak_w": power.peak,
            "power_mean_abs_w": power.mean_abs,
            "energy_wh_per_h": power.motoring,
            "energy_regenerated_wh_per_h": power.regenerated,
        }
    return values


def _timing(run: RunSignals, start: float, end: float) -> dict[str, float]:
    p50, p99, largest = run.loop_age
    return {
        "nis_in_band_percent": kpi.percent_true(run.nis_in_band.window(start, end).value),
        "real_time_factor": run.real_time_factor,
        "loop_age_p50_s": p50,
        "loop_age_p99_s": p99,
        "loop_age_max_s": largest,
        "missed_deadlines": run.missed_deadlines,
    }


def _driven(run: RunSignals, start: float, end: float) -> dict[str, float]:
    """First harmonics of a driven scenario; NaN if the window is shorter than a period."""
    try:
        fits = [
            kpi.fit_harmonic(part.time, part.value, run.driving_omega)
            for part in (signal.window(start, end) for signal in (run.unit_heave, run.boom_tip_heave, run.tension))
        ]
    except ValueError:
        return {}
    unit, boom_tip, tension = fits
    return {
        "unit_heave_amplitude_m": unit.amplitude,
        "unit_heave_phase_deg": kpi.phase_lead_degrees(unit, boom_tip),
        "top_tension_mean_n": tension.mean,
        "top_tension_amplitude_n": tension.amplitude,
    }


def to_json(values: Mapping[str, float]) -> dict[str, float | int | None]:
    """Return KPIs as JSON takes them: counts as whole numbers, None for what is not known."""
    counts = ("snaps", "uncompensated_snaps", "missed_deadlines")
    return {
        key: None if not math.isfinite(value) else int(value) if key in counts else float(value)
        for key, value in values.items()
    }


def table(columns: Mapping[str, Mapping[str, float]]) -> str:
    """Return KPIs of one or several runs (by name) as a text table; rows nobody knows are left out."""
    rows = [("", "", *columns)]
    for definition in KPI_DEFINITIONS:
        cells = [definition.text(values.get(definition.key, math.nan)) for values in columns.values()]
        if any(cell != "-" for cell in cells):
            rows.append((definition.title, definition.unit, *cells))
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    lines = [
        f"{row[0]:<{widths[0]}}  "
        + "  ".join(f"{c:>{w}}" for c, w in zip(row[2:], widths[2:], strict=True))
        + f"  {row[1]}"
        for row in rows
    ]
    return "\n".join(line.rstrip() for line in lines)
