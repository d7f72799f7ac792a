"""The water's surface, and the cable above it. It is that of still water, z = 0, and of the waves.

Cable above the surface has its weight in air, and neither drag nor added mass: while its equations are assembled, a
segment has what it has with its dry share in air. Cable is dry from the boom tip down to the first segment that is all
wet; the surface is taken below the boom tip.

Arguments: `tile` and `j` as in `line.assembly`.
"""

from __future__ import annotations

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel

from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.forces.waves import surface_at


@inner_kernel
def dry_share(low: float, high: float, level: float) -> float:
    """Return the share of a straight piece between the heights `low` and `high` [m] that is above `level` [m]."""
    bottom, top = min(low, high), max(low, high)
    if top <= level:
        return 0.0
    return 1.0 if bottom >= level else (top - level) / (top - bottom)


@inner_kernel
def dry_part(tile: Array, j: int, level: float) -> float:
    """Return the share of a segment that is above `level` [m] in the middle state."""
    return dry_share(tile[at.MIDDLE + at.Z + j], tile[at.MIDDLE + at.Z + j + 1], level)


@inner_kernel
def take_from_water(tile: Array, j: int, dry: float, gravity: float) -> None:
    """Give segment `j` of `tile` the weight, drag and mass that it has with a `dry` share of it in air.

    `gravity` [m/s^2] acts. `put_back` gives the segment what it has in water again.
    """
    for k in range(at.FLUID_COLUMNS):
        tile[at.KEPT + k * at.STRIDE + j] = tile[at.ADDED_MASS + k * at.STRIDE + j]
    tile[at.WEIGHT + j] += dry * tile[at.DISPLACED + j] * gravity
    tile[at.ADDED_MASS + j] *= 1.0 - dry
    tile[at.NORMAL_DRAG + j] *= 1.0 - dry
    tile[at.TANGENTIAL_DRAG + j] *= 1.0 - dry
    tile[at.DISPLACED + j] *= 1.0 - dry


@inner_kernel
def put_back(tile: Array, j: int) -> None:
    """Give segment `j` of `tile` what it has in water again."""
    for k in range(at.FLUID_COLUMNS):
        tile[at.ADDED_MASS + k * at.STRIDE + j] = tile[at.KEPT + k * at.STRIDE + j]


@inner_kernel
def set_level(line: LineArrays) -> None:
    """Set the height of the surface below the boom tip, where the equations hold."""
    numbers = line.numbers
    if numbers[at.WAVES] > 0.0:
        x, y, time = numbers[at.MIDWAY], numbers[at.MIDWAY + 1], numbers[at.MIDWAY + at.TIME]
        numbers[at.LEVEL] = surface_at(line, x, y, time)[0]


@inner_kernel
def take_out_of_water(line: LineArrays, n: int) -> int:
    """Take the cable above the surface from the water, of the `n` segments of `line`; return how many segments."""
    level = line.numbers[at.LEVEL]
    for i in range(n - 1, -1, -1):
        tile, j = line.tiles[i >> at.SHIFT], i & at.LANES
        dry = dry_part(tile, j, level)
        if dry == 0.0:
            return n - 1 - i
        take_from_water(tile, j, dry, line.numbers[at.GRAVITY])
    return n


@inner_kernel
def put_all_back(line: LineArrays, n: int, count: int) -> None:
    """Put the upper `count` of the `n` segments of `line` back."""
    for i in range(n - count, n):
        put_back(line.tiles[i >> at.SHIFT], i & at.LANES)
