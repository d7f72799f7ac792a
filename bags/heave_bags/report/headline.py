"""The few figures of merit that a run ends with and that its report shows large; the whole table has all."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from heave_node.criteria import Criterion
from heave_node.interface.codes import WinchLimit

from heave_bags.analyse import analysis, kpi_set
from heave_bags.analyse.kpis.window import Window
from heave_bags.analyse.reading.stored import as_number, number
from heave_bags.analyse.run_record import RunRecord
from heave_bags.analyse.verdict import LEAST_SHARE, required_words, why_not_judged

MOST = 8
"""Figures of merit that a person takes in at a glance."""
OF_A_LANDING = ("touchdown_speed_mps", "touchdown_rebound_m", "landing_to_tension_s")
USUAL = (
    *("unit_sigma_m", "uncompensated_sigma_m", "unit_efficiency", "outlet_efficiency"),
    *("baseline_efficiency", "baseline_outlet_efficiency", "rope_safety_factor", "winch_speed_max_mps"),
    *("time_at_limit_percent", "tension_ratio_min", "winch_pull_factor", "attachment_safety_factor"),
    *("power_peak_w", "tension_max_n", "boom_tip_sigma_m"),
)
"""Figures of merit in the order of their weight: a run shows the first MOST that are known, a landing its own first."""
MUCH_LESS = 0.03
"""Efficiency at the load less than that at the boom tip by so much, and more than the rope's own loss, is explained."""
OF_BASELINE = ("baseline_efficiency", "baseline_outlet_efficiency")
"""Figures of merit of the baseline law."""
OF_A_LAW = ("unit_efficiency", "outlet_efficiency", *OF_BASELINE)
"""Figures of merit that mean nothing where the law is off."""


def headline(record: RunRecord, values: Mapping[str, float]) -> list[str]:
    """Return the keys of the figures of merit that sum the run `record` up, by its `values` (`RunRecord.kpis`)."""
    known = (key for key in (*OF_A_LANDING, *USUAL) if math.isfinite(values[key]))
    return [key for key in known if record.moves_winch or key not in OF_A_LAW][:MOST]


def note(record: RunRecord, key: str) -> str:
    """Return what bounds the figure of merit `key` in the run `record`, in words; "" where nothing does."""
    notes = [f"required {required_words(one)}" for one in _criteria(record, key)]
    notes += [f"required at least {one.required:.4g}" for one in record.signals.strengths if one.key == key]
    if key in OF_BASELINE and (active := _seldom_active(record)):
        notes.append(active)
    if key == "winch_speed_max_mps" and math.isfinite(record.signals.speed_limit):
        notes.append(f"limit {record.signals.speed_limit:g} m/s")
    if key == "winch_speed_max_mps" and (acting := _acting(record)):
        notes.append(f"time at limits: {acting}")
    return "; ".join(notes)


def _acting(record: RunRecord) -> str:
    """Return which limits of the winch acted in a run, and for how much of the time; "" where none did."""
    values, power = record.kpis(), record.signals.power_limit
    own = {WinchLimit.POWER: f" (at most {1e-3 * power:g} kW)" if math.isfinite(power) else ""}
    shares = {one: values.get(f"time_at_{one.name.lower()}_limit_percent", 0.0) for one in WinchLimit if one.name}
    acting = sorted((one for one, share in shares.items() if share > 0.0), key=lambda one: -shares[one])
    return ", ".join(f"{str(one.name).lower()} {shares[one]:.1f} %{own.get(one, '')}" for one in acting)


def is_missed(record: RunRecord, key: str, value: float) -> bool:
    """Return whether the figure of merit `key` of the run `record` has a `value` [SI] that breaks a bound on it."""
    is_short = any(one.key == key and value < one.required for one in record.signals.strengths)
    return is_short or any(not one.is_met(value) for one in _criteria(record, key))


def _criteria(record: RunRecord, key: str) -> list[Criterion]:
    """Return the criteria on the figure of merit `key` by which the run `record` is judged."""
    return [] if why_not_judged(record) else [one for one in record.wanted if one.kpi == key]


def _seldom_active(record: RunRecord) -> str:
    """Return how long the baseline of a run compensated, where that was seldom; "" else."""
    baseline = record.signals.baseline
    percent = math.nan if baseline is None else Window(baseline, record.start, record.end).compensating_percent
    return f"active {percent:.0f} % of the time" if percent < 100.0 * LEAST_SHARE else ""


def on_industrial(record: RunRecord, values: Mapping[str, float]) -> str:
    """Return what must be known of the baseline law's efficiencies in the run `record` with figures of merit `values`;
    "": nothing.

    It may have lost compensation, or the load may swing more than the rope at the boom tip: nothing in that law damps
    the load. Its swing from before compensation, and what the rope at the boom tip adds at its natural period, die by
    drag alone: T = 2 pi sqrt((m + m_a + m_rope / 3) L / EA).
    """
    if (active := _seldom_active(record)) and record.signals.baseline is not None:
        lost = f", lost {record.signals.baseline.lost}" if record.signals.baseline.lost else ""
        included = "Its efficiencies include the time without compensation."
        return f"Industrial controller: compensation {active}{lost}. {included}"
    at_tip, at_load = values["baseline_outlet_efficiency"], values["baseline_efficiency"]
    if not at_tip - at_load > max(MUCH_LESS, 1.0 - at_tip):
        return ""
    plant = record.parameters.get("cable_sim", {})
    length, mass, rope, stiffness = (
        number(plant, name, math.nan)
        for name in ("length", "unit.mass", "cable.mass_per_length", "cable.axial_stiffness")
    )
    added = plant.get("unit.added_mass")
    moved = mass + rope * length / 3.0 + (as_number(added[-1]) if isinstance(added, list | tuple) and added else 0.0)
    period = 2.0 * math.pi * math.sqrt(moved * length / stiffness) if moved * length > 0.0 < stiffness else math.nan
    own = f" ({period:.0f} s)" if math.isfinite(period) else ""
    return (
        "The industrial controller holds the rope at the boom tip but does not damp the load, which keeps swinging at "
        f"its natural period{own}."
    )


def table(records: Sequence[RunRecord]) -> str:
    """Return the figures of merit that sum up the runs `records`, side by side, with what bounds those of one run."""
    values = {record.name: record.kpis() for record in records}
    keys = list(dict.fromkeys(key for record in records for key in headline(record, values[record.name])))
    notes = {key: note(records[0], key) for key in keys} if len(records) == 1 else {}
    shown = kpi_set.table(values, {record.name: record.sources for record in records}, keys=keys, notes=notes)
    why = on_industrial(records[0], values[records[0].name]) if len(records) == 1 else ""
    return "\n".join([shown, *([why] if why else []), *analysis.remarks(records)])
