"""Findings as alarms: what, value against nominal, consequence, action."""

from __future__ import annotations

import math
from collections.abc import Sequence

from heave_node.interface.alarm import Alarm

from winch_controller_node.beliefs.beliefs import Finding
from winch_controller_node.interface.alarms import ALARMS

WINCH_LABELS = {
    "winch.time_constant": "time constant",
    "winch.command_delay": "command delay",
    "winch.speed_gain": "gain by the encoder",
    "winch.hauling_gain": "gain of hauling in over that",
    "winch.creep": "creep",
    "winch.speed_out": "speed limit paying out",
    "winch.speed_in": "speed limit hauling in",
    "winch.acceleration_out": "acceleration limit paying out",
    "winch.acceleration_in": "acceleration limit hauling in",
    "winch.power_limit": "power limit",
    "winch.deadband": "dead zone",
    "winch.backlash": "encoder play",
}

SEA_LABELS = {
    "sea.significant_wave_height": "significant wave height",
    "sea.peak_period": "peak period",
    "sea.swell.significant_wave_height": "swell, significant wave height",
    "sea.swell.peak_period": "swell, peak period",
}

CODES = {
    "mru.scale": "MRU_SCALE_ERROR",
    "mru.offset": "MRU_OFFSET",
    "mru.delay": "MRU_DELAYED",
    "mru.high_pass_period": "MRU_HIGH_PASS",
    "mru.bias_drift": "MRU_DRIFT",
    "depth.scale": "DEPTH_SCALE_ERROR",
    "encoder.scale": "ENCODER_SCALE_ERROR",
    "cable.inertia_factor": "CABLE_INERTIA",
    "cable.damping_factor": "CABLE_DAMPING",
}
"""Alarm of a quantity that differs from nominal."""

ENDS = {"excluded": "EXCLUDED", "recovered": "RECOVERED", "refused": "NOT_DESIGNABLE", "nominal": "NOMINAL"}
"""End of the alarm code of any other finding, after the part that it is about."""


def alarms_of(findings: Sequence[Finding]) -> list[Alarm]:
    """Return the `findings` as alarms; all that is new of the winch is one, and so is that of the sea."""
    models: dict[str, list[str]] = {"winch": [], "sea": []}
    found = []
    for one in findings:
        if one.quantity in WINCH_LABELS:
            models["winch"].append(_change(WINCH_LABELS[one.quantity], one, 3))
        elif one.quantity in SEA_LABELS:
            models["sea"].append(_change(SEA_LABELS[one.quantity], one, 1))
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
    return f"{label} {value} (was {finding.nominal:.{digits}f})"


def _alarm(finding: Finding) -> Alarm:
    if finding.code in ENDS:
        owner = finding.quantity.partition(".")[0]
        return ALARMS.alarm(f"{owner.upper()}_{ENDS[finding.code]}")
    row = ALARMS[CODES[finding.quantity]]
    nominal = finding.nominal if math.isfinite(finding.nominal) else 0.0
    values = {"value": finding.value, "nominal": nominal}
    return row.alarm(**{name: values[name] for name in row.names})
