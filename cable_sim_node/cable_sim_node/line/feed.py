"""Cable that enters and leaves at the sheave: the top segment, and the birth and death of nodes below it.

The grid of material points is counted from the unit and never moves; node i < n sits on grid point i for good. Only the
top segment, from grid point n - 1 to the length L, changes. It is divided and merged with the mass of the line, its
stretch and (when it is divided) its momentum kept, and a new node is put where its own forces give it the acceleration
of its surroundings, so that tension does not jump. Arguments as in `assembly`.
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inlined_kernel, inner_kernel, kernel

from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.assembly import add_lump, assemble_present, take_present_tip
from cable_sim_node.line.forces.contact import add_contact
from cable_sim_node.line.forces.friction import merge_held
from cable_sim_node.line.forces.segment import adjugate, times
from cable_sim_node.line.forces.surface import set_level
from cable_sim_node.line.tiles import copy_borders

_PARTS_END = at.PART + at.PART_COLUMNS * at.STRIDE


@inner_kernel
def start_of(i: int, tiles: Array) -> float:
    """Return the unstretched length [m] from the unit to grid point i."""
    return float(tiles[i >> at.SHIFT, at.START + (i & at.LANES)])


@inner_kernel
def spacing_at(i: int, tiles: Array) -> float:
    """Return the unstretched length [m] of grid segment i."""
    return float(tiles[i >> at.SHIFT, at.GRID + at.LENGTH + (i & at.LANES)])


@kernel
def set_top_segment(n: int, total: float, tiles: Array) -> None:
    """Set the top segment, from grid point n - 1 to the length `total` [m], and the lump of the sheave.

    Where it spans several grid segments (other sections), what is per metre is averaged by length and the compliance is
    added. A lump on the way bears on both ends by the law of the lever, as do mass and weight of the parts: that is
    what the node will take over.
    """
    tile, k = tiles[(n - 1) >> at.SHIFT], (n - 1) & at.LANES
    sheave, m = tiles[n >> at.SHIFT], n & at.LANES
    start = tile[at.START + k]
    length = total - start
    for c in range(at.PART, _PARTS_END, at.STRIDE):
        tile[c + k] = tile[at.GRID + c + k]
    for c in range(at.LUMP_MASS, _PARTS_END, at.STRIDE):
        sheave[c + m] = 0.0
    tile[at.LENGTH + k], tile[at.PER_LENGTH + k] = length, 1.0 / length
    if sheave[at.START + m] >= total:
        return
    compliance = leaning_mass = leaning_weight = 0.0
    for c in range(at.MASS, at.BENDING, at.STRIDE):  # mass to displaced mass, per metre
        tile[c + k] = 0.0
    i = n - 1
    while start_of(i, tiles) < total:
        grid, j = tiles[i >> at.SHIFT, at.GRID :], i & at.LANES
        low, high = start_of(i, tiles), min(start_of(i + 1, tiles), total)
        part = (high - low) / length
        compliance += part / grid[at.STIFFNESS + j]
        # the lower end takes half of the mean of all parts; what a part adds to its nearer end goes into the lumps
        lean = 0.5 - (0.5 * (low + high) - start) / length
        leaning_mass += lean * part * length * grid[at.MASS + j]
        leaning_weight += lean * part * length * grid[at.WEIGHT + j]
        for c in range(at.MASS, at.BENDING, at.STRIDE):
            tile[c + k] += part * grid[c + j]
        if i >= n:
            upper_share = (low - start) / length
            for c in range(at.LUMP_MASS, _PARTS_END, at.STRIDE):
                sheave[c + m] += upper_share * grid[c + j]
                tile[c + k] += (1.0 - upper_share) * grid[c + j]
        i += 1
    tile[at.STIFFNESS + k] = 1.0 / compliance
    tile[at.LUMP_MASS + k] += leaning_mass
    sheave[at.LUMP_MASS + m] -= leaning_mass
    tile[at.LUMP_WEIGHT + k] += leaning_weight
    sheave[at.LUMP_WEIGHT + m] -= leaning_weight


@inlined_kernel
def follow_length(n: int, total: float, tiles: Array) -> None:
    """Do `set_top_segment` if the top segment was last set for another length than `total` [m]."""
    j = (n - 1) & at.LANES
    tile = tiles[(n - 1) >> at.SHIFT]
    if tile[at.LENGTH + j] != total - tile[at.START + j]:
        set_top_segment(n, total, tiles)


@inner_kernel
def take_grid_part(i: int, tiles: Array) -> None:
    """Make segment i, and the lump below it, those of the grid."""
    tile, j = tiles[i >> at.SHIFT], i & at.LANES
    for c in range(at.PART, _PARTS_END, at.STRIDE):
        tile[c + j] = tile[at.GRID + c + j]


@inner_kernel
def move_sheave(old: int, new: int, tiles: Array) -> None:
    """Let node `new` take over the state of node `old`."""
    source, target = tiles[old >> at.SHIFT], tiles[new >> at.SHIFT]
    for c in range(at.X, at.X + at.NODE_COLUMNS * at.STRIDE, at.STRIDE):
        target[c + (new & at.LANES)] = source[c + (old & at.LANES)]


@inner_kernel
def merge_top(n: int, tiles: Array) -> int:
    """Remove the node below the sheave; return the new number of segments."""
    merge_held(tiles, n)
    take_grid_part(n - 1, tiles)
    move_sheave(n, n - 1, tiles)
    return n - 1


@inner_kernel
def split_top(line: LineArrays, n: int) -> int:
    """Put a node on grid point n, on the straight line between its neighbours; return the new number of segments.

    Velocity and acceleration are those of the material there, linear along the segment.
    """
    tiles, numbers = line.tiles, line.numbers
    rate, acceleration = numbers[at.NOW + at.RATE], numbers[at.NOW + at.ACCELERATION]
    start = start_of(n - 1, tiles)
    length = numbers[at.NOW + at.TOTAL] - start
    share = (start_of(n, tiles) - start) / length
    move_sheave(n, n + 1, tiles)
    i, j, k = (n - 1) & at.LANES, n & at.LANES, (n + 1) & at.LANES
    for axis in range(3):
        c = axis * at.STRIDE
        low, born, sheave = tiles[(n - 1) >> at.SHIFT, c:], tiles[n >> at.SHIFT, c:], tiles[(n + 1) >> at.SHIFT, c:]
        q = (sheave[at.X + k] - low[at.X + i]) / length
        velocity = sheave[at.VX + k] - rate * q
        turning = (velocity - low[at.VX + i]) / length
        material = sheave[at.AX + k] - acceleration * q - 2.0 * rate * turning
        born[at.X + j] = low[at.X + i] + share * (sheave[at.X + k] - low[at.X + i])
        born[at.VX + j] = low[at.VX + i] + share * (velocity - low[at.VX + i])
        born[at.AX + j] = low[at.AX + i] + share * (material - low[at.AX + i])
        born[at.HOLD_X + j] = born[at.X + j]
    take_grid_part(n - 1, tiles)
    tiles[n >> at.SHIFT, at.HELD + j] = tiles[(n - 1) >> at.SHIFT, at.HELD + i]
    return n + 1


@inner_kernel
def join_at(tiles: Array, k: int) -> None:
    """Give node `k`, above the unit, the diagonal block and the residual of the segments below and above it."""
    tile, j = tiles[k >> at.SHIFT], k & at.LANES
    below, i = tiles[(k - 1) >> at.SHIFT], ((k - 1) & at.LANES) + 1
    for c in range(0, 6 * at.STRIDE, at.STRIDE):
        tile[at.DXX + c + j] = below[at.END_XX + c + i] + tile[at.END_XX + c + j + 1]
    for c in range(0, 3 * at.STRIDE, at.STRIDE):
        tile[at.RX + c + j] += below[at.END_RX + c + i]


@inner_kernel
def settle_node(line: LineArrays, k: int, n: int) -> None:
    """Move the newborn node `k` of n segments to where its forces give it the acceleration it has.

    A node between slack segments stays.
    """
    tiles = line.tiles
    below, i = tiles[(k - 1) >> at.SHIFT], (k - 1) & at.LANES
    tile, j = tiles[k >> at.SHIFT], k & at.LANES
    for _ in range(6):
        copy_borders(tiles, n, at.X, at.MOTION_COLUMNS)
        assemble_present(line, n, k - 1)
        assemble_present(line, n, k)
        if below[at.TENSION + i] <= 0.0 or tile[at.TENSION + j] <= 0.0:
            return
        join_at(tiles, k)
        add_lump(tiles, k, 0.0, 0.0)
        if line.numbers[at.BED_ON] > 0.0:
            add_contact(line, k, 0.0)
        a, determinant = adjugate(
            (tile[at.DXX + j], tile[at.DXY + j], tile[at.DXZ + j], tile[at.DYY + j], tile[at.DYZ + j], tile[at.DZZ + j])
        )
        dx, dy, dz = times(a, tile[at.RX + j], tile[at.RY + j], tile[at.RZ + j])
        scale = -1.0 / determinant
        dx, dy, dz = scale * dx, scale * dy, scale * dz
        size = math.sqrt(dx * dx + dy * dy + dz * dz)
        # a step of more than a tenth of a segment means that there is no such position: the node stays where it is
        if not size < 0.1 * min(below[at.LENGTH + i], tile[at.LENGTH + j]):
            return
        tile[at.X + j] += dx
        tile[at.Y + j] += dy
        tile[at.Z + j] += dz
        if size < 1e-9 * tile[at.LENGTH + j]:
            return


@inlined_kernel
def feed(line: LineArrays, n: int) -> int:
    """Let nodes be born or die until the top segment is neither too long nor too short; return the number of segments.

    `n` is their number until now. The caller keeps the length above the least one and below the grid's end.
    """
    tiles, numbers = line.tiles, line.numbers
    total = numbers[at.NOW + at.TOTAL]
    while n > 1 and total - start_of(n - 1, tiles) < at.MERGE_AT * spacing_at(n - 1, tiles):
        n = merge_top(n, tiles)
        set_top_segment(n, total, tiles)
    while total - start_of(n, tiles) > at.SPLIT_AT * spacing_at(n, tiles):
        n = split_top(line, n)
        set_top_segment(n, total, tiles)
        take_present_tip(numbers)
        set_level(line)
        settle_node(line, n - 1, n)
    return n
