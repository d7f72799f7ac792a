"""What a scenario requires of a run: criteria on its figures of merit, under `/**` and `wanted`.

The end of a figure's key is its unit (`significant_residual_m`). A bound with a unit of its own is converted to that
one, and the key may then go without it.

>>> parse_criterion(Given("<= 5 cm", "wanted.significant_residual", "own.yaml: /**"))
Criterion(kpi='significant_residual_m', relation='<=', bound=0.05)
>>> parse_criterion(Given("<= 0.05", "wanted.significant_residual_m", "own.yaml: /**")).is_met(0.04)
True
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from heave_node.files.units import UNITS
from heave_node.parameters import Given, ParameterError

WANTED = "wanted."
"""Prefix of the criteria among the parameters of a run."""

_RELATIONS: dict[str, Callable[[float, float], bool]] = {
    "<=": operator.le,
    ">=": operator.ge,
    "<": operator.lt,
    ">": operator.gt,
}
_TEXT = re.compile(r"(<=|>=|<|>)\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(?:\s*([^\d\s.+-]\S*|1/h))?")
_KEY = re.compile(r"[a-z][a-z0-9_]*")


UNITS_OF_KEYS: Mapping[str, Mapping[str, float]] = {
    "_wh_per_h": {"Wh/h": 1.0, "kWh/h": 1e3, "W": 1.0, "kW": 1e3},
    "_m_per_h": {"m/h": 1.0, "km/h": 1e3},
    "_per_h": {"1/h": 1.0},
    "_mps2": UNITS["acceleration"],
    "_mps": UNITS["speed"],
    "_percent": {"%": 1.0},
    "_deg": {"deg": 1.0, "rad": math.degrees(1.0)},
    "_m": UNITS["length"],
    "_n": UNITS["force"],
    "_w": UNITS["power"],
    "_s": UNITS["time"],
    "": {"%": 0.01},
}
"""Units that a bound may have, by the end of a figure's key, and their size in the unit of the key; a longer end goes
first, and no end is a ratio."""


@dataclass(frozen=True)
class Criterion:
    """A figure of merit and the bound that it must keep."""

    kpi: str  # key of the figure as in JSON; its unit is part of it (`unit_sigma_m`)
    relation: str  # <=, >=, < or >
    bound: float  # in the unit of the figure

    def is_met(self, value: float) -> bool:
        """Return whether the `value` of the figure keeps the bound; one that could not be computed (NaN) does not."""
        return not math.isnan(value) and _RELATIONS[self.relation](value, self.bound)

    @property
    def text(self) -> str:
        """The relation and the bound, as a scenario file has them."""
        return f"{self.relation} {self.bound!r}"


def parse_criterion(given: Given) -> Criterion:
    """Return the criterion `given` by a scenario or the command line.

    Raises ParameterError for what is not a relation and a number with or without a unit of the figure, or not the name
    of a figure. Whether there is such a figure is known where figures are computed.
    """
    key = given.name.removeprefix(WANTED)
    found = _TEXT.fullmatch(given.value.strip()) if isinstance(given.value, str) else None
    if found is None or not _KEY.fullmatch(key):
        raise ParameterError(
            f"{given.where}: {given.name} = {given.value!r} is not allowed: it must be a figure of merit and a string "
            'of relation and number, with or without a unit, for example wanted.unit_sigma_m: "<= 0.005" or "<= 5 mm"'
        )
    relation, number, unit = found.groups()
    if unit is None:
        return Criterion(key, relation, float(number))
    unit = unit.replace("²", "^2").replace("s2", "s^2")
    end = end_of(key)
    if not end and unit != "%":
        end = next((end for end, units in UNITS_OF_KEYS.items() if unit in units), "")
        key += end
    if unit not in UNITS_OF_KEYS[end]:
        takes = ", ".join(UNITS_OF_KEYS[end]) if end else "m, cm, mm, kN, t, m/s, m/min, s, kW, deg or %"
        raise ParameterError(f"{given.where}: {given.name} = {given.value!r}: {unit} is no unit of {key}; use {takes}")
    return Criterion(key, relation, float(f"{float(number) * UNITS_OF_KEYS[end][unit]:.12g}"))


def end_of(key: str) -> str:
    """Return the end of a figure's `key` that is its unit; "" for a ratio or a count."""
    return next(end for end in UNITS_OF_KEYS if key.endswith(end))
