"""The table of the rolling window of the figures of merit."""

from __future__ import annotations

from enum import IntEnum

from heave_core.rows import Row, structure

KPI_DESIGN = structure(
    "KpiDesign",
    "The window, and when the winch is at its limits.",
    Row("tick_period", "s", "time of a tick"),
    Row("rows", "", "ticks that the window holds; whoever calls has the place for them"),
    Row("speed", "m/s", "from which on the winch is at its limit"),
    Row("acceleration", "m/s^2", "from which on the winch is at its limit"),
)

KPI_STATE = structure(
    "KpiState",
    "Beside the rows of the window.",
    Row("count", "", "ticks so far"),
    Row("last_rate", "m/s", "of the winch at the last tick"),
)

KPI_ROW = structure(
    "KpiRow",
    "A tick of the window; NaN: not known.",
    Row("unit", "m", "heave of the unit"),
    Row("uncompensated", "m", "heave of the uncompensated one"),
    Row("tip", "m", "heave of the boom tip"),
    Row("payout", "m", "of the winch, about its mean"),
    Row("rate", "m/s", "of the winch"),
    Row("acceleration", "m/s^2", "of the winch"),
    Row("tension", "N", "at the top"),
    Row("at_limit", "", "1: the winch is at its limit"),
)

KPI_WINDOW = structure(
    "KpiWindow",
    "Statistics over the ticks whose heaves are known, as far as they are known now; NaN: none.",
    Row("rows", "", "ticks that count"),
    Row("unit", "m", "standard deviation of the unit"),
    Row("uncompensated", "m", "standard deviation of the uncompensated one"),
    Row("tip", "m", "standard deviation of the boom tip"),
    Row("outlet", "m", "standard deviation of boom tip less payout"),
    Row("largest", "m", "distance of the unit from its mean"),
    Row("speed", "m/s", "largest of the winch"),
    Row("acceleration", "m/s^2", "largest of the winch"),
    Row("power", "W", "largest of tension times speed"),
    Row("mean_power", "W", "mean of its absolute value"),
    Row("least_tension", "N", "at the top"),
    Row("largest_tension", "N", "at the top"),
    Row("at_limit", "", "share of the ticks at which the winch is at its limit"),
)

STRUCTURES = (KPI_DESIGN, KPI_STATE, KPI_ROW, KPI_WINDOW)
"""In the order in which C++ needs them."""

RECORDS = STRUCTURES
"""What Python and C++ hold together."""

ENUMERATIONS: tuple[type[IntEnum], ...] = ()
"""Names of numbers: none."""

SIZES: dict[str, int] = {}
"""Sizes of arrays: none."""
