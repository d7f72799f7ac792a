"""Carrying an estimate over to a design for another sea: waves are carried by the boom-tip motion that they cause.

The states of a shaping filter mean something else in each sea. What must go on without a step is the boom tip's motion
of the next seconds, which is all that the command depends on.
"""

from __future__ import annotations

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.design.design import ControllerDesign

FORESEEN = 12.0
"""Time over which the boom tip shall move as it was predicted [s]: most of a swell's period."""

EVERY = 2
"""Ticks from one compared moment to the next."""

EXACTNESS, LOOSENING = 1e-3, 2.6
"""Largest difference of the two at first, over the standard deviation of the boom tip's heave, and the time [s] in
which it may grow by a factor of e: another sea must predict something else in the end."""


def carry_sea(old: ControllerDesign, new: ControllerDesign) -> tuple[Array, Array]:
    """Return the matrix that takes a state of `old` to one of `new`, and the covariance that this adds, both (n, n).

    Both have the same states; only those of the waves change.
    """
    names = new.model.state_names
    waves = [i for i, name in enumerate(names) if name.startswith("wave_")]
    others = [i for i in range(len(names)) if i not in waves]
    seen_old, seen_new = _foreseen(old.model), _foreseen(new.model)
    time = EVERY * new.tick_period * np.arange(len(seen_new))
    sigma = (EXACTNESS * new.sigma["boom_tip_heave"] * np.exp(time / LOOSENING))[:, None]
    rows = seen_new[:, waves]
    prior = new.initial_covariance[np.ix_(waves, waves)]
    # scaled: wave states are derivatives of one signal, of very different sizes
    size = np.sqrt(np.diag(prior))
    scaled = rows * size / sigma
    covariance = np.linalg.inv(scaled.T @ scaled + np.linalg.inv(prior / np.outer(size, size)))
    wanted = seen_old.copy()
    wanted[:, others] -= seen_new[:, others]
    matrix = np.eye(len(names))
    matrix[waves] = size[:, None] * (covariance @ scaled.T @ (wanted / sigma))
    added = np.zeros_like(matrix)
    added[np.ix_(waves, waves)] = covariance * np.outer(size, size)
    return matrix, added


def _foreseen(model: LinearModel) -> Array:
    """Return the rows of the boom tip's heave over the next seconds, shape (moments, n)."""
    assert model.dt is not None
    row = model.row("boom_tip_heave")
    rows, ahead = [], np.linalg.matrix_power(model.A, EVERY)
    for _ in range(round(FORESEEN / model.dt / EVERY)):
        rows.append(row)
        row = row @ ahead
    return np.array(rows)
