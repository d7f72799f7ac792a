"""Cable that enters and leaves at the sheave: the top segment's length and make-up, and the birth and death of nodes
there.

The grid of material points `grid_s` is counted from the unit and never moves; node i < n sits on grid point i for
good. Only the top segment, from grid point n - 1 to the length L, changes. It is born and merged with the mass of the
line, its stretch and (at a birth) its momentum kept, and a new node is put where its own forces give it the
acceleration of its surroundings, so that tension does not jump.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cable_sim_node.compiled import inner_kernel, kernel
from cable_sim_node.line_arrays import LineArrays
from cable_sim_node.line_assembly import assemble_nodes, assemble_segments
from cable_sim_node.line_flow import set_flow
from cable_sim_node.line_layout import (
    ACCELERATION,
    ADDED_MASS,
    DISPLACED,
    LENGTH,
    LUMP_COLUMNS,
    LUMP_MASS,
    LUMP_WEIGHT,
    MASS,
    MERGE_AT,
    NORMAL_DRAG,
    RATE,
    SEGMENT_COLUMNS,
    SPLIT_AT,
    STIFFNESS,
    TANGENTIAL_DRAG,
    TOTAL,
    WEIGHT,
)

Array = NDArray[np.float64]


@kernel
def set_top_segment(
    n: int, total: float, grid: Array, grid_s: Array, grid_lump: Array, seg: Array, lump: Array
) -> None:
    """Set row n - 1 of `seg` for the cable between grid point n - 1 and the length `total`.

    Where it spans several grid segments (other sections), what is per metre is averaged by length and the compliance
    is added. A lump on the way bears on both ends by the law of the lever, as do mass and weight of the parts:
    that is what the node will
    take over.
    """
    length = total - grid_s[n - 1]
    row = seg[n - 1]
    for c in range(SEGMENT_COLUMNS):
        row[c] = grid[n - 1, c]
    for c in range(LUMP_COLUMNS):
        lump[n - 1, c] = grid_lump[n - 1, c]
        lump[n, c] = 0.0
    row[LENGTH] = length
    if grid_s[n] >= total:
        return
    compliance = leaning_mass = leaning_weight = 0.0
    for c in (MASS, ADDED_MASS, WEIGHT, NORMAL_DRAG, TANGENTIAL_DRAG, DISPLACED):
        row[c] = 0.0
    j = n - 1
    while grid_s[j] < total:
        part = (min(grid_s[j + 1], total) - grid_s[j]) / length
        compliance += part / grid[j, STIFFNESS]
        # a part's share in the lower end is one half in the mean of all; what a heavier end takes more goes through
        # the lumps
        lean = 0.5 - (0.5 * (grid_s[j] + min(grid_s[j + 1], total)) - grid_s[n - 1]) / length
        leaning_mass += lean * part * length * grid[j, MASS]
        leaning_weight += lean * part * length * grid[j, WEIGHT]
        for c in (MASS, ADDED_MASS, WEIGHT, NORMAL_DRAG, TANGENTIAL_DRAG, DISPLACED):
            row[c] += part * grid[j, c]
        if j >= n:
            upper_share = (grid_s[j] - grid_s[n - 1]) / length
            for c in range(LUMP_COLUMNS):
                lump[n, c] += upper_share * grid_lump[j, c]
                lump[n - 1, c] += (1.0 - upper_share) * grid_lump[j, c]
        j += 1
    row[STIFFNESS] = 1.0 / compliance
    lump[n - 1, LUMP_MASS] += leaning_mass
    lump[n, LUMP_MASS] -= leaning_mass
    lump[n - 1, LUMP_WEIGHT] += leaning_weight
    lump[n, LUMP_WEIGHT] -= leaning_weight


@kernel
def restore_row(i: int, grid: Array, grid_lump: Array, seg: Array, lump: Array) -> None:
    """Give segment i and node i back the properties of the grid."""
    for c in range(SEGMENT_COLUMNS):
        seg[i, c] = grid[i, c]
    for c in range(LUMP_COLUMNS):
        lump[i, c] = grid_lump[i, c]


@inner_kernel
def merge_top(n: int, x: Array, v: Array, a: Array) -> int:
    """Remove the node below the sheave; return the new number of segments."""
    for k in range(3):
        x[n - 1, k] = x[n, k]
        v[n - 1, k] = v[n, k]
        a[n - 1, k] = a[n, k]
    return n - 1


@inner_kernel
def split_top(n: int, moving: Array, grid_s: Array, x: Array, v: Array, a: Array) -> int:
    """Put a node on grid point n, on the straight line between its neighbours; return the new number of segments.

    Velocity and acceleration are those of the material there, linear along the segment.
    """
    length = moving[TOTAL] - grid_s[n - 1]
    share = (grid_s[n] - grid_s[n - 1]) / length
    for k in range(3):
        q = (x[n, k] - x[n - 1, k]) / length
        top_velocity = v[n, k] - moving[RATE] * q
        turning = (top_velocity - v[n - 1, k]) / length
        top_acceleration = a[n, k] - moving[ACCELERATION] * q - 2.0 * moving[RATE] * turning
        x[n + 1, k], v[n + 1, k], a[n + 1, k] = x[n, k], v[n, k], a[n, k]
        x[n, k] = x[n - 1, k] + share * (x[n + 1, k] - x[n - 1, k])
        v[n, k] = v[n - 1, k] + share * (top_velocity - v[n - 1, k])
        a[n, k] = a[n - 1, k] + share * (top_acceleration - a[n - 1, k])
    return n + 1


@inner_kernel
def settle_node(line: LineArrays, k: int, n: int) -> None:
    """Move the newborn node k to where its forces give it the acceleration it has.

    A node between slack segments stays.
    """
    x, v, a, seg, residual = line.x, line.v, line.a, line.seg, line.residual
    for _ in range(6):
        assemble_segments(
            n,
            x,
            v,
            a,
            seg,
            line.flow,
            line.flow_acceleration,
            line.moving,
            line.settings,
            0.0,
            0.0,
            line.diagonal,
            line.upper,
            residual,
            line.tensions,
        )
        if line.tensions[k - 1] <= 0.0 or line.tensions[k] <= 0.0:
            return
        assemble_nodes(
            n,
            x,
            v,
            a,
            seg,
            line.lump,
            line.unit,
            line.flow,
            line.flow_acceleration,
            line.settings,
            0.0,
            0.0,
            line.diagonal,
            residual,
        )
        d = line.diagonal[k]
        c0 = d[3] * d[5] - d[4] * d[4]
        c1 = d[2] * d[4] - d[1] * d[5]
        c2 = d[1] * d[4] - d[2] * d[3]
        c4 = d[1] * d[2] - d[0] * d[4]
        scale = -1.0 / (d[0] * c0 + d[1] * c1 + d[2] * c2)
        r0, r1, r2 = residual[k, 0], residual[k, 1], residual[k, 2]
        s0 = scale * (c0 * r0 + c1 * r1 + c2 * r2)
        s1 = scale * (c1 * r0 + (d[0] * d[5] - d[2] * d[2]) * r1 + c4 * r2)
        s2 = scale * (c2 * r0 + c4 * r1 + (d[0] * d[3] - d[1] * d[1]) * r2)
        size = math.sqrt(s0 * s0 + s1 * s1 + s2 * s2)
        # a step of more than a tenth of a segment says that there is no such place: leave the straight line
        if not size < 0.1 * min(seg[k - 1, LENGTH], seg[k, LENGTH]):
            return
        x[k, 0] += s0
        x[k, 1] += s1
        x[k, 2] += s2
        if size < 1e-9 * seg[k, LENGTH]:
            return


@inner_kernel
def feed(line: LineArrays, n: int) -> int:
    """Let nodes be born or die until the top segment is neither too long nor too short; return the number of segments.

    The caller keeps the length above the least one and below the grid's end.
    """
    x, v, a, seg, lump, grid, grid_s = line.x, line.v, line.a, line.seg, line.lump, line.grid, line.grid_s
    total = line.moving[TOTAL]
    while n > 1 and total - grid_s[n - 1] < MERGE_AT * (grid_s[n] - grid_s[n - 1]):
        restore_row(n - 1, grid, line.grid_lump, seg, lump)
        n = merge_top(n, x, v, a)
        set_top_segment(n, total, grid, grid_s, line.grid_lump, seg, lump)
    while total - grid_s[n] > SPLIT_AT * (grid_s[n + 1] - grid_s[n]):
        n = split_top(n, line.moving, grid_s, x, v, a)
        restore_row(n - 2, grid, line.grid_lump, seg, lump)
        set_top_segment(n, total, grid, grid_s, line.grid_lump, seg, lump)
        set_flow(n, x, line.moving, line.settings, line.current, line.schedule, line.flow, line.flow_acceleration)
        settle_node(line, n - 1, n)
    return n
