"""A figure of merit (KPI), and the unit, scale and digits in which tables show the quantity that its key ends in."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from heave_node.numerics.arrays import Array

NOT_KNOWN = math.nan
QUANTITIES: Mapping[str, tuple[str, float]] = {
    "m": ("cm", 100.0),
    "N": ("kN", 1e-3),
    "m/s": ("m/s", 1.0),
    "m/s²": ("m/s²", 1.0),
    "W": ("kW", 1e-3),
}
"""Unit in which each quantity is shown everywhere, and that over its SI unit: motion, force, ... power."""
SHOWN: Mapping[str, tuple[str, float, int]] = {
    "_wh_per_h": ("kW", 1e-3, 2),
    "_m_per_h": ("m/h", 1.0, 0),
    "_per_h": ("1/h", 1.0, 0),
    "_percent": ("%", 1.0, 1),
    "_efficiency": ("%", 100.0, 1),
    "_factor": ("", 1.0, 2),
    "_mps2": (*QUANTITIES["m/s²"], 2),
    "_mps": (*QUANTITIES["m/s"], 2),
    "_deg": ("deg", 1.0, 1),
    "_m": (*QUANTITIES["m"], 2),
    "_n": (*QUANTITIES["N"], 1),
    "_w": (*QUANTITIES["W"], 1),
    "_s": ("s", 1.0, 2),
    "": ("", 1.0, 3),
}
"""Unit, scale and digits of a figure in a table, by the end of its key; the first that fits."""
POSSIBLE: Mapping[str, tuple[float, float]] = {
    "_percent": (0.0, 100.0),
    "_efficiency": (-math.inf, 1.0),
    **dict.fromkeys(("_deg", "_mean_n", "_min_n", "_ratio_min"), (-math.inf, math.inf)),
    "": (0.0, math.inf),
}
"""Least and largest value that a figure can have, by the end of its key; the first that fits."""

SIGNIFICANT = 4
"""Digits of a figure that decimals do not go beyond: no run of a sea is known better."""


@dataclass(frozen=True)
class KpiDefinition:
    """One figure of merit."""

    key: str  # its name in JSON, which ends in the SI unit
    title: str  # its name for people, in words alone
    unit: str  # in which a table shows it
    group: str  # under which heading a report shows it
    # its value over a `Window` of a run, or over what another table of figures is made from; NaN where it cannot be
    # known
    formula: Callable[[Any], float]
    scale: float = 1.0  # a table shows `scale` times the value [-]
    digits: int = 3  # decimals in a table
    is_count: bool = False  # a whole number
    is_seldom: bool = False  # people see it only where it is not 0
    needs: str = ""  # what a run must have for it to be known, in words; "": nothing that people could miss
    symbols: str = ""  # the formula in the symbols of the field, for those who know them; "": the title says it all

    def text(self, value: float) -> str:
        """Return the value as a table shows it, at most SIGNIFICANT digits; a dash where it could not be computed."""
        if not math.isfinite(value):
            return "-"
        shown = value * self.scale
        before = len(f"{abs(shown):.0f}")  # digits before the point
        digits = min(self.digits, max(SIGNIFICANT - before, 0))
        return f"{round(shown, digits) + 0.0:.{digits}f}"  # + 0.0: no sign before a zero

    def bound(self, value: float) -> str:
        """Return a bound, the SI `value`, in the unit of the table, no digit lost, with that unit."""
        return f"{value * self.scale:.6g} {self.unit}".rstrip()


def least(values: Array) -> float:
    """Return the smallest of `values`; NaN where there are none."""
    return float(values.min()) if values.size else NOT_KNOWN


def largest(values: Array) -> float:
    """Return the largest of `values`; NaN where there are none."""
    return float(values.max()) if values.size else NOT_KNOWN
