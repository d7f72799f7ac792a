"""Units in which files and command lines state a quantity: one table, by dimension."""

from __future__ import annotations

import math
from collections.abc import Mapping

from heave_node.numerics.constants import STANDARD_GRAVITY

_DEGREE = math.radians(1.0)
_POUND = 0.45359237 * STANDARD_GRAVITY
UNITS: Mapping[str, Mapping[str, float]] = {
    "length": {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "ft": 0.3048},
    "speed": {"m/s": 1.0, "cm/s": 0.01, "mm/s": 0.001, "m/min": 1.0 / 60.0, "ft/s": 0.3048, "ft/min": 0.3048 / 60.0},
    "acceleration": {"m/s^2": 1.0, "cm/s^2": 0.01, "mm/s^2": 0.001, "g": STANDARD_GRAVITY},
    "angle": {"rad": 1.0, "deg": _DEGREE, "mrad": 0.001},
    "turn rate": {"rad/s": 1.0, "deg/s": _DEGREE, "deg/min": _DEGREE / 60.0},
    "force": {
        "N": 1.0,
        "daN": 10.0,
        "kN": 1e3,
        "MN": 1e6,
        "kgf": STANDARD_GRAVITY,
        "kg": STANDARD_GRAVITY,
        "t": 1e3 * STANDARD_GRAVITY,
        "tf": 1e3 * STANDARD_GRAVITY,
        "lbf": _POUND,
        "kip": 1e3 * _POUND,
    },
    "pressure": {
        **{"Pa": 1.0, "hPa": 100.0, "mbar": 100.0, "kPa": 1e3, "dbar": 1e4, "bar": 1e5, "MPa": 1e6},
        "psi": _POUND / 0.0254**2,
    },
    "number": {"": 1.0},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0},
    "power": {"W": 1.0, "kW": 1e3, "MW": 1e6},
}
"""Sizes of units in SI units, by dimension."""
