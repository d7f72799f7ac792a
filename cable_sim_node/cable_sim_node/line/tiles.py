"""What is done along a tile's columns: borders kept, the largest and the sum of a column (see `layout`).

Arguments: `tiles` the line's, or one `tile` of them.
"""

from __future__ import annotations

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inlined_kernel, inner_kernel

from cable_sim_node.line import layout as at


@inlined_kernel
def copy_borders(tiles: Array, n: int, first: int, columns: int) -> None:
    """Let each tile's border repeat the first node of the next one, in so many `columns` from `first` on.

    `n` segments are in use.
    """
    for t in range(n >> at.SHIFT):
        tile, above = tiles[t], tiles[t + 1]
        for column in range(columns):
            tile[first + column * at.STRIDE + at.TILE] = above[first + column * at.STRIDE]


@inner_kernel
def take_present(tiles: Array, n: int) -> None:
    """Set the motion where the equations hold to the present one, of nodes 0..n."""
    copy_borders(tiles, n, at.X, at.MOTION_COLUMNS)
    for t in range((n >> at.SHIFT) + 1):
        tile = tiles[t]
        for column in range(at.MOTION_COLUMNS):
            row = tile[column * at.STRIDE :]
            for j in range(min(at.TILE, n - (t << at.SHIFT)) + 1):
                row[at.MIDDLE + j] = row[j]


@inner_kernel
def larger(one: float, other: float) -> float:
    """Return the larger of `one` and `other`, or NaN where one is."""
    is_none = other != other  # noqa: PLR0124 (NaN alone differs from itself, and is_nan would not vectorise)
    return other if other > one or is_none else one


@inner_kernel
def largest_of(tile: Array, count: int) -> float:
    """Return the largest of the first `count` numbers in SCRATCH, NaN where one is; it is used up.

    Halves are folded on one another, so that it is done by vector instructions.
    """
    row = tile[at.SCRATCH :]
    for j in range(count, at.TILE):
        row[j] = row[0]
    for j in range(32):
        row[j] = larger(row[j], row[32 + j])
    for j in range(16):
        row[j] = larger(row[j], row[16 + j])
    for j in range(8):
        row[j] = larger(row[j], row[8 + j])
    for j in range(4):
        row[j] = larger(row[j], row[4 + j])
    return larger(larger(row[0], row[1]), larger(row[2], row[3]))


@inner_kernel
def sum_of(tile: Array, count: int) -> float:
    """Return the sum of the first `count` numbers in SCRATCH, in pairs as in `largest_of`; it is used up."""
    row = tile[at.SCRATCH :]
    for j in range(count, at.TILE):
        row[j] = 0.0
    for j in range(32):
        row[j] += row[32 + j]
    for j in range(16):
        row[j] += row[16 + j]
    for j in range(8):
        row[j] += row[8 + j]
    for j in range(4):
        row[j] += row[4 + j]
    return (row[0] + row[1]) + (row[2] + row[3])
