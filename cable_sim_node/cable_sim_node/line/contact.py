"""The seabed under a node: elastic and damped, with Coulomb friction that sticks and slips.

Normal to the plane that touches it above or below the node: N = k d + c d' while positive, d the depth of penetration.
Along it the node holds to a place h by the same k and c, F = k (x - h) + c v, at most mu N; beyond that it slips at
mu N and takes its hold along, so that k |x - h| is mu N (Coulomb friction as return mapping: Simo & Hughes 1998,
section 1.4). What sticks is therefore at rest for good, within mu N/k of where it came to hold.

Arguments as in `assembly`; `line` is the `LineArrays`, `normal` the unit vector normal to the seabed there, upwards.
"""

from __future__ import annotations

import math

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel, kernel

from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.layout import (
    BED_DAMPING,
    BED_DEPTH,
    BED_FRICTION,
    BED_ON,
    BED_SLOPE_X,
    BED_SLOPE_Y,
    BED_STIFFNESS,
    BED_UNIT_DAMPING,
    BED_UNIT_STIFFNESS,
    DXX,
    DXY,
    DXZ,
    DYY,
    DYZ,
    DZZ,
    EQUATION_COLUMNS,
    HOLD_X,
    HOLD_Y,
    HOLD_Z,
    LENGTH,
    PROFILE_ROWS,
    PROFILE_X,
    PROFILE_Y,
    RX,
    RY,
    RZ,
    SETTING_COLUMNS,
    VX,
    VY,
    VZ,
    X,
    Y,
    Z,
)
from cable_sim_node.physics.drag import Vector
from cable_sim_node.physics.seabed import height_and_slope

_FIRM_DEPTH = 0.01
"""Normal damping sets in over this penetration [m]: no jump in force at first touch."""


@inner_kernel
def bottom_under(node: Array, settings: Array) -> tuple[float, Vector]:
    """Return how deep `node` is in the seabed [m], negative above it, and the unit vector normal to it, upwards."""
    sx, sy = settings[BED_SLOPE_X], settings[BED_SLOPE_Y]
    x, y = node[X], node[Y]
    height = sx * x + sy * y - settings[BED_DEPTH]
    rows = int(settings[PROFILE_ROWS])
    if rows > 0:
        along_x, along_y = settings[PROFILE_X], settings[PROFILE_Y]
        hill, slope = height_and_slope(along_x * x + along_y * y, settings, SETTING_COLUMNS, rows)
        height, sx, sy = height + hill, sx + slope * along_x, sy + slope * along_y
    norm = 1.0 / math.sqrt(1.0 + sx * sx + sy * sy)
    return (height - node[Z]) * norm, (-sx * norm, -sy * norm, norm)


@inner_kernel
def ground_of(i: int, parts: Array, settings: Array) -> tuple[float, float]:
    """Return stiffness [N/m] and damping [N s/m] of the ground under node i."""
    if i == 0:
        return settings[BED_UNIT_STIFFNESS], settings[BED_UNIT_DAMPING]
    share = 0.5 * (parts[i - 1, LENGTH] + parts[i, LENGTH])
    return settings[BED_STIFFNESS] * share, settings[BED_DAMPING] * share


@inner_kernel
def across(vector: Vector, normal: Vector) -> Vector:
    """Return the part of `vector` along the seabed with that `normal`."""
    off = vector[0] * normal[0] + vector[1] * normal[1] + vector[2] * normal[2]
    return vector[0] - off * normal[0], vector[1] - off * normal[1], vector[2] - off * normal[2]


@inner_kernel
def push_of(node: Array, depth: float, normal: Vector, stiffness: float, damping: float) -> float:
    """Return the normal force [N] on a node that is `depth` [m] deep; never negative.

    The ground there has `stiffness` [N/m] and `damping` [N s/m].
    """
    vn = node[VX] * normal[0] + node[VY] * normal[1] + node[VZ] * normal[2]
    return max(stiffness * depth - damping * min(depth / _FIRM_DEPTH, 1.0) * vn, 0.0)


@inner_kernel
def add_contact(i: int, nodes: Array, parts: Array, settings: Array, c_velocity: float, equations: Array) -> bool:
    """Add the seabed's push and friction on node i; return whether it touches."""
    node, out = nodes[i], equations[i]
    depth, m = bottom_under(node, settings)
    if depth <= 0.0:
        return False
    stiffness, damping = ground_of(i, parts, settings)
    push = push_of(node, depth, m, stiffness, damping)
    if push <= 0.0:
        return True
    hard = stiffness + c_velocity * damping * min(depth / _FIRM_DEPTH, 1.0)
    tx, ty, tz = across(
        (
            stiffness * (node[X] - node[HOLD_X]) + damping * node[VX],
            stiffness * (node[Y] - node[HOLD_Y]) + damping * node[VY],
            stiffness * (node[Z] - node[HOLD_Z]) + damping * node[VZ],
        ),
        m,
    )
    size, limit = math.sqrt(tx * tx + ty * ty + tz * tz), settings[BED_FRICTION] * push
    share = 1.0 if size <= limit else limit / size
    out[RX] += share * tx - push * m[0]
    out[RY] += share * ty - push * m[1]
    out[RZ] += share * tz - push * m[2]
    # where it slips, friction turns with the sliding but does not grow along it
    soft = share * (stiffness + c_velocity * damping)
    flat = 0.0 if size <= limit else soft / (size * size)
    hard -= soft
    out[DXX] += soft + hard * m[0] * m[0] - flat * tx * tx
    out[DXY] += hard * m[0] * m[1] - flat * tx * ty
    out[DXZ] += hard * m[0] * m[2] - flat * tx * tz
    out[DYY] += soft + hard * m[1] * m[1] - flat * ty * ty
    out[DYZ] += hard * m[1] * m[2] - flat * ty * tz
    out[DZZ] += soft + hard * m[2] * m[2] - flat * tz * tz
    return True


@inner_kernel
def carry_holds(line: LineArrays, n: int) -> None:
    """Let nodes 0..n-1 take their holds along: those off the seabed at once, those that slip as far as they do."""
    settings = line.settings
    if settings[BED_ON] == 0.0:
        return
    for i in range(n):
        node, reach = line.now[i], 0.0
        depth, m = bottom_under(node, settings)
        if depth > 0.0:
            stiffness, damping = ground_of(i, line.parts, settings)
            reach = settings[BED_FRICTION] * push_of(node, depth, m, stiffness, damping) / stiffness
        held = (node[X] - node[HOLD_X], node[Y] - node[HOLD_Y], node[Z] - node[HOLD_Z])
        along = across(held, m)
        size = math.sqrt(along[0] ** 2 + along[1] ** 2 + along[2] ** 2)
        share = 1.0 if size <= reach else reach / size
        for k in range(3):
            node[HOLD_X + k] = node[X + k] - share * along[k]


@kernel
def hold_here(line: LineArrays, n: int) -> None:
    """Let nodes 0..n hold to where they are."""
    for i in range(n + 1):
        for k in range(3):
            line.now[i, HOLD_X + k] = line.now[i, X + k]


@kernel
def seabed_force_on_unit(line: LineArrays) -> Vector:
    """Return the force of the seabed on the unit [N]."""
    equations = np.zeros((1, EQUATION_COLUMNS))
    add_contact(0, line.now, line.parts, line.settings, 0.0, equations)
    return -equations[0, RX], -equations[0, RY], -equations[0, RZ]
