"""The water's surface, and the cable above it. It is that of still water, z = 0, and of the waves of `forces.flow`.

Cable above the surface has its weight in air, and neither drag nor added mass: what water does to the dry share of a
segment is taken back from the equations of its ends. Cable is dry from the boom tip down to the first segment that is
all wet; the surface is taken below the boom tip.

Arguments: `tile`, `j` and `numbers` as in `line.assembly`; `x`, `y` [m] where the surface is asked for, `time` [s].
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel

from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.forces.direction import direction_at
from cable_sim_node.line.forces.segment import rank_one
from cable_sim_node.physics.drag import drag_force, resolve


@inner_kernel
def surface_at(x: float, y: float, time: float, numbers: Array) -> tuple[float, float]:
    """Return the height of the surface [m] and its rate [m/s]."""
    if numbers[at.WAVE_AMPLITUDE] == 0.0:
        return 0.0, 0.0
    phase = (
        numbers[at.WAVE_NUMBER] * (numbers[at.WAVE_X] * x + numbers[at.WAVE_Y] * y) - numbers[at.WAVE_FREQUENCY] * time
    )
    amplitude = numbers[at.WAVE_AMPLITUDE]
    return amplitude * math.cos(phase), amplitude * numbers[at.WAVE_FREQUENCY] * math.sin(phase)


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
def take_from_water(tile: Array, j: int, dry: float, numbers: Array, c_mass: float) -> None:
    """Take back what water does to the `dry` share of segment `j` of `tile`; `c_mass` as in `line.assembly`.

    Drag stays in the Jacobian: it keeps a correction short, and is small.
    """
    half = 0.5 * tile[at.LENGTH + j] * dry
    e = direction_at(tile, j)
    ux = 0.5 * (tile[at.MIDDLE + at.VX + j] + tile[at.MIDDLE + at.VX + j + 1]) - tile[at.FLOW_X + j + 1]
    uy = 0.5 * (tile[at.MIDDLE + at.VY + j] + tile[at.MIDDLE + at.VY + j + 1]) - tile[at.FLOW_Y + j + 1]
    uz = 0.5 * (tile[at.MIDDLE + at.VZ + j] + tile[at.MIDDLE + at.VZ + j + 1]) - tile[at.FLOW_Z + j + 1]
    slip, across, speed = resolve(e, ux, uy, uz)
    hx, hy, hz = drag_force(
        half * tile[at.NORMAL_DRAG + j], half * tile[at.TANGENTIAL_DRAG + j], e, slip, across, speed
    )
    hz -= half * tile[at.DISPLACED + j] * numbers[at.GRAVITY]
    added, displaced = half * tile[at.ADDED_MASS + j], half * tile[at.DISPLACED + j]
    wx = wy = wz = 0.0
    if numbers[at.WAVE_AMPLITUDE] > 0.0:
        wx, wy, wz = tile[at.FLOW_AX + j + 1], tile[at.FLOW_AY + j + 1], tile[at.FLOW_AZ + j + 1]
    for end in range(2):
        ax = tile[at.MIDDLE + at.AX + j + end] - wx
        ay = tile[at.MIDDLE + at.AY + j + end] - wy
        az = tile[at.MIDDLE + at.AZ + j + end] - wz
        along = added * (e[0] * ax + e[1] * ay + e[2] * az)
        x, y, z = at.RX + j, at.RY + j, at.RZ + j
        if end == 1:
            x, y, z = at.END_RX + j + 1, at.END_RY + j + 1, at.END_RZ + j + 1
        tile[x] -= added * ax - along * e[0] + hx - displaced * wx
        tile[y] -= added * ay - along * e[1] + hy - displaced * wy
        tile[z] -= added * az - along * e[2] + hz - displaced * wz
    block = rank_one(c_mass * added, -c_mass * added, e[0], e[1], e[2])
    for k in range(6):
        tile[at.END_XX + k * at.STRIDE + j + 1] -= block[k]


@inner_kernel
def level_above(line: LineArrays, n: int) -> float:
    """Return the height of the surface [m] below the boom tip, the upper end of `n` segments of `line`."""
    tile, j = line.tiles[n >> at.SHIFT], n & at.LANES
    return surface_at(
        tile[at.MIDDLE + at.X + j], tile[at.MIDDLE + at.Y + j], line.numbers[at.MIDWAY + at.TIME], line.numbers
    )[0]


@inner_kernel
def take_out_of_water(line: LineArrays, n: int, c_mass: float) -> None:
    """Take back what water does to the cable above the surface; see the text of the module.

    `line` has `n` segments, which are assembled, and not yet joined; `c_mass` as in `line.assembly`.
    """
    level = level_above(line, n)
    for i in range(n - 1, -1, -1):
        tile, j = line.tiles[i >> at.SHIFT], i & at.LANES
        dry = dry_part(tile, j, level)
        if dry == 0.0:
            return
        take_from_water(tile, j, dry, line.numbers, c_mass)
