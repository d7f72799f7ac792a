"""Where the boom tip will be, as the sea model foresees it, when a command takes effect."""

from __future__ import annotations

import math

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel


def tip_ahead(model: LinearModel, time: float) -> tuple[Array, Array, Array]:
    """Return rows of the boom tip of a `model`, a `time` [s] from now: heave, rate, acceleration; linear in a tick."""
    assert model.dt is not None
    whole = math.floor(time / model.dt)
    share = time / model.dt - whole
    soon = np.linalg.matrix_power(model.A, whole)
    later = soon @ model.A
    ahead = (1.0 - share) * soon + share * later
    rate = model.row("boom_tip_heave_rate")
    return model.row("boom_tip_heave") @ ahead, rate @ ahead, rate @ (later - soon) / model.dt
