"""Motion of the water along the line: current profile with a factor in time, and one regular deep-water wave (Airy).

Arguments: `line` the arrays, `time` [s].
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel

from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.physics.current import FLOW, between, locate


@inner_kernel
def set_flow(line: LineArrays, n: int, time: float) -> None:
    """Set the motion of the water along the middle state of `line`, with `n` segments, at `time` [s]."""
    if line.numbers[at.FLOW_VARIES] == 0.0:
        return
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
    rows = int(numbers[at.CURRENT_ROWS])
    first, last, share = locate(time, line.water[rows:])
    factor = between(line.water[rows:], first, last, share, 1)
    z = 0.5 * (tile[at.MIDDLE + at.Z + low] + tile[at.MIDDLE + at.Z + high])
    current = line.water[:rows]
    first, last, share = locate(-z, current)
    tile[at.FLOW_X + high] = factor * between(current, first, last, share, FLOW)
    tile[at.FLOW_Y + high] = factor * between(current, first, last, share, FLOW + 1)
    tile[at.FLOW_Z + high] = 0.0
    if numbers[at.WAVE_AMPLITUDE] > 0.0:
        x = 0.5 * (tile[at.MIDDLE + at.X + low] + tile[at.MIDDLE + at.X + high])
        y = 0.5 * (tile[at.MIDDLE + at.Y + low] + tile[at.MIDDLE + at.Y + high])
        add_wave(time, x, y, z, numbers, tile, high)


@inner_kernel
def add_wave(time: float, x: float, y: float, z: float, numbers: Array, tile: Array, place: int) -> None:
    """Add the wave's velocity at (x, y, z) to the flow at a `place` of `tile`, and set its acceleration.

    Crests pass the origin at `time` 0 and travel in the direction that `numbers` say.
    """
    omega, number = numbers[at.WAVE_FREQUENCY], numbers[at.WAVE_NUMBER]
    dx, dy = numbers[at.WAVE_X], numbers[at.WAVE_Y]
    phase = number * (dx * x + dy * y) - omega * time
    speed = numbers[at.WAVE_AMPLITUDE] * omega * math.exp(number * min(z, 0.0))
    cosine, sine = speed * math.cos(phase), speed * math.sin(phase)
    tile[at.FLOW_X + place] += cosine * dx
    tile[at.FLOW_Y + place] += cosine * dy
    tile[at.FLOW_Z + place] += sine
    tile[at.FLOW_AX + place] = omega * sine * dx
    tile[at.FLOW_AY + place] = omega * sine * dy
    tile[at.FLOW_AZ + place] = -omega * cosine
