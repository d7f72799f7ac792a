"""A pass of one linear filter over a record in many columns, see `src/pass.cpp`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from heave_core.filter_table import STATES
from heave_core.library import dtype_of, library
from heave_core.pass_table import PASS

Array = NDArray[np.float64]

Motion = tuple[Array, Array, Array, Array, int]
"""F (n, n), B (n,), Q (n, n) of a tick, pull of the cable on the unit as a row on the state (n,), and index of the
unit's heave rate."""


def follow(
    motion: Motion,
    ticks: Array,
    commands: Array,
    readings: Array,
    rows: Array,
    values: Array,
    state: Array,
    covariance: Array,
) -> tuple[Array, Array]:
    """Go through a record; `state` (n, c) and `covariance` (n, n) are changed in place.

    Parameters
    ----------
    motion : of the state
    ticks, readings : by the rows of PASS_TICK (t, 4) and PASS_READING (m, 4) in `pass_table`
    commands : in effect at each tick, (t, c)
    rows : of the measurements on the state of a tick, and their first and second differences over ticks (3, k, n)
    values : of the readings (m, c)

    Returns the innovations over the standard deviation that was predicted (m, c), and its square (m,). Raises
    ValueError for a model that does not fit.
    """
    n, c = state.shape
    if n > STATES:
        raise ValueError(f"pass: {n} states, and at most {STATES} fit")
    F, B, Q, pull, rate = motion
    model = np.zeros(1, dtype_of(PASS))
    one = model[0]
    one["states"], one["measurements"], one["columns"] = n, rows.shape[1], c
    one["ticks"], one["rate"] = len(ticks), rate
    one["F"][: n * n], one["B"][:n], one["Q"][: n * n], one["pull"][:n] = F.ravel(), B, Q.ravel(), pull
    given = [np.ascontiguousarray(array, dtype=float) for array in (ticks, commands, readings, rows, values)]
    made = [np.empty(n * c + 2 * n * n), np.empty((len(values), c)), np.empty(len(values))]
    arrays = (model, *given, state, covariance, *made)
    library().heave_core_pass(*(array.ctypes.data for array in arrays))
    return made[1], made[2]
