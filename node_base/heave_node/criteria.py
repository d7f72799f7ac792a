"""What a scenario requires of a run: criteria on its figures of merit, `wanted: {unit_sigma_m: "<= 0.005"}` under
`/**`.

>>> parse_criterion(Given("<= 0.005", "wanted.unit_sigma_m", "own.yaml: /**")).is_met(0.004)
True
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable
from dataclasses import dataclass

from heave_node.parameters import Given, ParameterError

WANTED = "wanted."
"""Prefix of the criteria among the parameters of a run."""

_RELATIONS: dict[str, Callable[[float, float], bool]] = {
    "<=": operator.le,
    ">=": operator.ge,
    "<": operator.lt,
    ">": operator.gt,
}
_TEXT = re.compile(r"(<=|>=|<|>)\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)")
_KEY = re.compile(r"[a-z][a-z0-9_]*")


@dataclass(frozen=True)
class Criterion:
    """A figure of merit and the bound that it must keep.

    Attributes
    ----------
    kpi : key of the figure as in JSON; its unit is part of it (`unit_sigma_m`)
    relation : <=, >=, < or >
    bound : in the unit of the figure
    """

    kpi: str
    relation: str
    bound: float

    def is_met(self, value: float) -> bool:
        """Return whether the `value` of the figure keeps the bound; one that could not be computed (NaN) does not."""
        return not math.isnan(value) and _RELATIONS[self.relation](value, self.bound)

    @property
    def text(self) -> str:
        """The relation and the bound, as a scenario file has them."""
        return f"{self.relation} {self.bound!r}"


def parse_criterion(given: Given) -> Criterion:
    """Return the criterion `given` by a scenario or the command line.

    Raises ParameterError for what is not a relation and a number, or not the name of a figure. Whether there is such a
    figure is known where figures are computed.
    """
    kpi = given.name.removeprefix(WANTED)
    found = _TEXT.fullmatch(given.value.strip()) if isinstance(given.value, str) else None
    if found is None or not _KEY.fullmatch(kpi):
        raise ParameterError(
            f"{given.where}: {given.name} = {given.value!r} is not allowed: it must be a figure of merit and a string "
            'of relation and number, for example wanted.unit_sigma_m: "<= 0.005"'
        )
    return Criterion(kpi, found[1], float(found[2]))
