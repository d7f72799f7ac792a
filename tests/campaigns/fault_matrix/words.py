"""What alarms claim of compensation, held against the modes in the second after them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from heave_bags.analyse.events import COMPENSATES
from heave_bringup.closed_loop import LoopRecord
from heave_node.interface.codes import COMPENSATION_LOST

SECOND = 1.0
"""Time over which the words must hold [s]."""

CHANGES = (COMPENSATION_LOST, "MODE_CHANGED", "TOUCHDOWN", "UNIT_SUSPENDED")
"""Alarms that announce another mode, by a reason of their own or none."""
BRAKED = ("standby", "stopped", "emergency_stop", "off")
CLAIMS: Mapping[str, tuple[str, ...]] = {
    "Compensation continues": tuple(COMPENSATES),
    "Constant tension continues": ("constant_tension",),
    "Manual operation continues": ("manual",),
    "fading out": ("fade_out", "stopping", *BRAKED),
    "fades out": ("fade_out", "stopping", *BRAKED),
    "Winch is stopping": ("stopping", *BRAKED),
    "No compensation": BRAKED,
    "Compensation does not start": BRAKED,
}
"""What an alarm may claim, and the modes in which that is true: all along if it continues, at some time else."""


def false_words(record: LoopRecord, begin: float = 0.0) -> list[str]:
    """Return the alarms from `begin` on [s] whose words were not true within a second: time, text and modes there."""
    time, modes = record.column("time"), np.array(record.modes)
    wrong = []
    for at, alarm in record.alarms:
        after = set(modes[(time >= at) & (time < at + SECOND)])
        changes = [one for when, one in record.alarms if at < when <= at + SECOND and one.code in CHANGES]
        if at < begin or (changes and all(alarm.code not in str(one.values.get("reason")) for one in changes)):
            continue  # something else has changed the mode meanwhile, and says so
        for claim, allowed in CLAIMS.items():
            holds = after <= set(allowed) if "continues" in claim else after & set(allowed)
            if claim in alarm.text and not holds:
                wrong.append(f"{at:.2f} s {alarm}: {sorted(after)}")
    return wrong
