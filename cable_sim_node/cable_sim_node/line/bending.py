"""Bending stiffness of the line: a hinge spring at each inner node (Pinto; thesis appendix 12.4.6), and its solver.

Energy of the hinge at node i between segments of lengths l and m: (1/2) B |e_i - e_{i-1}|^2 with B = EI / ((l + m)/2),
e the directions of the segments (`line.direction`); |e_i - e_{i-1}| / ((l + m)/2) is the curvature.
Arguments as in `assembly`.
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel

from cable_sim_node.line.direction import direction_of
from cable_sim_node.line.layout import (
    BENDING,
    CENTRE,
    CX,
    DXX,
    LENGTH,
    RIGHT,
    RX,
    UXX,
    X,
    Y,
    Z,
)


@inner_kernel
def add_bending(n: int, nodes: Array, parts: Array, equations: Array, band: Array) -> None:
    """Add the hinges' forces to the residual and write their stiffness into `band`.

    Entry (i, j) of the stiffness is in row i, column 8 + j - i; `band` is cleared first, and its last three rows are
    scratch. The stiffness is the part that keeps the segments' directions: B G' G with G the derivative of e_i -
    e_{i-1}. It is positive semidefinite; what is left out is of the order of the bending force itself.
    """
    band[:] = 0.0
    hinge = band.shape[0] - 3
    for i in range(1, n):
        low, node, high = nodes[i - 1], nodes[i], nodes[i + 1]
        ax, ay, az = node[X] - low[X], node[Y] - low[Y], node[Z] - low[Z]
        bx, by, bz = high[X] - node[X], high[Y] - node[Y], high[Z] - node[Z]
        la, lb = parts[i - 1, LENGTH], parts[i, LENGTH]
        wa, wb = (ax / la, ay / la, az / la), (bx / lb, by / lb, bz / lb)
        fa, ta = direction_of(math.sqrt(wa[0] ** 2 + wa[1] ** 2 + wa[2] ** 2))
        fb, tb = direction_of(math.sqrt(wb[0] ** 2 + wb[1] ** 2 + wb[2] ** 2))
        span = 0.5 * (la + lb)
        stiffness = 0.5 * (parts[i - 1, BENDING] + parts[i, BENDING]) / span
        for p in range(3):
            for q in range(3):
                one = 1.0 if p == q else 0.0
                pa = (fa * one + ta * wa[p] * wa[q]) / la
                pb = (fb * one + tb * wb[p] * wb[q]) / lb
                band[hinge + p, q] = pa
                band[hinge + p, 3 + q] = -pa - pb
                band[hinge + p, 6 + q] = pb
        base = 3 * (i - 1)
        for r in range(9):
            force = 0.0
            for p in range(3):
                force += band[hinge + p, r] * (fb * wb[p] - fa * wa[p])
            equations[i - 1 + r // 3, RX + r % 3] += stiffness * force
            for c in range(9):
                total = 0.0
                for p in range(3):
                    total += band[hinge + p, r] * band[hinge + p, c]
                band[base + r, CENTRE + c - r] += stiffness * total


@inner_kernel
def _entry(p: int, q: int) -> int:
    """Return the column where a symmetric block stores its element (p, q)."""
    low, high = min(p, q), max(p, q)
    return high if low == 0 else low + high + 1


@inner_kernel
def solve_with_bending(count: int, equations: Array, band: Array) -> float:
    """Solve (blocks + band) correction = -residual for nodes 0..count-1 by banded elimination.

    Blocks and residuals are those of `equations`. The system is definite, so nothing is pivoted. Returns what
    `solve_blocks` does.
    """
    size, decrease = 3 * count, 0.0
    for i in range(count):
        for p in range(3):
            row = 3 * i + p
            band[row, RIGHT] = -equations[i, RX + p]
            for q in range(3):
                band[row, CENTRE + q - p] += equations[i, DXX + _entry(p, q)]
                if i + 1 < count:
                    band[row, CENTRE + 3 + q - p] += equations[i, UXX + _entry(p, q)]
                    band[row + 3, CENTRE - 3 + q - p] += equations[i, UXX + _entry(p, q)]
    for row in range(size):
        pivot = 1.0 / band[row, CENTRE]
        decrease += band[row, RIGHT] * band[row, RIGHT] * pivot
        end = min(row + CENTRE + 1, size)
        for below in range(row + 1, end):
            factor = band[below, CENTRE + row - below] * pivot
            if factor == 0.0:
                continue
            for column in range(row + 1, end):
                band[below, CENTRE + column - below] -= factor * band[row, CENTRE + column - row]
            band[below, RIGHT] -= factor * band[row, RIGHT]
    for row in range(size - 1, -1, -1):
        value = band[row, RIGHT]
        for column in range(row + 1, min(row + CENTRE + 1, size)):
            value -= band[row, CENTRE + column - row] * band[column, RIGHT]
        band[row, RIGHT] = value / band[row, CENTRE]
        equations[row // 3, CX + row % 3] = band[row, RIGHT]
    return decrease
