"""Carrying an estimate over to a design for another sea: waves are carried by the boom-tip motion that they cause.

The states of a shaping filter mean something else in each sea, and so do those of a vessel that is fitted to RAOs. What
must go on without a step is the boom tip's motion, now and in the next seconds: all that the command depends on.
"""

from __future__ import annotations

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.linear_model import LinearModel

from winch_controller_node.design.design import ControllerDesign, carry_by_name

FORESEEN = 12.0
"""Time over which the boom tip shall move as it was predicted [s]: most of a swell's period."""

EVERY = 2
"""Ticks from one compared moment to the next."""

EXACTNESS, LOOSENING = 1e-3, 2.6
"""Largest difference of the two at first, over the standard deviation of the boom tip's heave, and the time [s] in
which it may grow by a factor of e: another sea must predict something else in the end."""


def carry_sea(old: ControllerDesign, new: ControllerDesign) -> tuple[Array, Array]:
    """Return the matrix that takes a state of `old` to one of `new`, and the covariance that this adds.

    Shapes (n_new, n_old) and (n_new, n_new). States other than those of waves and vessel are carried by name.
    """
    waves = [i for i, name in enumerate(new.model.state_names) if name.startswith("wave_")]
    seen_old, seen_new = _foreseen(old.model), _foreseen(new.model)
    matrix = carry_by_name(old, new)
    matrix[waves] = 0.0
    if new.model.has_state("vessel_heave"):
        # in metres of a vessel's heave, of which the boom tip takes a share
        vessel = [new.model.state(name) for name in ("vessel_heave", "vessel_heave_rate")]
        matrix[vessel] *= (seen_old[0] @ matrix[vessel[0]]) / seen_new[0, vessel[0]]
    time = EVERY * new.tick_period * np.arange(len(seen_new))
    sigma = (EXACTNESS * new.sigma["boom_tip_heave"] * np.exp(time / LOOSENING))[:, None]
    prior = new.initial_covariance[np.ix_(waves, waves)]
    # scaled: wave states are derivatives of one signal, of very different sizes
    size = np.sqrt(np.diag(prior))
    scaled = seen_new[:, waves] * size / sigma
    covariance = np.linalg.inv(scaled.T @ scaled + np.linalg.inv(prior / np.outer(size, size)))
    wanted = seen_old - seen_new @ matrix
    matrix[waves] = size[:, None] * (covariance @ scaled.T @ (wanted / sigma))
    added = np.zeros((new.model.order, new.model.order))
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
