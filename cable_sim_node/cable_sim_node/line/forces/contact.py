"""The seabed under a node: elastic and damped, with Coulomb friction that sticks and slips.

Normal to the plane that touches it above or below the node: N = k d + c d' while positive, d the depth of penetration.
Along it the node holds to a place h by the same k and c, F = k (x - h) + c v, at most mu N; beyond that it slips at
mu N and takes its hold along, so that k |x - h| is mu N (Coulomb friction as return mapping: Simo & Hughes 1998,
section 1.4). What sticks is therefore at rest for good, within mu N/k of where it came to hold.

Arguments as in `line.assembly`; `place` is a node's position, `normal` the unit vector normal to the seabed there,
upwards. A node above the highest point that the seabed could have there is not looked at further. A deck is level, and
goes up and down with the boom tip: what stands on it is pushed by its speed towards it.
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inlined_kernel, inner_kernel

from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.physics.drag import Vector
from cable_sim_node.physics.seabed import height_and_slope

_FIRM_DEPTH = 0.01
"""Normal damping sets in over this penetration [m]: no jump in force at first touch."""


@inner_kernel
def plane_of(numbers: Array) -> tuple[float, float]:
    """Return z of the plane of the seabed below the origin [m], and how fast that rises [m/s]."""
    follows = numbers[at.BED_FOLLOWS]
    return follows * numbers[at.MIDWAY + at.TIP_Z] - numbers[at.BED_DEPTH], follows * numbers[at.MIDWAY + at.TIP_VZ]


@inner_kernel
def is_clear(place: Vector, numbers: Array) -> bool:
    """Return whether `place` is above the plane of the seabed, raised by the highest point of its profile."""
    plane = numbers[at.BED_SLOPE_X] * place[0] + numbers[at.BED_SLOPE_Y] * place[1] + plane_of(numbers)[0]
    return place[2] > plane + numbers[at.BED_TOP]


@inner_kernel
def bottom_under(place: Vector, numbers: Array) -> tuple[float, Vector]:
    """Return how deep `place` is in the seabed [m], negative above it, and the unit vector normal to it, upwards."""
    sx, sy = numbers[at.BED_SLOPE_X], numbers[at.BED_SLOPE_Y]
    x, y, z = place
    height = sx * x + sy * y + plane_of(numbers)[0]
    rows = int(numbers[at.PROFILE_ROWS])
    if rows > 0:
        along_x, along_y = numbers[at.PROFILE_X], numbers[at.PROFILE_Y]
        hill, slope = height_and_slope(along_x * x + along_y * y, numbers, at.NUMBERS, rows)
        height, sx, sy = height + hill, sx + slope * along_x, sy + slope * along_y
    norm = 1.0 / math.sqrt(1.0 + sx * sx + sy * sy)
    return (height - z) * norm, (-sx * norm, -sy * norm, norm)


@inner_kernel
def ground_of(i: int, tiles: Array, numbers: Array) -> tuple[float, float]:
    """Return stiffness [N/m] and damping [N s/m] of the ground under node i."""
    if i == 0:
        return numbers[at.BED_UNIT_STIFFNESS], numbers[at.BED_UNIT_DAMPING]
    below, above = tiles[(i - 1) >> at.SHIFT], tiles[i >> at.SHIFT]
    share = 0.5 * (below[at.LENGTH + ((i - 1) & at.LANES)] + above[at.LENGTH + (i & at.LANES)])
    return numbers[at.BED_STIFFNESS] * share, numbers[at.BED_DAMPING] * share


@inner_kernel
def across(vector: Vector, normal: Vector) -> Vector:
    """Return the part of `vector` along the seabed with that `normal`."""
    off = vector[0] * normal[0] + vector[1] * normal[1] + vector[2] * normal[2]
    return vector[0] - off * normal[0], vector[1] - off * normal[1], vector[2] - off * normal[2]


@inner_kernel
def push_of(velocity: Vector, depth: float, normal: Vector, stiffness: float, damping: float) -> float:
    """Return the normal force [N] on a node with that `velocity` [m/s] that is `depth` [m] deep; never negative.

    The ground there has `stiffness` [N/m] and `damping` [N s/m].
    """
    vn = velocity[0] * normal[0] + velocity[1] * normal[1] + velocity[2] * normal[2]
    return max(stiffness * depth - damping * min(depth / _FIRM_DEPTH, 1.0) * vn, 0.0)


@inlined_kernel
def add_contacts(line: LineArrays, n: int, c_velocity: float) -> bool:
    """Add the seabed under nodes 0..n-1 to the equations; return whether any touches it."""
    touches = False
    if line.numbers[at.BED_ON] > 0.0:
        for i in range(n):
            touches |= add_contact(line, i, c_velocity)
    return touches


@inner_kernel
def add_contact(line: LineArrays, i: int, c_velocity: float) -> bool:
    """Add the seabed's push and friction on node i; return whether it touches."""
    tile, j, numbers = line.tiles[i >> at.SHIFT], i & at.LANES, line.numbers
    x, y, z = tile[at.MIDDLE + at.X + j], tile[at.MIDDLE + at.Y + j], tile[at.MIDDLE + at.Z + j]
    if is_clear((x, y, z), numbers):
        return False
    depth, m = bottom_under((x, y, z), numbers)
    if depth <= 0.0:
        return False
    stiffness, damping = ground_of(i, line.tiles, numbers)
    vx, vy = tile[at.MIDDLE + at.VX + j], tile[at.MIDDLE + at.VY + j]
    vz = tile[at.MIDDLE + at.VZ + j] - plane_of(numbers)[1]
    push = push_of((vx, vy, vz), depth, m, stiffness, damping)
    if push <= 0.0:
        return True
    hard = stiffness + c_velocity * damping * min(depth / _FIRM_DEPTH, 1.0)
    tx, ty, tz = across(
        (
            stiffness * (x - tile[at.HOLD_X + j]) + damping * vx,
            stiffness * (y - tile[at.HOLD_Y + j]) + damping * vy,
            stiffness * (z - tile[at.HOLD_Z + j]) + damping * vz,
        ),
        m,
    )
    size, limit = math.sqrt(tx * tx + ty * ty + tz * tz), numbers[at.BED_FRICTION] * push
    share = 1.0 if size <= limit else limit / size
    tile[at.RX + j] += share * tx - push * m[0]
    tile[at.RY + j] += share * ty - push * m[1]
    tile[at.RZ + j] += share * tz - push * m[2]
    # where it slips, friction turns with the sliding but does not grow along it
    soft = share * (stiffness + c_velocity * damping)
    flat = 0.0 if size <= limit else soft / (size * size)
    hard -= soft
    tile[at.DXX + j] += soft + hard * m[0] * m[0] - flat * tx * tx
    tile[at.DXY + j] += hard * m[0] * m[1] - flat * tx * ty
    tile[at.DXZ + j] += hard * m[0] * m[2] - flat * tx * tz
    tile[at.DYY + j] += soft + hard * m[1] * m[1] - flat * ty * ty
    tile[at.DYZ + j] += hard * m[1] * m[2] - flat * ty * tz
    tile[at.DZZ + j] += soft + hard * m[2] * m[2] - flat * tz * tz
    return True


@inner_kernel
def carry_holds(line: LineArrays, n: int) -> None:
    """Let nodes 0..n-1 take their holds along: those off the seabed at once, those that slip as far as they do."""
    numbers = line.numbers
    if numbers[at.BED_ON] == 0.0:
        return
    for i in range(n):
        tile, j = line.tiles[i >> at.SHIFT], i & at.LANES
        x, y, z = tile[at.X + j], tile[at.Y + j], tile[at.Z + j]
        along, share = (0.0, 0.0, 0.0), 0.0
        if not is_clear((x, y, z), numbers):
            depth, m = bottom_under((x, y, z), numbers)
            reach = 0.0
            if depth > 0.0:
                stiffness, damping = ground_of(i, line.tiles, numbers)
                velocity = (tile[at.VX + j], tile[at.VY + j], tile[at.VZ + j] - plane_of(numbers)[1])
                reach = numbers[at.BED_FRICTION] * push_of(velocity, depth, m, stiffness, damping) / stiffness
            along = across((x - tile[at.HOLD_X + j], y - tile[at.HOLD_Y + j], z - tile[at.HOLD_Z + j]), m)
            size = math.sqrt(along[0] ** 2 + along[1] ** 2 + along[2] ** 2)
            share = 1.0 if size <= reach else reach / size
        tile[at.HOLD_X + j] = x - share * along[0]
        tile[at.HOLD_Y + j] = y - share * along[1]
        tile[at.HOLD_Z + j] = z - share * along[2]


@inner_kernel
def seabed_force_on_unit(line: LineArrays) -> float:
    """Return the vertical force of the seabed on the unit [N], positive up; its equations are used up.

    The middle state is the present one.
    """
    tile = line.tiles[0]
    tile[at.RX] = tile[at.RY] = tile[at.RZ] = 0.0
    add_contact(line, 0, 0.0)
    return float(-tile[at.RZ])
