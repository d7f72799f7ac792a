"""Readings in whole steps, as an instrument with so many digits gives them."""

from __future__ import annotations

import numpy as np

from heave_node.numerics.arrays import Array


def quantised(values: Array, step: Array | float) -> Array:
    """Return `values` rounded to whole multiples of a `step`, of each value or of all; as they are where it is 0."""
    steps = np.asarray(step, dtype=float)
    safe = np.where(steps > 0.0, steps, 1.0)
    return np.where(steps > 0.0, safe * np.rint(values / safe), values)
