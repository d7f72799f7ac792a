"""What is not linear of a hanging unit: quadratic drag, and a cable that is slack.

Gains are designed for a unit that hardly moves. One that no winch holds may move by metres, and near the resonance its
motion is then ruled by a drag several times that of the design; and its cable cannot push it. How it moves is in C++
(`heave_core`, unit.cpp).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from heave_core.filter import Drag, Slack
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.estimator import MeasurementModel
from winch_controller_node.model.models import shadow_model


def unit_drag(model: LinearModel, cable: CableModel, rate: str = "unit_heave_rate") -> Drag:
    """Return the drag of the unit in a sampled `model`, whose damping is b of the `cable`; `rate` is the unit's."""
    return Drag(model.state(rate), cable.a, cable.b, cable.drag, model.dt or 0.0)


def cable_slack(model: LinearModel, cable: CableModel, measurements: Sequence[MeasurementModel]) -> Slack:
    """Return when the `cable` is slack in a sampled `model` with `measurements`."""
    payout = model.state("payout")
    return Slack(
        pull=model.row("tension") / cable.stiffness,
        # of what is measured, tension and acceleration alone go down with payout
        reads=np.array([max(-float(known.row[payout]), 0.0) for known in measurements]),
        rate=model.state("unit_heave_rate"),
        inertia=cable.a,
        largest=cable.unit_weight / cable.stiffness,
        tick_period=model.dt or 0.0,
    )


def hanging_cable(cable: CableModel, tick_period: float) -> dict[str, Any]:
    """Return the values of the core's HangingCable, of a `cable` in ticks of `tick_period` [s]."""
    model = shadow_model(cable, tick_period)
    return {
        "A": model.A,
        "B": model.B,
        "drag": unit_drag(model, cable, "mode_heave_rate")._asdict(),
        "tick_period": tick_period,
        "participation": cable.participation,
        "natural_inertia": cable.natural_a,
        "largest_push": cable.unit_weight / cable.stiffness,
        # of a uniform cable a third moves with the unit, and a sixth is what makes the participation more than 1
        "cable_share": 2.0 * (cable.participation - 1.0),
    }
