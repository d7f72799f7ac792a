"""How nodes and boom tip move over a step: generalised-alpha (Chung & Hulbert 1993) around the middle state.

Positions and velocities are blended by alpha_f, accelerations by alpha_m, between t_n and t_{n+1}. Arguments: `line`
the arrays, `n` segments in use, `count` nodes that move freely, `h` the step [s]; the others as in `assembly`.
"""

from __future__ import annotations

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inlined_kernel, inner_kernel

from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.feed import follow_length
from cable_sim_node.line.forces.body import follow_heave, set_unit
from cable_sim_node.line.forces.contact import carry_holds
from cable_sim_node.line.forces.flow import set_flow
from cable_sim_node.line.forces.friction import carry_friction
from cable_sim_node.line.tiles import copy_borders


@inner_kernel
def hermite(
    share: float, duration: float, start: float, start_rate: float, end: float, end_rate: float
) -> tuple[float, float, float]:
    """Return value, rate and acceleration at `share` of `duration` [s] of the cubic through both ends.

    `start` and `end` are its values there, `start_rate` and `end_rate` its rates.
    """
    s = share
    delta = end - start
    bend = delta - duration * start_rate
    turn = duration * (start_rate + end_rate) - 2.0 * delta
    value = start + s * (duration * start_rate + s * (bend + turn * (s - 1.0)))
    rate = start_rate + (2.0 * s * bend + turn * s * (3.0 * s - 2.0)) / duration
    acceleration = (2.0 * bend + turn * (6.0 * s - 2.0)) / (duration * duration)
    return value, rate, acceleration


@inlined_kernel
def load_end(share: float, duration: float, start_time: float, numbers: Array) -> None:
    """Set the boom tip and the length at the end of the step: at `share` of the interval of `advance`.

    The interval begins at `start_time` and lasts `duration` [s].
    """
    numbers[at.END + at.TIME] = start_time + share * duration
    for k in range(3):
        value, rate, acceleration = hermite(
            share,
            duration,
            numbers[at.ENDS + k],
            numbers[at.ENDS + 4 + k],
            numbers[at.ENDS + 8 + k],
            numbers[at.ENDS + 12 + k],
        )
        numbers[at.END + k], numbers[at.END + at.TIP_VX + k], numbers[at.END + at.TIP_AX + k] = (
            value,
            rate,
            acceleration,
        )
    value, rate, acceleration = hermite(
        share, duration, numbers[at.ENDS + 3], numbers[at.ENDS + 7], numbers[at.ENDS + 11], numbers[at.ENDS + 15]
    )
    numbers[at.END + at.TOTAL], numbers[at.END + at.RATE], numbers[at.END + at.ACCELERATION] = value, rate, acceleration


@inlined_kernel
def take_end(numbers: Array) -> None:
    """Make the end of the step the present: time, length and boom tip."""
    for c in range(at.TIP_NUMBERS):
        numbers[at.NOW + c] = numbers[at.END + c]


@inlined_kernel
def hold_top(tiles: Array, n: int, state: int, numbers: Array, tip: int, compensated: bool) -> None:
    """Put the sheave, node n of a `state` (MIDDLE or 0 for now), where the boom tip is that begins at `tip`.

    On a compensator (`compensated`) it keeps its own z.
    """
    tile, j = tiles[n >> at.SHIFT], n & at.LANES
    for c in range(at.MOTION_COLUMNS):
        if not (compensated and c % 3 == 2):
            tile[state + c * at.STRIDE + j] = numbers[tip + c]


@inlined_kernel
def blend_tip(numbers: Array) -> None:
    """Set time, length and boom tip where the equations hold."""
    af, am = numbers[at.ALPHA_F], numbers[at.ALPHA_M]
    for c in range(at.TIP_NUMBERS):
        weight = am if c == at.ACCELERATION or at.TIP_AX <= c <= at.TIP_AZ else af
        numbers[at.MIDWAY + c] = weight * numbers[at.NOW + c] + (1.0 - weight) * numbers[at.END + c]


@inlined_kernel
def predict(line: LineArrays, n: int, count: int, h: float) -> None:
    """Set the middle state for constant acceleration, and blend length and boom tip."""
    blend_tip(line.numbers)
    share = (1.0 - line.numbers[at.ALPHA_F]) * h
    for t in range(((count - 1) >> at.SHIFT) + 1):
        tile = line.tiles[t]
        for axis in range(3):
            node = tile[axis * at.STRIDE :]
            for j in range(min(at.TILE, count - (t << at.SHIFT))):
                x, v, a = node[at.X + j], node[at.VX + j], node[at.AX + j]
                node[at.MIDDLE + at.X + j] = x + share * (v + 0.5 * h * a)
                node[at.MIDDLE + at.VX + j] = v + share * a
                node[at.MIDDLE + at.AX + j] = a
    hold_top(line.tiles, n, at.MIDDLE, line.numbers, at.MIDWAY, count > n)
    copy_borders(line.tiles, n, at.MIDDLE, at.MOTION_COLUMNS)
    follow_length(n, line.numbers[at.MIDWAY + at.TOTAL], line.tiles)
    set_flow(line, n, line.numbers[at.MIDWAY + at.TIME])
    if line.numbers[at.UNIT_VARIES] > 0.0:
        set_unit(line, line.numbers[at.MIDWAY + at.TIME], h)


@inlined_kernel
def move(tiles: Array, n: int, part: float, c_velocity: float, c_mass: float) -> None:
    """Add `part` of the corrections to the middle state of nodes 0..n: position, velocity and acceleration."""
    for t in range((n >> at.SHIFT) + 1):
        tile = tiles[t]
        for axis in range(3):
            node = tile[axis * at.STRIDE :]
            for j in range(min(at.TILE, n - (t << at.SHIFT)) + 1):
                c = part * node[at.CX + j]
                node[at.MIDDLE + at.X + j] += c
                node[at.MIDDLE + at.VX + j] += c_velocity * c
                node[at.MIDDLE + at.AX + j] += c_mass * c


@inlined_kernel
def finish(line: LineArrays, n: int, count: int, h: float) -> None:
    """Carry the middle state of nodes 0..count-1 to the end of the step of `h` seconds."""
    numbers = line.numbers
    am, beta, gamma = numbers[at.ALPHA_M], numbers[at.BETA], numbers[at.GAMMA]
    per_rest = 1.0 / (1.0 - am)
    for t in range(((count - 1) >> at.SHIFT) + 1):
        tile = line.tiles[t]
        for axis in range(3):
            node = tile[axis * at.STRIDE :]
            for j in range(min(at.TILE, count - (t << at.SHIFT))):
                a, v = node[at.AX + j], node[at.VX + j]
                new = (node[at.MIDDLE + at.AX + j] - am * a) * per_rest
                node[at.X + j] += h * (v + h * ((0.5 - beta) * a + beta * new))
                node[at.VX + j] = v + h * ((1.0 - gamma) * a + gamma * new)
                node[at.AX + j] = new
    take_end(numbers)
    hold_top(line.tiles, n, at.X, numbers, at.NOW, count > n)
    follow_length(n, numbers[at.NOW + at.TOTAL], line.tiles)
    carry_holds(line, n)
    if numbers[at.FRICTION_ON] > 0.0:
        carry_friction(line, n)
    if numbers[at.KC_ROWS] > 0.0:
        follow_heave(line, h)
