"""The few figures of merit that a run ends with and that its report shows large; the whole table has all."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from heave_bags.analyse import kpi_table
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bags.analyse.run_record import RunRecord
from heave_bags.analyse.verdict import required_words

MOST = 8
"""Figures of merit that a person takes in at a glance."""
OF_A_LANDING = ("touchdown_speed_mps", "touchdown_rebound_m", "landing_to_tension_s")
USUAL = (
    *("unit_sigma_m", "uncompensated_sigma_m", "unit_efficiency", "baseline_efficiency", "rope_safety_factor"),
    *("tension_ratio_min", "winch_speed_max_mps", "time_at_limit_percent", "winch_pull_factor"),
    *("attachment_safety_factor", "outlet_efficiency", "power_peak_w", "tension_max_n", "boom_tip_sigma_m"),
)
"""Figures of merit in the order of their weight: a run shows the first MOST that are known, a landing its own first."""
OF_A_LAW = ("unit_efficiency", "baseline_efficiency", "outlet_efficiency")
"""Figures of merit that mean nothing where the law is off."""


def headline(record: RunRecord, values: Mapping[str, float]) -> list[str]:
    """Return the keys of the figures of merit that sum the run `record` up, by its `values` (`RunRecord.kpis`)."""
    known = (key for key in (*OF_A_LANDING, *USUAL) if math.isfinite(values[key]))
    return [key for key in known if record.moves_winch or key not in OF_A_LAW][:MOST]


def note(record: RunRecord, key: str) -> str:
    """Return what bounds the figure of merit `key` in the run `record`, in words; "" where nothing does."""
    notes = [f"required {required_words(one)}" for one in record.wanted if one.kpi == key]
    notes += [f"required at least {one.required:.4g}" for one in record.signals.strengths if one.key == key]
    if key == "winch_speed_max_mps" and math.isfinite(record.signals.speed_limit):
        notes.append(f"limit {record.signals.speed_limit:g} m/s")
    if key in record.bands:
        _, low, high = record.bands[key]
        notes.append(f"90 % band {DEFINITION_OF[key].text(low)} to {DEFINITION_OF[key].text(high)}")
    return "; ".join(notes)


def is_missed(record: RunRecord, key: str, value: float) -> bool:
    """Return whether the figure of merit `key` of the run `record` has a `value` [SI] that breaks a bound on it."""
    is_short = any(one.key == key and value < one.required for one in record.signals.strengths)
    return is_short or any(one.kpi == key and not one.is_met(value) for one in record.wanted)


def table(records: Sequence[RunRecord]) -> str:
    """Return the figures of merit that sum up the runs `records`, side by side, with what bounds those of one run."""
    values = {record.name: record.kpis() for record in records}
    keys = list(dict.fromkeys(key for record in records for key in headline(record, values[record.name])))
    notes = {key: note(records[0], key) for key in keys} if len(records) == 1 else {}
    return kpi_table.table(values, {record.name: record.sources for record in records}, keys=keys, notes=notes)
