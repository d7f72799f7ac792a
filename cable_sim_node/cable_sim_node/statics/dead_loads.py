"""A cable under dead loads: the search for its three unknowns that cannot fail, in numba.

Under dead loads the end position is the gradient of the complementary energy by the tension vector at s = 0, a convex
function. Newton with a line search on that energy therefore reaches the only answer from any start, slack or taut. The
search looks at the energy's slope along the step, which grows steadily and is not lost in rounding as the energy is.
"""

from __future__ import annotations

import math

import numpy as np
from heave_node.arrays import Array
from numba import njit
from numpy.typing import NDArray

from cable_sim_node.statics.march import march, solve3
from cable_sim_node.statics.system import Current, StaticCable

RELATIVE_TOLERANCE = 1e-11
"""Miss of the end position, over the cable's length and its span, at which the search ends."""

ACCEPTABLE = 1e-8
"""Miss that is taken for an answer when rounding leaves no better one."""

NEWTON_LIMIT = 100
LINE_SEARCH_LIMIT = 60

COMPLIANCE_FLOOR = 1e-13
"""Share of the compliance's trace added to its diagonal: a straight weightless cable has none along itself but EA's."""


@njit(cache=True, error_model="numpy")
def _gradient(end: Array, origin: Array, span: Array, known: NDArray[np.bool_], gradient: Array) -> float:
    """Fill by how much the end misses its place on the axes whose force is not known; return the largest."""
    largest = 0.0
    for i in range(3):
        gradient[i] = 0.0 if known[i] else end[i] - origin[i] - span[i]
        largest = max(largest, abs(gradient[i]))
    return largest


@njit(cache=True, error_model="numpy")
def _newton_step(partials: Array, known: NDArray[np.bool_], gradient: Array, compliance: Array, step: Array) -> bool:
    """Fill the Newton step of the unknown components, with a floor under the compliance."""
    trace = 0.0
    for i in range(3):
        if not known[i]:
            trace += partials[i, 3 + i]
    for i in range(3):
        for j in range(3):
            compliance[i, j] = 0.0 if known[i] or known[j] else -partials[i, 3 + j]
        compliance[i, i] = 1.0 if known[i] else compliance[i, i] - COMPLIANCE_FLOOR * trace
    return solve3(compliance, gradient, step)


@njit(cache=True, error_model="numpy")
def _search(
    origin: Array,
    span: Array,
    known: NDArray[np.bool_],
    start: Array,
    segments: Array,
    nodes: Array,
    depths: Array,
    velocities: Array,
    factor: float,
    drag: Array,
) -> bool:
    """Improve the unknown components of `start` until the end is in its place; return whether it came there."""
    count = len(segments)
    positions, lower, upper = np.empty((count + 1, 3)), np.empty((count, 3)), np.empty((count, 3))
    end, partials = np.empty(3), np.empty((6, 6))
    gradient, right, step, trial = np.zeros(3), np.zeros(3), np.zeros(3), np.empty(3)
    compliance = np.empty((3, 3))
    scale = np.sum(segments[:, 0]) + math.sqrt(span[0] ** 2 + span[1] ** 2 + span[2] ** 2)
    best = np.inf
    energy = march(
        origin, start, segments, nodes, depths, velocities, factor, 0.0, True, drag, positions, lower, upper, end,
        partials,
    )  # fmt: skip
    for _ in range(NEWTON_LIMIT):
        if not math.isfinite(energy):
            return False
        miss = _gradient(positions[count], origin, span, known, gradient) / scale
        if miss < RELATIVE_TOLERANCE or (miss < ACCEPTABLE and miss >= best):
            return True
        best = min(best, miss)
        if not _newton_step(partials, known, gradient, compliance, step):
            return False
        slope = gradient[0] * step[0] + gradient[1] * step[1] + gradient[2] * step[2]
        low, high, share = 0.0, 1.0, 1.0
        for _ in range(LINE_SEARCH_LIMIT):
            for i in range(3):
                trial[i] = start[i] + share * step[i]
            energy = march(
                origin, trial, segments, nodes, depths, velocities, factor, 0.0, True, drag, positions, lower, upper,
                end, partials,
            )  # fmt: skip
            _gradient(positions[count], origin, span, known, right)
            here = right[0] * step[0] + right[1] * step[1] + right[2] * step[2]
            if not math.isfinite(here):
                return False
            if here <= 0.5 * abs(slope) and (share == 1.0 or here >= -0.5 * abs(slope)):
                break
            if here > 0.0:
                high = share
            else:
                low = share
            share = 0.5 * (low + high)
        start[:] = trial
    return False


def solve_dead_loads(
    cable: StaticCable,
    current: Current,
    origin: Array,
    span: Array,
    known: NDArray[np.bool_],
    guess: Array,
    drag: Array,
    *,
    factor: float = 0.0,
) -> Array | None:
    """Return the tension vector below node 0 under dead loads, or None if the search does not end.

    Parameters
    ----------
    origin : position of node 0 [m]
    span : wanted position of the other end relative to it [m]; only axes that are not `known` count
    known : which components of the tension vector are given (`guess` has them)
    guess : start of the search [N]
    drag : dead loads on the segments beside weight, shape (n, 3) [N/m]
    factor : of the current that drags on bodies at the nodes
    """
    start = guess.copy()
    found = _search(
        origin, np.where(known, 0.0, span), known, start, cable.segments, cable.nodes, current.depths,
        current.velocities, factor, drag,
    )  # fmt: skip
    return start if found else None
