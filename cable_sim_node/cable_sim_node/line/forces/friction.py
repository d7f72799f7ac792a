"""Friction between the wires of the rope, see `physics.rope_friction`: what it adds to the tension of the segments.

A segment keeps the strain HELD at which its friction is zero: it sticks with k EA (e - HELD), and takes HELD along
where it slides (return mapping, as of the seabed's friction). A slack segment has none.

Arguments as in `line.assembly`: `line` the arrays, `tiles` and `numbers` two of them.
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inlined_kernel, inner_kernel

from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.forces.segment import rank_one
from cable_sim_node.line.tiles import copy_borders
from cable_sim_node.physics.drag import Vector
from cable_sim_node.physics.tension_law import jenkin_force, stiffening, tangent_stiffness


@inner_kernel
def friction_at(tile: Array, j: int, strain: float, numbers: Array) -> tuple[float, float, float]:
    """Return friction [N] of segment `j` of `tile` at a `strain`, its derivative by that, and what it sticks with."""
    stiffness, q, c = tile[at.STIFFNESS + j], tile[at.QUADRATIC + j], tile[at.CUBIC + j]
    sticks = numbers[at.FRICTION_STICKS] * stiffness
    slides = numbers[at.FRICTION_SLIDES] if strain > 0.0 else 0.0
    limit, stuck = slides * stiffness * strain * stiffening(q, c, strain), sticks * (strain - tile[at.HELD + j])
    force = jenkin_force(stuck, -limit, limit)
    sliding = math.copysign(slides, force) * tangent_stiffness(stiffness, q, c, strain)
    return force, sticks if abs(stuck) < limit else sliding, sticks


@inlined_kernel
def stretch_at(tile: Array, j: int) -> tuple[Vector, float]:
    """Return the chord [m] of segment `j` of `tile` from its lower to its upper end, and its size."""
    x, y, z = (
        tile[at.X + j + 1] - tile[at.X + j],
        tile[at.Y + j + 1] - tile[at.Y + j],
        tile[at.Z + j + 1] - tile[at.Z + j],
    )
    return (x, y, z), math.sqrt(x * x + y * y + z * z)


@inner_kernel
def add_friction(tile: Array, count: int, numbers: Array) -> None:
    """Add the friction of the first `count` segments of `tile` in the middle state to tensions and equations."""
    for j in range(count):
        (ex, ey, ez), stretched = stretch_at(tile[at.MIDDLE :], j)
        inverse, per_length = 1.0 / (stretched + 1e-300), tile[at.PER_LENGTH + j]
        ex, ey, ez = ex * inverse, ey * inverse, ez * inverse
        force, by_strain, _ = friction_at(tile, j, stretched * per_length - 1.0, numbers)
        force = max(force, -tile[at.TENSION + j])
        tile[at.TENSION + j] += force
        tile[at.RX + j] -= force * ex
        tile[at.RY + j] -= force * ey
        tile[at.RZ + j] -= force * ez
        tile[at.END_RX + j + 1] += force * ex
        tile[at.END_RY + j + 1] += force * ey
        tile[at.END_RZ + j + 1] += force * ez
        turning = force * inverse
        xx, xy, xz, yy, yz, zz = rank_one(turning, by_strain * per_length - turning, ex, ey, ez)
        tile[at.UXX + j] -= xx
        tile[at.UXY + j] -= xy
        tile[at.UXZ + j] -= xz
        tile[at.UYY + j] -= yy
        tile[at.UYZ + j] -= yz
        tile[at.UZZ + j] -= zz
        tile[at.END_XX + j + 1] += xx
        tile[at.END_XY + j + 1] += xy
        tile[at.END_XZ + j + 1] += xz
        tile[at.END_YY + j + 1] += yy
        tile[at.END_YZ + j + 1] += yz
        tile[at.END_ZZ + j + 1] += zz


@inner_kernel
def carry_friction(line: LineArrays, n: int) -> None:
    """Let the `n` segments take the strain along at which they are held, as far as they slide in the present state.

    For a rope with friction only.
    """
    copy_borders(line.tiles, n, at.X, 3)
    for i in range(n):
        tile, j = line.tiles[i >> at.SHIFT], i & at.LANES
        _, stretched = stretch_at(tile, j)
        strain = stretched * tile[at.PER_LENGTH + j] - 1.0
        force, _, sticks = friction_at(tile, j, strain, line.numbers)
        tile[at.HELD + j] = strain - force / sticks


@inner_kernel
def merge_held(tiles: Array, n: int) -> None:
    """Let segment n - 2 be held as it and the top segment n - 1 are together, before they become one."""
    tile, j = tiles[(n - 2) >> at.SHIFT], (n - 2) & at.LANES
    top, k = tiles[(n - 1) >> at.SHIFT], (n - 1) & at.LANES
    share = top[at.LENGTH + k] / (top[at.LENGTH + k] + tile[at.LENGTH + j])
    tile[at.HELD + j] += share * (top[at.HELD + k] - tile[at.HELD + j])
