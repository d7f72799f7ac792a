"""Bending stiffness of the line: a hinge spring at each inner node (Pinto; thesis appendix 12.4.6), and its solver.

Energy of the hinge at node i between segments of lengths l and m: (1/2) B |e_i - e_{i-1}|^2 with B = EI / ((l + m)/2),
e the directions of the segments (`forces.direction`); |e_i - e_{i-1}| / ((l + m)/2) is the curvature.
Arguments as in `line.assembly`; the middle state is bent.
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel

from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.forces.direction import direction_of
from cable_sim_node.physics.drag import Vector


@inner_kernel
def chord_per_length(tile: Array, j: int) -> Vector:
    """Return the chord of segment `j` of `tile` over its unstretched length."""
    per_length = tile[at.PER_LENGTH + j]
    return (
        (tile[at.MIDDLE + at.X + j + 1] - tile[at.MIDDLE + at.X + j]) * per_length,
        (tile[at.MIDDLE + at.Y + j + 1] - tile[at.MIDDLE + at.Y + j]) * per_length,
        (tile[at.MIDDLE + at.Z + j + 1] - tile[at.MIDDLE + at.Z + j]) * per_length,
    )


@inner_kernel
def add_bending(line: LineArrays, n: int) -> None:
    """Add the hinges' forces to the residual and write their stiffness into `band`.

    Entry (i, j) of the stiffness is in row i, column 8 + j - i; `band` is cleared first, and its last three rows are
    scratch. The stiffness is the part that keeps the segments' directions: B G' G with G the derivative of e_i -
    e_{i-1}. It is positive semidefinite; what is left out is of the order of the bending force itself.
    """
    tiles, band = line.tiles, line.band
    band[:] = 0.0
    hinge = band.shape[0] - 3
    for i in range(1, n):
        below, a = tiles[(i - 1) >> at.SHIFT], (i - 1) & at.LANES
        above, b = tiles[i >> at.SHIFT], i & at.LANES
        wa, wb = chord_per_length(below, a), chord_per_length(above, b)
        fa, ta = direction_of(math.sqrt(wa[0] ** 2 + wa[1] ** 2 + wa[2] ** 2))
        fb, tb = direction_of(math.sqrt(wb[0] ** 2 + wb[1] ** 2 + wb[2] ** 2))
        per_a, per_b = below[at.PER_LENGTH + a], above[at.PER_LENGTH + b]
        span = 0.5 * (1.0 / per_a + 1.0 / per_b)
        stiffness = 0.5 * (below[at.BENDING + a] + above[at.BENDING + b]) / span
        for p in range(3):
            for q in range(3):
                one = 1.0 if p == q else 0.0
                pa = (fa * one + ta * wa[p] * wa[q]) * per_a
                pb = (fb * one + tb * wb[p] * wb[q]) * per_b
                band[hinge + p, q] = pa
                band[hinge + p, 3 + q] = -pa - pb
                band[hinge + p, 6 + q] = pb
        base = 3 * (i - 1)
        for r in range(9):
            force = 0.0
            for p in range(3):
                force += band[hinge + p, r] * (fb * wb[p] - fa * wa[p])
            node = i - 1 + r // 3
            tiles[node >> at.SHIFT, at.RX + r % 3 * at.STRIDE + (node & at.LANES)] += stiffness * force
            for c in range(9):
                total = 0.0
                for p in range(3):
                    total += band[hinge + p, r] * band[hinge + p, c]
                band[base + r, at.CENTRE + c - r] += stiffness * total


@inner_kernel
def _entry(p: int, q: int) -> int:
    """Return by how much the column of element (p, q) of a symmetric block lies beyond that of its first."""
    low, high = min(p, q), max(p, q)
    return at.STRIDE * (high if low == 0 else low + high + 1)


@inner_kernel
def solve_with_bending(line: LineArrays, count: int) -> float:
    """Solve (blocks + band) correction = -residual for nodes 0..count-1 by banded elimination.

    Blocks and residuals are those of `line`. The system is definite, so nothing is pivoted. Returns what
    `solve_blocks` does.
    """
    tiles, band = line.tiles, line.band
    size, decrease = 3 * count, 0.0
    for i in range(count):
        tile, j = tiles[i >> at.SHIFT], i & at.LANES
        for p in range(3):
            row = 3 * i + p
            band[row, at.RIGHT] = -tile[at.RX + p * at.STRIDE + j]
            for q in range(3):
                band[row, at.CENTRE + q - p] += tile[at.DXX + _entry(p, q) + j]
                if i + 1 < count:
                    band[row, at.CENTRE + 3 + q - p] += tile[at.UXX + _entry(p, q) + j]
                    band[row + 3, at.CENTRE - 3 + q - p] += tile[at.UXX + _entry(p, q) + j]
    for row in range(size):
        pivot = 1.0 / band[row, at.CENTRE]
        decrease += band[row, at.RIGHT] * band[row, at.RIGHT] * pivot
        end = min(row + at.CENTRE + 1, size)
        for below in range(row + 1, end):
            factor = band[below, at.CENTRE + row - below] * pivot
            if factor == 0.0:
                continue
            for column in range(row + 1, end):
                band[below, at.CENTRE + column - below] -= factor * band[row, at.CENTRE + column - row]
            band[below, at.RIGHT] -= factor * band[row, at.RIGHT]
    for row in range(size - 1, -1, -1):
        value = band[row, at.RIGHT]
        for column in range(row + 1, min(row + at.CENTRE + 1, size)):
            value -= band[row, at.CENTRE + column - row] * band[column, at.RIGHT]
        band[row, at.RIGHT] = value / band[row, at.CENTRE]
        node = row // 3
        tiles[node >> at.SHIFT, at.CX + row % 3 * at.STRIDE + (node & at.LANES)] = band[row, at.RIGHT]
    return decrease
