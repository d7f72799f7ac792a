"""Changes of the beliefs as findings: each reported once, those of the winch once it has settled."""

from __future__ import annotations

import math

from winch_controller_node.beliefs.beliefs import Belief, Beliefs, Finding
from winch_controller_node.beliefs.quantities import QUANTITIES
from winch_controller_node.node_parameters import WinchControllerParameters

SETTLED, LONGEST = 10.0, 40.0
"""A change of the winch is reported once it has been steady for the first time, at the latest after the second [s]."""


class Report:
    """Says what has changed since it last said so.

    `parameters` : nominal
    """

    def __init__(self, parameters: WinchControllerParameters) -> None:
        self._nominal = {name: quantity.nominal_in(parameters) for name, quantity in QUANTITIES.items()}
        self._reported: dict[str, float] = {}
        self._excluded = ""
        self._pending: dict[str, tuple[float, float, float]] = {}  # value, since it rests, since it is new
        self._refused: dict[str, bool] = {}  # owner, is reported

    def refuse(self, owner: str) -> None:
        """Note that no controller can be designed for what was found of an `owner`."""
        self._refused.setdefault(owner, False)

    def news(self, beliefs: Beliefs, now: float) -> tuple[Finding, ...]:
        """Return what is new of `beliefs` at a time `now` [s]."""
        found: list[Finding] = []
        for name, quantity in QUANTITIES.items():
            nominal = self._nominal[name]
            belief = beliefs.values.get(name) or Belief(name, nominal)
            before = self._reported.get(name, nominal)
            if name == "mru.bias_sigma" or (belief.nats == 0.0 and before == nominal):
                # it goes with the drift, or is assumed and no record has said so
                continue
            if not self._is_due(name, belief.value, before, now, waits=quantity.owner == "winch"):
                continue
            self._reported[name] = belief.value
            code = "nominal" if belief.value == nominal else "differs"
            found.append(Finding(code, name, belief.value, quantity.unit, before, belief.nats, belief.since))
        if beliefs.excluded != self._excluded:
            if beliefs.excluded == "encoder":
                pass  # the core has said so: drum or encoder
            elif beliefs.excluded:
                found.append(Finding("excluded", beliefs.excluded))
            elif self._excluded:
                found.append(Finding("recovered", self._excluded))
            self._excluded = beliefs.excluded
        found += [Finding("refused", owner) for owner, is_reported in self._refused.items() if not is_reported]
        self._refused = dict.fromkeys(self._refused, True)
        return tuple(found)

    def _is_due(self, name: str, value: float, before: float, now: float, *, waits: bool) -> bool:
        """Tell whether a value is to be reported now."""
        if not _differs(name, value, before):
            self._pending.pop(name, None)
            return False
        last, rests, new = self._pending.get(name, (value, now, now))
        rests = now if _differs(name, value, last) else rests
        self._pending[name] = (value, rests, new)
        is_due = not waits or now - rests >= SETTLED or now - new >= LONGEST
        if is_due:
            self._pending.pop(name)
        return is_due


def _differs(name: str, value: float, before: float) -> bool:
    """Tell whether two values of a quantity differ by what is worth a report."""
    quantity = QUANTITIES[name]
    if quantity.relative > 0.0 and value * before > 0.0:
        return abs(math.log(value / before)) > quantity.relative
    return abs(value - before) > quantity.absolute
