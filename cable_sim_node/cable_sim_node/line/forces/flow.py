"""Motion of the water along the line: current profile, and waves.

Arguments: `line` the arrays, `time` [s].
"""

from __future__ import annotations

from heave_node.numerics.compiled import inner_kernel

from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.forces.surface import dry_part, set_level
from cable_sim_node.line.forces.waves import add_waves
from cable_sim_node.physics.current import FLOW, between, locate


@inner_kernel
def set_flow(line: LineArrays, n: int, time: float) -> None:
    """Set the motion of the water along the middle state of `line`, with `n` segments, at `time` [s]."""
    if line.numbers[at.FLOW_VARIES] == 0.0:
        return
    set_level(line)
    set_flow_at(line, at.NONE, at.NONE, at.NONE, time)
    for i in range(n):
        j = i & at.LANES
        set_flow_at(line, i >> at.SHIFT, j, j + 1, time)


@inner_kernel
def set_flow_at(line: LineArrays, t: int, low: int, high: int, time: float) -> None:
    """Set velocity [m/s] and acceleration [m/s^2] of the water at the middle of places `low` and `high` of tile `t`.

    They are kept at the place `high`: the unit's at 0, those of segment j at j + 1.
    """
    tile, numbers = line.tiles[t], line.numbers
    current = line.water[: int(numbers[at.PROFILE_END])]
    z = 0.5 * (tile[at.MIDDLE + at.Z + low] + tile[at.MIDDLE + at.Z + high])
    first, last, share = locate(-z, current)
    tile[at.FLOW_X + high] = between(current, first, last, share, FLOW)
    tile[at.FLOW_Y + high] = between(current, first, last, share, FLOW + 1)
    tile[at.FLOW_Z + high] = 0.0
    if numbers[at.WAVES] > 0.0:
        x = 0.5 * (tile[at.MIDDLE + at.X + low] + tile[at.MIDDLE + at.X + high])
        y = 0.5 * (tile[at.MIDDLE + at.Y + low] + tile[at.MIDDLE + at.Y + high])
        is_dry = numbers[at.SURFACE_ON] > 0.0 and low < high and dry_part(tile, low, numbers[at.LEVEL]) == 1.0
        if is_dry:
            tile[at.FLOW_AX + high] = tile[at.FLOW_AY + high] = tile[at.FLOW_AZ + high] = 0.0
        else:
            add_waves(line, x, y, z, time, tile, high)
