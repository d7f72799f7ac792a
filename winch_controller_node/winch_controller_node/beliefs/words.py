"""Findings as alarms: what, value against nominal, consequence, action."""

from __future__ import annotations

import math
from collections.abc import Sequence

from heave_node.interface.alarm import Alarm

from winch_controller_node.beliefs.beliefs import Finding
from winch_controller_node.beliefs.quantities import QUANTITIES
from winch_controller_node.interface.alarms import ALARMS

DIGITS = {"winch": 3, "sea": 1}
"""Parts of which all that is new is one alarm, and the digits of its values."""

OTHERS = {
    "excluded": "SENSOR_LOST, {}: excluded",
    "recovered": "SENSOR_RECOVERED, {}",
    "refused": "NOT_DESIGNABLE, {}",
    "nominal": "NOMINAL, {}",
}
"""Alarm of any other finding, with the part that it is about."""


def alarms_of(findings: Sequence[Finding]) -> list[Alarm]:
    """Return the `findings` as alarms; all that is new of the winch is one, and so is that of the sea."""
    models: dict[str, list[str]] = {part: [] for part in DIGITS}
    found = []
    for one in findings:
        quantity = QUANTITIES.get(one.quantity)
        if quantity is not None and quantity.owner in DIGITS:
            models[quantity.owner].append(_change(quantity.label, one, DIGITS[quantity.owner]))
        else:
            found.append(_alarm(one))
    updated = [
        ALARMS.alarm(f"{part.upper()}_MODEL_UPDATED", changes=", ".join(changes))
        for part, changes in models.items()
        if changes
    ]
    return found + updated


def _change(label: str, finding: Finding, digits: int) -> str:
    if finding.unit == "W":
        value, before = (
            f"{power / 1e3:.1f} kW" if power > 0.0 else "none" for power in (finding.value, finding.nominal)
        )
        return f"{label} {value} (was {before})"
    value = f"{finding.value:.{digits}f} {finding.unit}".rstrip()
    value += " on trial" if finding.nats == 0.0 else ""  # of a limit that no record needs any more
    return f"{label} {value} (was {finding.nominal:.{digits}f})"


def _alarm(finding: Finding) -> Alarm:
    if finding.code in OTHERS:
        return ALARMS.alarm(OTHERS[finding.code].format(finding.quantity.partition(".")[0].upper()))
    row = ALARMS[QUANTITIES[finding.quantity].alarm]
    nominal = finding.nominal if math.isfinite(finding.nominal) else 0.0
    values = {"value": finding.value, "nominal": nominal}
    return row.alarm(**{name: values[name] for name in row.names})
