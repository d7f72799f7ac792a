"""The tables of a sizing study: the answer, what each winch can work in, what an hour of it asks."""

from __future__ import annotations

import math

from heave_node.sheet import Column, Sheet

from heave_studies.sizing.candidates import PARTICULARS
from heave_studies.sizing.study import Sized


def number(value: float) -> str:
    """Return a `value` with one decimal, none where it is whole; a dash for one that is not known."""
    return f"{value:.1f}".removesuffix(".0") if math.isfinite(value) else "-"


KNEES = Sheet(
    Column("particular", "particular.heading"),
    Column("knee", "text"),
    Column("workable, the scenario's [%]", "share", form=".1f", scale=100.0),
    Column("workable, the best tried [%]", "best", form=".1f", scale=100.0),
)
"""The answer: of each particular the knee, and what the scenario's value and the best one give."""


def _share(one: Sized) -> str:
    spread = f" ({100 * one.lower:.1f} to {100 * one.upper:.1f})" if one.upper > one.lower else ""
    return f"{100 * one.share:.1f}{spread}"


TITLE = Column("winch", "winch.title", "winch")
_KEYS = ("speed_mps", "acceleration_mps2", "power_limit_w", "delay_s")

ABILITY = Sheet(
    TITLE,
    *(Column(one.heading, f"winch.{one.name}", key, one.text) for one, key in zip(PARTICULARS, _KEYS, strict=True)),
    Column("workable [%]", _share),
    Column("", "share", "workable_share"),
    Column("", "lower", "workable_share_lower"),
    Column("", "upper", "workable_share_upper"),
    Column("mean limit Hs [m]", lambda one: float(one.limit["limit"].mean()), "limit_mean_m", ".2f"),
)
"""What each winch can work in."""

DUTY = Sheet(
    TITLE,
    Column("peak power [kW]", "duty.peak", "power_peak_w", number, 1e-3),
    Column("rms power [kW]", "duty.rms", "power_rms_w", number, 1e-3),
    Column("energy at the drum [kWh/h]", "duty.motoring", "energy_wh_per_h", number, 1e-3),
    Column("", "duty.regenerated", "energy_regenerated_wh_per_h"),
    Column("energy bought [kWh/h]", "duty.electric", "electric_energy_wh_per_h", number, 1e-3),
    Column("cost [1/h]", "duty.cost", "energy_cost_per_h", ".2f"),
    Column("heat [kWh/h]", "duty.heat", "heat_wh_per_h", number, 1e-3),
    Column("rope [km/h]", "duty.travel", "rope_travel_m_per_h", number, 1e-3),
    Column("reversals [1/h]", "duty.reversals", "reversals_per_h", ".0f"),
    Column("bends [1/h]", "duty.bending_cycles", "bending_cycles_per_h", ".0f"),
    Column("above half rating [% of time]", "duty.loaded", "time_above_half_rating_percent", number),
    Column("tension cycles [1/h]", "duty.tension_cycles", "tension_cycles_per_h", ".0f"),
    Column("equivalent tension range [kN]", "duty.tension_range", "tension_range_equivalent_n", number, 1e-3),
)
"""What an hour of compensation asks of each winch."""

BUYERS = Sheet(ABILITY, *DUTY[1:])
"""The buyer's table, for machines."""
