"""When the cable of a model is slack, see `slack_kernel`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.estimator import MeasurementModel
from winch_controller_node.model.slack_kernel import Slack


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
