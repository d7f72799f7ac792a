"""Cable that enters and leaves at the sheave: the top segment, and the birth and death of nodes below it.

The grid of material points is counted from the unit and never moves; node i < n sits on grid point i for good. Only the
top segment, from grid point n - 1 to the length L, changes. It is divided and merged with the mass of the line, its
stretch and (when it is divided) its momentum kept, and a new node is put where its own forces give it the acceleration
of its surroundings, so that tension does not jump. Arguments as in `assembly`; `line` is the `LineArrays`, `now`
and `grid` are two of them.
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel, kernel

from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.assembly import assemble_nodes, assemble_segments
from cable_sim_node.line.flow import set_flow
from cable_sim_node.line.layout import (
    ACCELERATION,
    AX,
    BENDING,
    DXX,
    DXY,
    DXZ,
    DYY,
    DYZ,
    DZZ,
    HOLD_X,
    LENGTH,
    LUMP_MASS,
    LUMP_WEIGHT,
    MASS,
    MERGE_AT,
    NODE_COLUMNS,
    NOW,
    PART_COLUMNS,
    RATE,
    RX,
    RY,
    RZ,
    SPLIT_AT,
    START,
    STIFFNESS,
    TENSION,
    TIME,
    TOTAL,
    VX,
    WEIGHT,
    X,
    Y,
    Z,
)


@kernel
def set_top_segment(n: int, total: float, grid: Array, parts: Array) -> None:
    """Set row n - 1 of `parts` for the cable from grid point n - 1 to the length `total` [m], and the lump of row n.

    Where it spans several grid segments (other sections), what is per metre is averaged by length and the compliance is
    added. A lump on the way bears on both ends by the law of the lever, as do mass and weight of the parts: that is
    what the node will take over.
    """
    start = grid[n - 1, START]
    length = total - start
    row, sheave = parts[n - 1], parts[n]
    for c in range(PART_COLUMNS):
        row[c] = grid[n - 1, c]
    for c in range(LUMP_MASS, PART_COLUMNS):
        sheave[c] = 0.0
    row[LENGTH] = length
    if grid[n, START] >= total:
        return
    compliance = leaning_mass = leaning_weight = 0.0
    for c in range(MASS, BENDING):  # mass to displaced mass, per metre
        row[c] = 0.0
    j = n - 1
    while grid[j, START] < total:
        low, high = grid[j, START], min(grid[j + 1, START], total)
        part = (high - low) / length
        compliance += part / grid[j, STIFFNESS]
        # the lower end takes half of the mean of all parts; what a part adds to its nearer end goes into the lumps
        lean = 0.5 - (0.5 * (low + high) - start) / length
        leaning_mass += lean * part * length * grid[j, MASS]
        leaning_weight += lean * part * length * grid[j, WEIGHT]
        for c in range(MASS, BENDING):
            row[c] += part * grid[j, c]
        if j >= n:
            upper_share = (low - start) / length
            for c in range(LUMP_MASS, PART_COLUMNS):
                sheave[c] += upper_share * grid[j, c]
                row[c] += (1.0 - upper_share) * grid[j, c]
        j += 1
    row[STIFFNESS] = 1.0 / compliance
    row[LUMP_MASS] += leaning_mass
    sheave[LUMP_MASS] -= leaning_mass
    row[LUMP_WEIGHT] += leaning_weight
    sheave[LUMP_WEIGHT] -= leaning_weight


@inner_kernel
def merge_top(n: int, now: Array, grid: Array, parts: Array) -> int:
    """Remove the node below the sheave; return the new number of segments."""
    for c in range(PART_COLUMNS):
        parts[n - 1, c] = grid[n - 1, c]
    for c in range(NODE_COLUMNS):
        now[n - 1, c] = now[n, c]
    return n - 1


@inner_kernel
def split_top(n: int, now: Array, top: Array, grid: Array, parts: Array) -> int:
    """Put a node on grid point n, on the straight line between its neighbours; return the new number of segments.

    `top` is the row NOW. Velocity and acceleration are those of the material there, linear along the segment.
    """
    length = top[TOTAL] - grid[n - 1, START]
    share = (grid[n, START] - grid[n - 1, START]) / length
    low, born, sheave = now[n - 1], now[n], now[n + 1]
    for c in range(NODE_COLUMNS):
        sheave[c] = born[c]
    for k in range(3):
        q = (sheave[X + k] - low[X + k]) / length
        velocity = sheave[VX + k] - top[RATE] * q
        turning = (velocity - low[VX + k]) / length
        acceleration = sheave[AX + k] - top[ACCELERATION] * q - 2.0 * top[RATE] * turning
        born[X + k] = low[X + k] + share * (sheave[X + k] - low[X + k])
        born[VX + k] = low[VX + k] + share * (velocity - low[VX + k])
        born[AX + k] = low[AX + k] + share * (acceleration - low[AX + k])
        born[HOLD_X + k] = born[X + k]
    for c in range(PART_COLUMNS):
        parts[n - 1, c] = grid[n - 1, c]
    return n + 1


@inner_kernel
def settle_node(line: LineArrays, k: int, n: int) -> None:
    """Move the newborn node `k` of n segments to where its forces give it the acceleration it has.

    A node between slack segments stays.
    """
    node, d = line.now[k], line.equations[k]
    for _ in range(6):
        assemble_segments(n, line.now, line.top[NOW], line.parts, line.flow, line.settings, 0.0, 0.0, line.equations)
        if line.equations[k - 1, TENSION] <= 0.0 or d[TENSION] <= 0.0:
            return
        assemble_nodes(n, line.now, line.parts, line.unit, line.flow, line.settings, 0.0, 0.0, line.equations)
        c0 = d[DYY] * d[DZZ] - d[DYZ] * d[DYZ]
        c1 = d[DXZ] * d[DYZ] - d[DXY] * d[DZZ]
        c2 = d[DXY] * d[DYZ] - d[DXZ] * d[DYY]
        c4 = d[DXY] * d[DXZ] - d[DXX] * d[DYZ]
        scale = -1.0 / (d[DXX] * c0 + d[DXY] * c1 + d[DXZ] * c2)
        r0, r1, r2 = d[RX], d[RY], d[RZ]
        s0 = scale * (c0 * r0 + c1 * r1 + c2 * r2)
        s1 = scale * (c1 * r0 + (d[DXX] * d[DZZ] - d[DXZ] * d[DXZ]) * r1 + c4 * r2)
        s2 = scale * (c2 * r0 + c4 * r1 + (d[DXX] * d[DYY] - d[DXY] * d[DXY]) * r2)
        size = math.sqrt(s0 * s0 + s1 * s1 + s2 * s2)
        # a step of more than a tenth of a segment means that there is no such position: the node stays where it is
        if not size < 0.1 * min(line.parts[k - 1, LENGTH], line.parts[k, LENGTH]):
            return
        node[X] += s0
        node[Y] += s1
        node[Z] += s2
        if size < 1e-9 * line.parts[k, LENGTH]:
            return


@inner_kernel
def feed(line: LineArrays, n: int) -> int:
    """Let nodes be born or die until the top segment is neither too long nor too short; return the number of segments.

    `n` is their number until now. The caller keeps the length above the least one and below the grid's end.
    """
    now, parts, grid, top = line.now, line.parts, line.grid, line.top[NOW]
    total = top[TOTAL]
    while n > 1 and total - grid[n - 1, START] < MERGE_AT * (grid[n, START] - grid[n - 1, START]):
        n = merge_top(n, now, grid, parts)
        set_top_segment(n, total, grid, parts)
    while total - grid[n, START] > SPLIT_AT * (grid[n + 1, START] - grid[n, START]):
        n = split_top(n, now, top, grid, parts)
        set_top_segment(n, total, grid, parts)
        set_flow(n, top[TIME], now, line.settings, line.current, line.schedule, line.flow)
        settle_node(line, n - 1, n)
    return n
