"""The classical Runge-Kutta step (fourth order) on state vectors, allocation-free."""

from __future__ import annotations

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel

STAGES = 5
"""Rows of the work array: four slopes, and the state at which the next one is taken."""


@inner_kernel
def shift(at: Array, state: Array, slope: Array, h: float) -> None:
    """Set `at` to state + h slope."""
    for i in range(state.size):
        at[i] = state[i] + h * slope[i]


@inner_kernel
def add_slopes(state: Array, work: Array, h: float) -> None:
    """Advance the state by `h` with the four slopes in `work`."""
    for i in range(state.size):
        state[i] += h / 6.0 * (work[0, i] + 2.0 * work[1, i] + 2.0 * work[2, i] + work[3, i])
