"""A cable under dead loads: the search for its three unknowns that cannot fail, in numba.

Under dead loads the end position is the gradient of the complementary energy by the tension vector at s = 0, a convex
function. Newton with a line search on that energy therefore reaches the only answer from any start, slack or taut. The
search looks at the energy's slope along the step, which grows steadily and is not lost in rounding as the energy is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from cable_sim_node.physics.current import Current
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel, kernel
from numpy.typing import NDArray

from heave_statics.march import march, solve3
from heave_statics.system import StaticCable
from heave_statics.tables import LENGTH, CableTables, ShapeTables, allocate_shape

RELATIVE_TOLERANCE = 1e-11
"""Miss of the end position, over the cable's length and its span, at which the search ends."""

ACCEPTABLE = 1e-8
"""Miss that is taken for an answer when rounding leaves no better one."""

NEWTON_LIMIT = 100
LINE_SEARCH_LIMIT = 60

COMPLIANCE_FLOOR = 1e-13
"""Share of the compliance's trace added to its diagonal: a straight weightless cable has none along itself but EA's."""


@inner_kernel
def _gradient(end: Array, origin: Array, span: Array, known: NDArray[np.bool_], gradient: Array) -> float:
    """Fill by how much the end misses its place on the axes whose force is not known; return the largest."""
    largest = 0.0
    for i in range(3):
        gradient[i] = 0.0 if known[i] else end[i] - origin[i] - span[i]
        largest = max(largest, abs(gradient[i]))
    return largest


@inner_kernel
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


@inner_kernel
def _along(gradient: Array, step: Array) -> float:
    return gradient[0] * step[0] + gradient[1] * step[1] + gradient[2] * step[2]


@kernel
def _search(
    cable: CableTables, origin: Array, span: Array, known: NDArray[np.bool_], start: Array, shape: ShapeTables
) -> bool:
    """Improve the unknown components of `start` until the end is in its place; return whether it came there.

    `shape.drag` are the dead loads; the rest of the shape is filled.
    """
    gradient, right, step, trial = np.zeros(3), np.zeros(3), np.zeros(3), np.empty(3)
    compliance = np.empty((3, 3))
    end, partials = shape.positions[len(cable.segments)], shape.partials
    scale = np.sum(cable.segments[:, LENGTH]) + math.sqrt(span[0] ** 2 + span[1] ** 2 + span[2] ** 2)
    best = np.inf
    energy = march(cable, origin, start, shape)
    for _ in range(NEWTON_LIMIT):
        if not math.isfinite(energy):
            return False
        miss = _gradient(end, origin, span, known, gradient) / scale
        if miss < RELATIVE_TOLERANCE or (miss < ACCEPTABLE and miss >= best):
            return True
        best = min(best, miss)
        if not _newton_step(partials, known, gradient, compliance, step):
            return False
        slope = _along(gradient, step)
        low, high, share = 0.0, 1.0, 1.0
        for _ in range(LINE_SEARCH_LIMIT):
            for i in range(3):
                trial[i] = start[i] + share * step[i]
            energy = march(cable, origin, trial, shape)
            _gradient(end, origin, span, known, right)
            here = _along(right, step)
            if not math.isfinite(here):
                return False
            if here <= 0.5 * abs(slope) and (share == 1.0 or here >= -0.5 * abs(slope)):
                break
            if here > 0.0:
                high = share
            else:
                low = share
            share = 0.5 * (low + high)
        for i in range(3):
            start[i] = trial[i]
    return False


@dataclass(frozen=True)
class EndCondition:
    """What is asked of the other end of the cable, or of the tension at this one."""

    origin: Array  # position of node 0 [m]
    span: Array  # wanted position of the other end relative to it [m]; only axes that are not `known` count
    # which components of the tension vector at node 0 are given; none of them if left out
    known: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(3, dtype=np.bool_))


def solve_dead_loads(
    cable: StaticCable, current: Current, ends: EndCondition, guess: Array, drag: Array, *, factor: float = 0.0
) -> Array | None:
    """Return the tension vector below node 0 under dead loads, or None if the search does not end.

    Parameters
    ----------
    cable : what hangs; it does not run along itself here
    current : what drags on bodies at the nodes
    ends : where both ends are
    guess : start of the search, with the components that are known [N]
    drag : dead loads on the segments beside weight, shape (n, 3) [N/m]
    factor : of the current
    """
    start = guess.copy()
    shape = allocate_shape(len(cable.segments))
    shape.drag[:] = drag
    tables = CableTables(cable.segments, cable.nodes, current.profile, factor, feed=0.0, frozen=True)
    found = _search(tables, ends.origin, np.where(ends.known, 0.0, ends.span), ends.known, start, shape)
    return start if found else None
