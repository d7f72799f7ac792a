"""The linear equations of a line: symmetric block-tridiagonal, eliminated from both ends at once.

From the unit upwards S_i = D_i - U_(i-1) S_(i-1)^-1 U_(i-1), from the top downwards S_k = D_k - U_k S_(k+1)^-1 U_k,
with U_i the block between nodes i and i + 1. Both meet at a node in the middle, from where the corrections are found
outwards. The two chains of divisions do not wait for one another, which is worth a third of the time. With adj the
adjugate, U S^-1 U = U adj(S) U / det S, so that the product is formed while the division is under way.
Arguments as in `assembly`.
"""

from __future__ import annotations

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inlined_kernel, inner_kernel

from cable_sim_node.line import layout as at
from cable_sim_node.line.forces.segment import Block, adjugate, times
from cable_sim_node.physics.drag import Vector

Carried = tuple[Block, Vector]
"""Terms that an eliminated node takes from its neighbour: U S^-1 U of the block, U S^-1 r of the right side."""


@inlined_kernel
def reduced(tile: Array, j: int, carried: Carried) -> tuple[Block, Vector]:
    """Return block and right side of node `j` of `tile`, less what eliminated neighbours have `carried` over."""
    block, force = carried
    s = (
        tile[at.DXX + j] - block[0],
        tile[at.DXY + j] - block[1],
        tile[at.DXZ + j] - block[2],
        tile[at.DYY + j] - block[3],
        tile[at.DYZ + j] - block[4],
        tile[at.DZZ + j] - block[5],
    )
    return s, (-tile[at.RX + j] - force[0], -tile[at.RY + j] - force[1], -tile[at.RZ + j] - force[2])


@inlined_kernel
def upper_block(tile: Array, j: int) -> Block:
    """Return the block U between node `j` of `tile` and the one above it."""
    return tile[at.UXX + j], tile[at.UXY + j], tile[at.UXZ + j], tile[at.UYY + j], tile[at.UYZ + j], tile[at.UZZ + j]


@inlined_kernel
def eliminate(tile: Array, j: int, u: Block, carried: Carried) -> tuple[Carried, float]:
    """Eliminate node `j` of `tile`, coupled by `u` to the neighbour that remains.

    W = adj(S) U, q = adj(S) r and 1/det S are kept in the node's columns W, C and SCALE. Returns what is carried on,
    and r' S^-1 r.
    """
    s, r = reduced(tile, j, carried)
    a, determinant = adjugate(s)
    # the columns of adj(S) U, whose rows are those of U; then U adj(S) U and r' adj(S) U
    px = times(a, u[0], u[1], u[2])
    py = times(a, u[1], u[3], u[4])
    pz = times(a, u[2], u[4], u[5])
    q = times(a, r[0], r[1], r[2])
    scale = 1.0 / determinant
    tile[at.SCALE + j] = scale
    tile[at.WXX + j], tile[at.WXY + j], tile[at.WXZ + j] = px[0], py[0], pz[0]
    tile[at.WYX + j], tile[at.WYY + j], tile[at.WYZ + j] = px[1], py[1], pz[1]
    tile[at.WZX + j], tile[at.WZY + j], tile[at.WZZ + j] = px[2], py[2], pz[2]
    tile[at.CX + j], tile[at.CY + j], tile[at.CZ + j] = q[0], q[1], q[2]
    block = (
        scale * (u[0] * px[0] + u[1] * px[1] + u[2] * px[2]),
        scale * (u[0] * py[0] + u[1] * py[1] + u[2] * py[2]),
        scale * (u[0] * pz[0] + u[1] * pz[1] + u[2] * pz[2]),
        scale * (u[1] * py[0] + u[3] * py[1] + u[4] * py[2]),
        scale * (u[1] * pz[0] + u[3] * pz[1] + u[4] * pz[2]),
        scale * (u[2] * pz[0] + u[4] * pz[1] + u[5] * pz[2]),
    )
    force = (
        scale * (r[0] * px[0] + r[1] * px[1] + r[2] * px[2]),
        scale * (r[0] * py[0] + r[1] * py[1] + r[2] * py[2]),
        scale * (r[0] * pz[0] + r[1] * pz[1] + r[2] * pz[2]),
    )
    return (block, force), scale * (r[0] * q[0] + r[1] * q[1] + r[2] * q[2])


@inlined_kernel
def correct(tile: Array, j: int, c: Vector) -> Vector:
    """Set and return the correction (q - W c)/det S of node `j` of `tile`; `c` is its neighbour's to the middle."""
    scale = tile[at.SCALE + j]
    x = scale * (tile[at.CX + j] - (tile[at.WXX + j] * c[0] + tile[at.WXY + j] * c[1] + tile[at.WXZ + j] * c[2]))
    y = scale * (tile[at.CY + j] - (tile[at.WYX + j] * c[0] + tile[at.WYY + j] * c[1] + tile[at.WYZ + j] * c[2]))
    z = scale * (tile[at.CZ + j] - (tile[at.WZX + j] * c[0] + tile[at.WZY + j] * c[1] + tile[at.WZZ + j] * c[2]))
    tile[at.CX + j], tile[at.CY + j], tile[at.CZ + j] = x, y, z
    return x, y, z


@inner_kernel
def solve_blocks(tiles: Array, count: int) -> float:
    """Solve J correction = -residual for nodes 0..count-1 of a line that is held above them.

    Returns -residual . correction, from the products that the elimination makes; it is positive where J is positive
    definite.
    """
    middle, decrease = count >> 1, 0.0
    below = above = ((0.0, 0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    for i in range(middle):
        tile, j = tiles[i >> at.SHIFT], i & at.LANES
        below, part = eliminate(tile, j, upper_block(tile, j), below)
        decrease += part
        k = count - 1 - i
        if k > middle:
            next_tile = tiles[(k - 1) >> at.SHIFT]
            above, part = eliminate(
                tiles[k >> at.SHIFT], k & at.LANES, upper_block(next_tile, (k - 1) & at.LANES), above
            )
            decrease += part
    tile, j = tiles[middle >> at.SHIFT], middle & at.LANES
    (block, force) = below
    (other, push) = above
    s, r = reduced(
        tile,
        j,
        (
            (
                block[0] + other[0],
                block[1] + other[1],
                block[2] + other[2],
                block[3] + other[3],
                block[4] + other[4],
                block[5] + other[5],
            ),
            (force[0] + push[0], force[1] + push[1], force[2] + push[2]),
        ),
    )
    a, determinant = adjugate(s)
    cx, cy, cz = times(a, r[0], r[1], r[2])
    low = high = (cx / determinant, cy / determinant, cz / determinant)
    tile[at.CX + j], tile[at.CY + j], tile[at.CZ + j] = low
    decrease += r[0] * low[0] + r[1] * low[1] + r[2] * low[2]
    for i in range(1, middle + 1):
        k = middle - i
        low = correct(tiles[k >> at.SHIFT], k & at.LANES, low)
        k = middle + i
        if k < count:
            high = correct(tiles[k >> at.SHIFT], k & at.LANES, high)
    return decrease
