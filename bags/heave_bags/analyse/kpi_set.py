"""The figures of merit (KPIs) of one run: each is one entry of one table, with its key, words, unit and formula.

To add a KPI, add an entry to KPI_DEFINITIONS, and the motions that it is made from to MOTIONS_OF: evaluation, JSON,
text tables and the report follow. Pure numpy; the formulas are those of `heave_node.kpi`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence, Sized
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from heave_node import kpi
from heave_node.interface.codes import WinchLimit
from heave_node.loads.cycles import DAMAGE_EXPONENT
from heave_node.loads.strength import ATTACHMENT, ROPE, WINCH_PULL
from heave_node.numerics.arrays import Array
from heave_node.run_parameters import LOCKSTEP

from heave_bags.analyse.kpis.definition import NOT_KNOWN, SHOWN, KpiDefinition, largest, least
from heave_bags.analyse.kpis.window import AFTER_CHANGE, Window
from heave_bags.signals import RunSignals, Signal

SOURCES = ("estimated", "measured", "true")
"""Sources of a motion, the least certain first."""
BESIDE = {"estimated": "estimated by the controller's own sensors", "measured": "measured"}
"""What is said of them beside a figure: an error of these sensors is none of the figure."""
UNIT_HEAVE, FREE_HEAVE, TIP_HEAVE = "load heave", "load heave, winch locked", "boom-tip heave"
TOP_TENSION, PAYOUT, BASELINE = "top tension", "payout", "baseline"
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
    **dict.fromkeys(("baseline_efficiency", "baseline_outlet_efficiency"), (BASELINE,)),
    "unit_heave_phase_deg": (UNIT_HEAVE, TIP_HEAVE),
    **dict.fromkeys(_OF_TENSION, (TOP_TENSION,)),
    **dict.fromkeys(("winch_speed_max_mps", "winch_acceleration_max_mps2"), (PAYOUT,)),
}
"""Motions that figures are made from, by key."""


def source_of(key: str, sources: Mapping[str, str]) -> str:
    """Return what figure `key` is made from, by the `sources` of a run's motions: the least certain; "" for others."""
    found = [sources[motion] for motion in MOTIONS_OF.get(key, ()) if motion in sources]
    return next((source for source in SOURCES if source in found), "")


UNIT, TENSION, WINCH, ENERGY, WEAR, ESTIMATE, TIMING, LANDING, CHANGES, DRIVEN = GROUPS = (
    "Load",
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

HEAVE = "the heave of the load, or its depth where waves do not reach"
"""What figures of the unit need."""


def _figure(
    key: str,
    title: str,
    formula: Callable[[Window], float],
    symbols: str = "",
    *,
    unit: str | None = None,
    scale: float | None = None,
    digits: int | None = None,
    needs: str = "",
    is_seldom: bool = False,
) -> KpiDefinition:
    """Return a definition whose unit, scale and digits are those of its key's end (`SHOWN`), where none are given."""
    usual = next(shown for end, shown in SHOWN.items() if key.endswith(end))
    return KpiDefinition(
        key,
        title,
        usual[0] if unit is None else unit,
        "",
        formula,
        usual[1] if scale is None else scale,
        usual[2] if digits is None else digits,
        is_seldom=is_seldom,
        needs=needs,
        symbols=symbols,
    )


def _count(key: str, title: str, formula: Callable[[Window], float]) -> KpiDefinition:
    return replace(_figure(key, title, formula, digits=0), is_count=True)


def _time_at(limit: WinchLimit, key: str, where: str) -> KpiDefinition:
    """Return the share of time at a `limit` that few winches have or reach, by its `key`; `where` that is, in words."""
    return _figure(key, f"time {where}", lambda w: kpi.percent_true(w.at(limit)), is_seldom=True)


def _of(group: str, *definitions: KpiDefinition) -> list[KpiDefinition]:
    return [replace(definition, group=group) for definition in definitions]


def _events(signal: Signal, events: Sized) -> float:
    """Return how many events there are; NaN where the signal that shows them was not recorded."""
    return float(len(events)) if signal.size else NOT_KNOWN


def _mean(values: Array) -> float:
    return float(values.mean()) if values.size else NOT_KNOWN


KPI_DEFINITIONS: tuple[KpiDefinition, ...] = (
    *_of(UNIT,
        _figure("unit_sigma_m", "load heave, standard deviation", lambda w: w.unit_sigma, "s(z)",
                needs=HEAVE),
        _figure("uncompensated_sigma_m", "load heave with the winch locked, standard deviation",
                lambda w: kpi.sigma(w.uncompensated_heave), "s(z_off)"),
        _figure("unit_efficiency", "efficiency at the load", lambda w: w.unit_efficiency, "1 - s(z)/s(z_off)"),
        _figure("worst_minute", f"worst {kpi.WORSE_WINDOW:g} s, load heave over that with the winch locked",
                lambda w: w.worst_minute, "largest s(z)/s(z_off)", needs=f"{kpi.WORSE_WINDOW:g} s after the transient"),
        _figure("baseline_efficiency", "efficiency at the load, industrial controller",
                lambda w: w.of_baseline("unit_efficiency"), "law industrial"),
        _figure("outlet_efficiency", "efficiency of the rope at the boom tip",
                lambda w: w.outlet_efficiency, "1 - s(z0-p)/s(z0)"),
        _figure("baseline_outlet_efficiency", "efficiency of the rope at the boom tip, industrial controller",
                lambda w: w.of_baseline("outlet_efficiency"), "law industrial"),
        _figure("significant_residual_m", "significant residual", lambda w: kpi.significant(w.unit_sigma), "4 s(z)",
                needs=HEAVE),
        _figure("max_abs_heave_m", "largest load heave about its mean", lambda w: kpi.max_abs(w.heave), needs=HEAVE),
        _figure("uncompensated_max_abs_heave_m", "largest load heave about its mean, winch locked",
                lambda w: kpi.max_abs(w.uncompensated_heave)),
        _figure("heave_p999_m", "99.9th percentile of load heave", lambda w: kpi.percentile_abs(w.heave, 99.9)),
        _figure("boom_tip_sigma_m", "boom-tip heave, standard deviation", lambda w: w.boom_tip_sigma),
        _figure("outlet_sigma_m", "residual of the rope at the boom tip, standard deviation",
                lambda w: w.outlet_sigma, "s(z0-p)"),
        _figure("kappa", "kappa, residual over the theoretical minimum",
                lambda w: kpi.kappa(w.unit_sigma, w.run.sensor_bound, w.run.actuator_bound), "s(z) / bound", digits=2),
    ),
    *_of(TENSION,
        _figure("tension_min_n", "top tension, smallest", lambda w: least(w.tension.value)),
        _figure("tension_mean_n", "top tension, mean", lambda w: _mean(w.tension.value)),
        _figure("tension_max_n", "top tension, largest", lambda w: largest(w.peak_tension.value)),
        _figure("tension_sigma_n", "top tension, standard deviation", lambda w: kpi.sigma(w.tension.value), digits=2),
        _figure("rope_safety_factor", "safety factor of the rope", lambda w: w.factors.get(ROPE, NOT_KNOWN),
                "breaking force / Tmax", needs="the rope's breaking force"),
        _figure("winch_pull_factor", "rated pull of the winch over largest tension",
                lambda w: w.factors.get(WINCH_PULL, NOT_KNOWN), "rated pull / Tmax",
                needs="the winch's rated pull"),
        _figure("attachment_safety_factor", "safety factor of the load's attachment",
                lambda w: w.factors.get(ATTACHMENT, NOT_KNOWN), "breaking force / largest load",
                needs="the tension at the load, and what its attachment carries"),
        _figure("tension_ratio_min", "smallest tension over static", lambda w: w.tension_ratios[0],
                "rT = Tmin/Tstatic"),
        _figure("dynamic_amplification", "dynamic amplification", lambda w: w.tension_ratios[1],
                "DAF = Tmax/Tstatic"),
        _figure("slack_percent", "time with a slack cable", lambda w: w.slack_percent,
                needs="the tension at the load"),
        _count("snaps", "snaps", lambda w: w.snaps(w.tension, w.peak_tension)),
        _figure("uncompensated_rope_safety_factor", "safety factor of the rope, winch locked",
                lambda w: w.uncompensated_rope_factor),
        _figure("uncompensated_tension_ratio_min", "smallest tension over static, winch locked",
                lambda w: w.uncompensated_tension_ratios[0], "rT"),
        _figure("uncompensated_dynamic_amplification", "dynamic amplification, winch locked",
                lambda w: w.uncompensated_tension_ratios[1], "DAF"),
        _count("uncompensated_snaps", "snaps, winch locked",
               lambda w: w.snaps(w.of(w.run.uncompensated_tension), w.of(w.run.uncompensated_peak_tension()))),
    ),
    *_of(WINCH,
        _figure("winch_speed_max_mps", "winch speed, largest", lambda w: largest(np.abs(w.rate.value))),
        _figure("winch_acceleration_max_mps2", "winch acceleration, largest",
                lambda w: largest(np.abs(w.acceleration)), needs="the acceleration of the drum"),
        _figure("time_at_speed_limit_percent", "time at the speed limit", lambda w: kpi.percent_true(w.at_speed_limit)),
        _figure("time_at_acceleration_limit_percent", "time at the acceleration limit",
                lambda w: kpi.percent_true(w.at_acceleration_limit), needs="the acceleration of the drum"),
        _time_at(WinchLimit.PAYOUT, "time_at_payout_limit_percent", "at the end of its payout"),
        _time_at(WinchLimit.POWER, "time_at_power_limit_percent", "at the power limit"),
        _time_at(WinchLimit.TORQUE, "time_at_torque_limit_percent", "at the torque limit"),
        _time_at(WinchLimit.PRESSURE, "time_at_pressure_limit_percent", "at the pressure limit"),
        _time_at(WinchLimit.FLOW, "time_at_flow_limit_percent", "at the flow limit"),
        _figure("time_at_limit_percent", "time at any winch limit", lambda w: kpi.percent_true(w.at_any_limit)),
        _figure("compensating_percent", "time with compensation active",
                lambda w: w.compensating_percent, digits=1),
        _figure("time_above_half_rating_percent", "time above half of rated speed or power", lambda w: w.loaded_percent,
                digits=1),
    ),
    *_of(ENERGY,
        _figure("power_peak_w", "winch power, peak", lambda w: w.power.peak, "max |T v|"),
        _figure("power_mean_abs_w", "winch power, mean magnitude", lambda w: w.power.mean_abs, "mean |T v|"),
        _figure("power_rms_w", "winch power, root mean square", lambda w: w.power.rms),
        _figure("energy_wh_per_h", "winch power, motoring, mean", lambda w: w.power.motoring),
        _figure("energy_regenerated_wh_per_h", "winch power, regenerated, mean", lambda w: w.power.regenerated),
    ),
    *_of(WEAR,
        _figure("rope_travel_m_per_h", "rope over the sheave, per hour", lambda w: w.wear.travel),
        _figure("reversals_per_h", "changes of direction, per hour", lambda w: w.wear.reversals),
        _figure("bending_cycles_per_h", "bending over the sheave, cycles per hour", lambda w: w.wear.bending_cycles),
        _figure("tension_cycles_per_h", "cycles of the top tension, per hour", lambda w: w.load_cycles.per_hour,
                "rainflow"),
        _figure("tension_range_equivalent_n", "damage-equivalent tension range at 1 Hz",
                lambda w: w.load_cycles.equivalent_range, f"S-N slope m = {DAMAGE_EXPONENT:g}", digits=2),
    ),
    *_of(ESTIMATE,
        _figure("nis_in_band_percent", "time in which the filter was consistent",
                lambda w: kpi.percent_true(w.of(w.run.nis_in_band).value), "NIS inside its 95 % band", digits=1),
    ),
    *_of(TIMING,
        _figure("real_time_factor", "real-time factor", lambda w: w.run.real_time_factor, digits=1),
        _figure("loop_age_p50_s", "control latency, median", lambda w: w.run.loop_age[0], unit="ms", scale=1e3),
        _figure("loop_age_p99_s", "control latency, 99 %", lambda w: w.run.loop_age[1], unit="ms", scale=1e3),
        _figure("loop_age_max_s", "control latency, largest", lambda w: w.run.loop_age[2], unit="ms", scale=1e3),
        _figure("controller_tick_p999_s", "controller execution time, 99.9 %",
                lambda w: kpi.percentile(w.of(w.run.execution_time).value, 99.9), unit="ms", scale=1e3),
        _figure("controller_tick_max_s", "controller execution time, largest",
                lambda w: kpi.percentile(w.of(w.run.execution_time).value, 100.0), unit="ms", scale=1e3),
        _count("missed_deadlines", "missed deadlines", lambda w: w.run.missed_deadlines),
        _count("late_commands", "late winch commands", lambda w: w.run.late_commands),
    ),
    *_of(LANDING,
        _count("landings", "landings", lambda w: _events(w.run.touchdown, w.landings)),
        _count("landings_held", "landings followed by constant tension",
               lambda w: _events(w.run.touchdown, [time for time in w.times_to_tension if math.isfinite(time)])),
        _figure("touchdown_speed_mps", "touchdown speed of the load", lambda w: w.landed(lambda one: one.speed),
                needs="a landing, and the contact with the bottom"),
        _figure("touchdown_rebound_m", "rebound after touchdown",
                lambda w: w.landed(lambda one: one.rebound)),
        _count("lift_offs", "contact lost before lift-off",
               lambda w: w.landed(lambda one: one.lift_offs)),
        _figure("landing_to_tension_s", "time from touchdown to constant tension",
                lambda w: max(w.times_to_tension, default=NOT_KNOWN)),
    ),
    *_of(CHANGES,
        _count("mode_changes", "changes of mode", lambda w: _events(w.run.mode_changes, w.mode_changes)),
        _count("compensation_losses", "unrequested losses of compensation",
               lambda w: _events(w.run.losses, np.flatnonzero(w.of(w.run.losses).value))),
        _figure("mode_change_heave_max_m", f"largest load heave within {AFTER_CHANGE:g} s of a change",
                lambda w: w.after_changes(w.run.unit_heave)),
        _figure("mode_change_acceleration_max_mps2",
                f"largest winch acceleration within {AFTER_CHANGE:g} s of a change",
                lambda w: kpi.largest_after(w.rate.time, w.acceleration, w.mode_changes, AFTER_CHANGE)
                if w.acceleration.size == w.rate.size else NOT_KNOWN),
    ),
    *_of(DRIVEN,
        _figure("unit_heave_amplitude_m", "load heave, first harmonic", lambda w: w.harmonics[0].amplitude, digits=3),
        _figure("unit_heave_phase_deg", "load heave, lead over the boom tip",
                lambda w: kpi.phase_lead_degrees(w.harmonics[0], w.harmonics[1])),
        _figure("top_tension_mean_n", "top tension, mean of the fit", lambda w: w.harmonics[2].mean, digits=4),
        _figure("top_tension_amplitude_n", "top tension, first harmonic", lambda w: w.harmonics[2].amplitude, digits=4),
    ),
)  # fmt: skip
"""All KPIs in the order of a table."""

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


OF_WALL_TIME = ("loop_age_p50_s", "loop_age_p99_s", "loop_age_max_s", "missed_deadlines")
"""Figures of how a run keeps up with the wall clock."""
COUNT_OF_EVENTS = {LANDING: "landings", CHANGES: "mode_changes"}
"""Figures that count the events of a group; people see the group only where there are any."""


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


def as_seen(values: Mapping[str, float], pacing: str) -> dict[str, float]:
    """Return the `values` of a run by key as people see them: where its `pacing` is lockstep, without those of wall
    time, which has no effect there.
    """
    left_out = OF_WALL_TIME if pacing == LOCKSTEP else ()
    return {key: math.nan if key in left_out else value for key, value in values.items()}


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
        marks = {BESIDE.get(source_of(definition.key, of_run), "") for of_run in sources.values()} - {""}
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
