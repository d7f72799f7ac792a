"""What a law asks of the winch over what the boom tip's own motion would ask: how much of a sea it can be given."""

from __future__ import annotations

import math
from dataclasses import dataclass

from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel, state_covariance, with_feedback

from winch_controller_node.model.regulator import is_sensor_state


@dataclass(frozen=True)
class Effort:
    """Standard deviations in the design sea over those of a drum that follows the boom tip."""

    speed: float = 1.0  # of the drum [-]
    acceleration: float = 1.0  # of the drum [-]
    rate_error: float = 0.0  # drum speed less boom-tip rate, over the latter [-]


def feedback_effort(model: LinearModel, gain: Array) -> Effort:
    """Return the effort of u = -`gain` x, shape (n,), with the state of a sampled `model` of a speed-servo loop known.

    A law that sees the unit alone acts when it has moved: later than the boom tip, and so with more speed than that.
    """
    assert model.dt is not None
    names = [name for name in model.state_names if not is_sensor_state(name)]
    keep = [model.state(name) for name in names]
    loop = with_feedback(model.select_states(names), gain[None, keep])
    tip = loop.row("boom_tip_heave_rate")
    P = state_covariance(loop)

    def sigma(row: Array) -> float:
        return math.sqrt(max(float(row @ P @ row), 0.0))

    tip_acceleration = tip @ loop.A / model.dt - tip / model.dt
    return Effort(
        speed=sigma(loop.row("payout_rate")) / sigma(tip),
        acceleration=sigma(loop.row("payout_acceleration")) / sigma(tip_acceleration),
        rate_error=sigma(loop.row("payout_rate") - tip) / sigma(tip),
    )
