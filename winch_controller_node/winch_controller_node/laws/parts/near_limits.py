"""Whether the winch comes near to its limits in following the boom tip, or in holding a unit that is far off."""

from __future__ import annotations

import math
from typing import Any

from heave_node.numerics.linear_model import LinearModel

BEGINS, ENDS = 0.8, 0.4
"""Share of a limit from which on it is near, and below which it is no longer: a sea at the limits comes in groups."""

MEMORY = 30.0
"""Time constant with which a wave, or a swing of the unit, decays [s]: a few groups."""


def near_limits(model: LinearModel) -> dict[str, Any]:
    """Return what a law of the core needs to tell it: fields of `Law`.

    It compares speed and acceleration of the boom tip, and what the unit asks for, with what the winch can do. `model`
    is the augmented one, sampled.
    """
    assert model.dt is not None
    speed = model.row("boom_tip_heave_rate")
    return {
        "near_speed": speed,
        "near_acceleration": (speed @ model.A - speed) / model.dt,
        "near_kept": math.exp(-model.dt / MEMORY),
        "near_begins": BEGINS,
        "near_ends": ENDS,
    }
