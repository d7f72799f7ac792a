"""How nodes and boom tip move over a step: generalised-alpha (Chung & Hulbert 1993) around the middle state.

Positions and velocities are blended by alpha_f, accelerations by alpha_m, between t_n and t_{n+1}. Arguments: `line`
the arrays, `n` segments in use, `count` nodes that move freely, `h` the step [s]; the others as in `assembly`.
"""

from __future__ import annotations

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inlined_kernel, inner_kernel

from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.feed import follow_length
from cable_sim_node.line.forces.body import follow_heave, set_unit
from cable_sim_node.line.forces.contact import carry_holds
from cable_sim_node.line.forces.flow import set_flow
from cable_sim_node.line.layout import (
    ACCELERATION,
    ALPHA_F,
    ALPHA_M,
    AX,
    BETA,
    CX,
    END,
    ENDS,
    GAMMA,
    KC_ROWS,
    LANES,
    MIDDLE,
    MIDWAY,
    MOTION_COLUMNS,
    NOW,
    RATE,
    SHIFT,
    STRIDE,
    TILE,
    TIME,
    TIP_AX,
    TIP_AZ,
    TIP_NUMBERS,
    TIP_VX,
    TOTAL,
    UNIT_VARIES,
    VX,
    X,
)
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
    numbers[END + TIME] = start_time + share * duration
    for k in range(3):
        value, rate, acceleration = hermite(
            share, duration, numbers[ENDS + k], numbers[ENDS + 4 + k], numbers[ENDS + 8 + k], numbers[ENDS + 12 + k]
        )
        numbers[END + k], numbers[END + TIP_VX + k], numbers[END + TIP_AX + k] = value, rate, acceleration
    value, rate, acceleration = hermite(
        share, duration, numbers[ENDS + 3], numbers[ENDS + 7], numbers[ENDS + 11], numbers[ENDS + 15]
    )
    numbers[END + TOTAL], numbers[END + RATE], numbers[END + ACCELERATION] = value, rate, acceleration


@inlined_kernel
def take_end(numbers: Array) -> None:
    """Make the end of the step the present: time, length and boom tip."""
    for c in range(TIP_NUMBERS):
        numbers[NOW + c] = numbers[END + c]


@inlined_kernel
def hold_top(tiles: Array, n: int, state: int, numbers: Array, tip: int, compensated: bool) -> None:
    """Put the sheave, node n of a `state` (MIDDLE or 0 for now), where the boom tip is that begins at `tip`.

    On a compensator (`compensated`) it keeps its own z.
    """
    tile, j = tiles[n >> SHIFT], n & LANES
    for c in range(MOTION_COLUMNS):
        if not (compensated and c % 3 == 2):
            tile[state + c * STRIDE + j] = numbers[tip + c]


@inlined_kernel
def blend_tip(numbers: Array) -> None:
    """Set time, length and boom tip where the equations hold."""
    af, am = numbers[ALPHA_F], numbers[ALPHA_M]
    for c in range(TIP_NUMBERS):
        weight = am if c == ACCELERATION or TIP_AX <= c <= TIP_AZ else af
        numbers[MIDWAY + c] = weight * numbers[NOW + c] + (1.0 - weight) * numbers[END + c]


@inlined_kernel
def predict(line: LineArrays, n: int, count: int, h: float) -> None:
    """Set the middle state for constant acceleration, and blend length and boom tip."""
    blend_tip(line.numbers)
    share = (1.0 - line.numbers[ALPHA_F]) * h
    for t in range(((count - 1) >> SHIFT) + 1):
        tile = line.tiles[t]
        for axis in range(3):
            node = tile[axis * STRIDE :]
            for j in range(min(TILE, count - (t << SHIFT))):
                x, v, a = node[X + j], node[VX + j], node[AX + j]
                node[MIDDLE + X + j] = x + share * (v + 0.5 * h * a)
                node[MIDDLE + VX + j] = v + share * a
                node[MIDDLE + AX + j] = a
    hold_top(line.tiles, n, MIDDLE, line.numbers, MIDWAY, count > n)
    copy_borders(line.tiles, n, MIDDLE, MOTION_COLUMNS)
    follow_length(n, line.numbers[MIDWAY + TOTAL], line.tiles)
    set_flow(line, n, line.numbers[MIDWAY + TIME])
    if line.numbers[UNIT_VARIES] > 0.0:
        set_unit(line, line.numbers[MIDWAY + TIME])


@inlined_kernel
def move(tiles: Array, n: int, part: float, c_velocity: float, c_mass: float) -> None:
    """Add `part` of the corrections to the middle state of nodes 0..n: position, velocity and acceleration."""
    for t in range((n >> SHIFT) + 1):
        tile = tiles[t]
        for axis in range(3):
            node = tile[axis * STRIDE :]
            for j in range(min(TILE, n - (t << SHIFT)) + 1):
                c = part * node[CX + j]
                node[MIDDLE + X + j] += c
                node[MIDDLE + VX + j] += c_velocity * c
                node[MIDDLE + AX + j] += c_mass * c


@inlined_kernel
def finish(line: LineArrays, n: int, count: int, h: float) -> None:
    """Carry the middle state of nodes 0..count-1 to the end of the step of `h` seconds."""
    numbers = line.numbers
    am, beta, gamma = numbers[ALPHA_M], numbers[BETA], numbers[GAMMA]
    per_rest = 1.0 / (1.0 - am)
    for t in range(((count - 1) >> SHIFT) + 1):
        tile = line.tiles[t]
        for axis in range(3):
            node = tile[axis * STRIDE :]
            for j in range(min(TILE, count - (t << SHIFT))):
                a, v = node[AX + j], node[VX + j]
                new = (node[MIDDLE + AX + j] - am * a) * per_rest
                node[X + j] += h * (v + h * ((0.5 - beta) * a + beta * new))
                node[VX + j] = v + h * ((1.0 - gamma) * a + gamma * new)
                node[AX + j] = new
    take_end(numbers)
    hold_top(line.tiles, n, X, numbers, NOW, count > n)
    follow_length(n, numbers[NOW + TOTAL], line.tiles)
    carry_holds(line, n)
    if numbers[KC_ROWS] > 0.0:
        follow_heave(line, h)
