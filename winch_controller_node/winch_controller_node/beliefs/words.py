"""Findings as sentences: what, value against nominal, consequence, action."""

from __future__ import annotations

import math
from collections.abc import Sequence

from heave_node.interface.codes import WINCH_LEARNT

from winch_controller_node.beliefs.beliefs import Finding
from winch_controller_node.beliefs.quantities import QUANTITIES

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

SENTENCES = {
    "mru.scale": "mru suspect: it reads {value:.2f} times the motion; corrected. Check scale and sign, and the drum "
    "radius",
    "mru.offset": "mru suspect: its heave has a mean of {value:+.2f} m; corrected. Check its reference and trim",
    "mru.delay": "mru suspect: its stamps are {value:+.2f} s late; corrected. Check its clock and latency",
    "mru.high_pass_period": "mru suspect: its heave has a high-pass of {value:.0f} s (assumed: {nominal:.0f} s, 0 is "
    "none); corrected. State sensors.mru.high_pass_period",
    "mru.bias_drift": "mru suspect: its heave wanders, as in a turn; tracked. Check its aiding and the ship's turns",
    "depth.scale": "depth suspect: it reads {value:.2f} times the motion; corrected. Check its scale and unit",
    "encoder.scale": "encoder suspect: it reads {value:.2f} times the payout; corrected. Check its scale and sign, and "
    "the drum radius",
    "cable.inertia_factor": "cable suspect: inertia {value:.2f} times the assumed one; corrected. Check mass of the "
    "unit, length and stiffness of the cable",
    "cable.damping_factor": "cable suspect: damping {value:.2g} times the assumed one; corrected. Check drag of the "
    "unit",
}
"""Of a quantity that differs from nominal."""


def sentences(findings: Sequence[Finding]) -> list[str]:
    """Return the `findings` as sentences; those of the winch, and of the sea, are one each."""
    told = [_sentence(one) for one in findings if not one.quantity.startswith(("winch.", "sea."))]
    winch = [_change(WINCH_LABELS[one.quantity], one, 3) for one in findings if one.quantity in WINCH_LABELS]
    sea = [_change(SEA_LABELS[one.quantity], one, 1) for one in findings if one.quantity in SEA_LABELS]
    told += [f"{WINCH_LEARNT}{', '.join(winch)}"] if winch else []
    return told + ([f"sea model updated: {', '.join(sea)}"] if sea else [])


def _change(label: str, finding: Finding, digits: int) -> str:
    if finding.unit == "W":
        value, before = (
            f"{power / 1e3:.1f} kW" if power > 0.0 else "none" for power in (finding.value, finding.nominal)
        )
        return f"{label} {value} (was {before})"
    value = f"{finding.value:.{digits}f} {finding.unit}".rstrip()
    return f"{label} {value} (was {finding.nominal:.{digits}f})"


def _sentence(finding: Finding) -> str:
    if finding.code == "excluded":
        return (
            f"{finding.quantity} suspect: its readings contradict all others; not used. Check sign, scale and mounting"
        )
    if finding.code == "recovered":
        return f"{finding.quantity} agrees with all others again; used"
    if finding.code == "refused":
        return (
            f"{finding.quantity} differs from what is assumed; what was found is not used: no controller can be "
            "designed for it. Check its parameters"
        )
    owner = QUANTITIES[finding.quantity].owner
    if finding.code == "nominal":
        return f"{owner} as assumed again"
    nominal = finding.nominal if math.isfinite(finding.nominal) else 0.0
    return SENTENCES[finding.quantity].format(value=finding.value, nominal=nominal)
