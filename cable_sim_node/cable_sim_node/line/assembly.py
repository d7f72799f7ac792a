"""Equations of motion of the lumped line: residual and symmetric block-tridiagonal Jacobian (thesis Eq. 5.1-5.6).

Node 0 is the unit, node n the sheave (boom tip); segment i joins nodes i and i + 1. Blocks are symmetric 3 x 3, stored
as xx, xy, xz, yy, yz, zz. The top segment changes its length L' at the sheave, where material passes: with q = (x_n -
x_{n-1})/l, material at the sheave has velocity x_n' - L' q and acceleration x_n'' - L'' q - 2 L' q'.

Arguments have the same names everywhere: `n` segments in use, `nodes`, `parts`, `unit`, `flow`, `settings` and
`equations` the arrays of `LineArrays` (`nodes` now or at the middle of a step), `top` a row of its top. The Jacobian is
that of the residual by a node's position if its velocity moves by `c_velocity` [1/s] and its acceleration by `c_mass`
[1/s^2] times as much.
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel

from cable_sim_node.line.contact import add_contact
from cable_sim_node.line.direction import direction_of
from cable_sim_node.line.layout import (
    ACCELERATION,
    ADDED_MASS,
    AX,
    AY,
    AZ,
    BED_ON,
    CUBIC,
    CX,
    CY,
    CZ,
    DAMPING,
    DISPLACED,
    DXX,
    DXY,
    DXZ,
    DYY,
    DYZ,
    DZZ,
    FLOW_AX,
    FLOW_AY,
    FLOW_AZ,
    FLOW_X,
    FLOW_Y,
    FLOW_Z,
    LENGTH,
    LUMP_ADDED_MASS,
    LUMP_DISPLACED,
    LUMP_DRAG,
    LUMP_MASS,
    LUMP_WEIGHT,
    MASS,
    NORMAL_DRAG,
    QUADRATIC,
    RATE,
    RX,
    RY,
    RZ,
    SPRING_DAMPING,
    SPRING_HALF_STROKE,
    SPRING_MASS,
    SPRING_PRELOAD,
    SPRING_STIFFNESS,
    SPRING_STOP,
    SPRING_STOP_DAMPING,
    STIFFNESS,
    SWEEP,
    TANGENTIAL_DRAG,
    TENSION,
    UNIT_BODY_DRAG,
    UNIT_DRAG,
    UNIT_FLUID,
    UNIT_FORCE,
    UNIT_INERTIA,
    UXX,
    UXY,
    UXZ,
    UYY,
    UYZ,
    UZZ,
    VX,
    VY,
    VZ,
    WAVE_AMPLITUDE,
    WEIGHT,
    X,
    Y,
    Z,
)
from cable_sim_node.physics.drag import Vector, drag_force, resolve
from cable_sim_node.physics.tension_law import stiffening, tangent_stiffness

Block = tuple[float, float, float, float, float, float]


@inner_kernel
def tension_of(
    stiffness: float, q: float, c: float, damping: float, strain: float, strain_rate: float
) -> tuple[float, float, float]:
    """Return tension [N], its derivative by strain and by strain rate.

    Parameters
    ----------
    stiffness, q, c : of the tension law, see `physics.tension_law`
    damping : internal damping [N s]
    strain, strain_rate : [-], [1/s]

    A slack segment carries none. Internal damping adds T_e r/sqrt(1 + r^2) to the elastic tension T_e, with r the
    damping force over T_e: it stays below T_e and so never pushes, and a line that comes taut meets no step in force.
    """
    if strain <= 0.0:
        return 0.0, 0.0, 0.0
    elastic = stiffness * strain * stiffening(q, c, strain)
    slope = tangent_stiffness(stiffness, q, c, strain)
    if damping == 0.0:
        return elastic, slope, 0.0
    ratio = damping * strain_rate / elastic
    root = math.sqrt(1.0 + ratio * ratio)
    cosine = 1.0 / root
    sine = ratio * cosine
    return elastic * (1.0 + sine), slope * (1.0 + sine**3), damping * cosine**3


@inner_kernel
def rank_one(a: float, b: float, x: float, y: float, z: float) -> Block:
    """Return the block a I + b w w' with w = (x, y, z)."""
    return a + b * x * x, b * x * y, b * x * z, a + b * y * y, b * y * z, a + b * z * z


@inner_kernel
def add_blocks(p: Block, q: Block) -> Block:
    """Return p + q."""
    return p[0] + q[0], p[1] + q[1], p[2] + q[2], p[3] + q[3], p[4] + q[4], p[5] + q[5]


@inner_kernel
def times(m: Block, x: float, y: float, z: float) -> Vector:
    """Return the block `m` times the vector (x, y, z)."""
    return m[0] * x + m[1] * y + m[2] * z, m[1] * x + m[3] * y + m[4] * z, m[2] * x + m[4] * y + m[5] * z


@inner_kernel
def drag_of(normal: float, tangential: float, e: Vector, ux: float, uy: float, uz: float) -> tuple[Vector, Block]:
    """Return half the drag [N] on a segment along `e` that moves with (ux, uy, uz) through the water, and
    d(drag)/d(velocity) / 4.

    `normal` and `tangential` are the factors of `physics.drag` times the segment's length. The sign is that of the
    motion, the force on the segment the opposite.
    """
    slip, n, speed = resolve(e, ux, uy, uz)
    half = drag_force(0.5 * normal, 0.5 * tangential, e, slip, n, speed)
    across, along = 0.5 * normal * speed, 0.5 * tangential * abs(slip)
    slope = add_blocks(
        rank_one(0.5 * across, along - 0.5 * across, e[0], e[1], e[2]),
        rank_one(0.0, 0.25 * normal / (speed + 1e-12), n[0], n[1], n[2]),
    )
    return half, slope


@inner_kernel
def sheave_material(
    dx: float, v_top: float, a_top: float, v_low: float, length: float, rate: float, acceleration: float
) -> tuple[float, float]:
    """Return velocity and acceleration of the material at the sheave along one axis (see the text of the module).

    Parameters
    ----------
    dx : from the top segment's lower end to the sheave [m]
    v_top, a_top : of the sheave [m/s], [m/s^2]
    v_low : velocity of the segment's lower end [m/s]
    length, rate, acceleration : unstretched length of the segment and its changes [m], [m/s], [m/s^2]
    """
    q = dx / length
    velocity = v_top - rate * q
    return velocity, a_top - acceleration * q - 2.0 * rate * (velocity - v_low) / length


@inner_kernel
def assemble_segments(
    n: int,
    nodes: Array,
    top: Array,
    parts: Array,
    flow: Array,
    settings: Array,
    c_mass: float,
    c_velocity: float,
    equations: Array,
) -> float:
    """Add all segments to the residual R = M a - F and its Jacobian; return the least strain.

    Rows 0..n of the diagonal blocks and the residual, rows 0..n-1 of the upper blocks and the tensions [N] are
    overwritten. What drag and added mass owe to the turning of a segment is left out of the Jacobian (not of the
    residual): both are small beside inertia, and the blocks stay symmetric.
    """
    least, r0, r1, r2 = 1e300, 0.0, 0.0, 0.0
    below = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    waves = settings[WAVE_AMPLITUDE] > 0.0
    for i in range(n):
        part, low, high, water, out = parts[i], nodes[i], nodes[i + 1], flow[i + 1], equations[i]
        length = part[LENGTH]
        ex, ey, ez = high[X] - low[X], high[Y] - low[Y], high[Z] - low[Z]
        wx, wy, wz = high[VX], high[VY], high[VZ]
        gx, gy, gz = high[AX], high[AY], high[AZ]
        if i == n - 1:
            wx, gx = sheave_material(ex, wx, gx, low[VX], length, top[RATE], top[ACCELERATION])
            wy, gy = sheave_material(ey, wy, gy, low[VY], length, top[RATE], top[ACCELERATION])
            wz, gz = sheave_material(ez, wz, gz, low[VZ], length, top[RATE], top[ACCELERATION])
        stretched = math.sqrt(ex * ex + ey * ey + ez * ez)
        inverse, per_length = 1.0 / (stretched + 1e-300), 1.0 / length
        strain = stretched * per_length - 1.0
        least = min(least, strain)
        # of a folded segment, which has no direction of its own, the smooth one; it carries no tension
        size = per_length * direction_of(stretched * per_length)[0] if strain < 0.0 else inverse
        ex, ey, ez = ex * size, ey * size, ez * size
        strain_rate = (ex * (wx - low[VX]) + ey * (wy - low[VY]) + ez * (wz - low[VZ])) * per_length
        tension, slope, viscous = tension_of(
            part[STIFFNESS], part[QUADRATIC], part[CUBIC], part[DAMPING], strain, strain_rate
        )
        out[TENSION] = tension
        # the segment moves through the water at the mean velocity of its ends; each end takes half of its drag, weight
        # and mass
        ux = 0.5 * (low[VX] + wx) - water[FLOW_X]
        uy = 0.5 * (low[VY] + wy) - water[FLOW_Y]
        uz = 0.5 * (low[VZ] + wz) - water[FLOW_Z]
        (hx, hy, hz), b = drag_of(part[NORMAL_DRAG] * length, part[TANGENTIAL_DRAG] * length, (ex, ey, ez), ux, uy, uz)
        hz += 0.5 * part[WEIGHT] * length
        added = 0.5 * part[ADDED_MASS] * length
        m = rank_one(0.5 * part[MASS] * length + added, -added, ex, ey, ez)
        if waves:
            moved = 0.5 * part[DISPLACED] * length + added
            px, py, pz = times(rank_one(moved, -added, ex, ey, ez), water[FLOW_AX], water[FLOW_AY], water[FLOW_AZ])
            hx, hy, hz = hx - px, hy - py, hz - pz
        across = tension * inverse
        c = c_velocity
        k = rank_one(across, (slope + c * viscous) * per_length - across, ex, ey, ez)
        out[UXX], out[UXY], out[UXZ] = c * b[0] - k[0], c * b[1] - k[1], c * b[2] - k[2]
        out[UYY], out[UYZ], out[UZZ] = c * b[3] - k[3], c * b[4] - k[4], c * b[5] - k[5]
        own = (
            c * b[0] + k[0] + c_mass * m[0],
            c * b[1] + k[1] + c_mass * m[1],
            c * b[2] + k[2] + c_mass * m[2],
            c * b[3] + k[3] + c_mass * m[3],
            c * b[4] + k[4] + c_mass * m[4],
            c * b[5] + k[5] + c_mass * m[5],
        )
        out[DXX], out[DXY], out[DXZ], out[DYY], out[DYZ], out[DZZ] = add_blocks(below, own)
        px, py, pz = times(m, low[AX], low[AY], low[AZ])
        out[RX] = r0 + px + hx - tension * ex
        out[RY] = r1 + py + hy - tension * ey
        out[RZ] = r2 + pz + hz - tension * ez
        px, py, pz = times(m, gx, gy, gz)
        r0, r1, r2 = px + hx + tension * ex, py + hy + tension * ey, pz + hz + tension * ez
        below = own
    out = equations[n]
    out[DXX], out[DXY], out[DXZ], out[DYY], out[DYZ], out[DZZ] = below
    out[RX], out[RY], out[RZ] = r0, r1, r2
    return least


@inner_kernel
def assemble_nodes(
    n: int,
    nodes: Array,
    parts: Array,
    unit: Array,
    flow: Array,
    settings: Array,
    c_mass: float,
    c_velocity: float,
    equations: Array,
) -> bool:
    """Add unit, lumps and seabed to the residual and the Jacobian; return whether anything touches the seabed.

    The unit's drag works along each axis by itself (thesis 5.2.2): (1/2) rho C_Dx S_x abs(u_x) u_x, and so on; that of
    an isotropic unit is (1/2) rho C_D S abs(u) u.
    """
    speed = 0.0
    for k in range(3):
        speed += (nodes[0, VX + k] - flow[0, FLOW_X + k]) ** 2
    body_drag = unit[UNIT_BODY_DRAG] * math.sqrt(speed)
    for k in range(3):
        u = nodes[0, VX + k] - flow[0, FLOW_X + k]
        drag = unit[UNIT_DRAG + k] * abs(u) + body_drag
        equations[0, RX + k] += unit[UNIT_INERTIA + k] * nodes[0, AX + k] + drag * u - unit[UNIT_FORCE + k]
        equations[0, RX + k] -= unit[UNIT_FLUID + k] * flow[0, FLOW_AX + k]
        entry = DXX if k == 0 else (DYY if k == 1 else DZZ)
        equations[0, entry] += c_mass * unit[UNIT_INERTIA + k] + c_velocity * 2.0 * drag
    for i in range(1, n + 1):
        lump = parts[i]
        inertia = lump[LUMP_MASS] + lump[LUMP_ADDED_MASS]
        if inertia == 0.0 and lump[LUMP_DRAG] == 0.0:
            continue
        node, water, out = nodes[i], flow[i], equations[i]
        fluid = lump[LUMP_DISPLACED] + lump[LUMP_ADDED_MASS]
        ux, uy, uz = node[VX] - water[FLOW_X], node[VY] - water[FLOW_Y], node[VZ] - water[FLOW_Z]
        drag = lump[LUMP_DRAG] * math.sqrt(ux * ux + uy * uy + uz * uz)
        out[RX] += inertia * node[AX] + drag * ux - fluid * water[FLOW_AX]
        out[RY] += inertia * node[AY] + drag * uy - fluid * water[FLOW_AY]
        out[RZ] += inertia * node[AZ] + drag * uz - fluid * water[FLOW_AZ] + lump[LUMP_WEIGHT]
        # the derivative lies between drag and 2 drag in all directions: the upper bound keeps the correction short
        added = c_mass * inertia + 2.0 * c_velocity * drag
        out[DXX] += added
        out[DYY] += added
        out[DZZ] += added
    touching = False
    if settings[BED_ON] > 0.0:
        for i in range(n):
            touching |= add_contact(i, nodes, parts, settings, c_velocity, equations)
    return touching


@inner_kernel
def add_compensator(node: Array, top: Array, settings: Array, c_mass: float, c_velocity: float, out: Array) -> bool:
    """Make `node` the sheave on a passive compensator, free along z only; `top` is a row, `out` the node's equations.

    Stroke s = z_tip - z_n, upward force on the sheave F0 + k s + c s', beyond the half stroke stiffened by the stops.
    The preload F0 carries the moving mass as well, so that the static stroke is 0 where F0 is the static top
    tension. Returns whether a stop is near.
    """
    stroke = top[Z] - node[Z]
    speed = top[VZ] - node[VZ]
    force = settings[SPRING_PRELOAD] + settings[SPRING_STIFFNESS] * stroke + settings[SPRING_DAMPING] * speed
    stiffness = settings[SPRING_STIFFNESS] + c_velocity * settings[SPRING_DAMPING]
    over = abs(stroke) - settings[SPRING_HALF_STROKE]
    if over > 0.0:
        side = math.copysign(1.0, stroke)
        push = settings[SPRING_STOP] * over + settings[SPRING_STOP_DAMPING] * side * speed
        if push > 0.0:
            force += side * push
            stiffness += settings[SPRING_STOP] + c_velocity * settings[SPRING_STOP_DAMPING]
    out[RX] = 0.0
    out[RY] = 0.0
    out[RZ] += settings[SPRING_MASS] * node[AZ] - force
    out[DZZ] += c_mass * settings[SPRING_MASS] + stiffness
    out[DXX] = out[DYY] = 1e30
    out[DXY] = out[DXZ] = out[DYZ] = 0.0
    return over > -0.1 * settings[SPRING_HALF_STROKE]


@inner_kernel
def solve_blocks(count: int, equations: Array) -> float:
    """Solve the symmetric block-tridiagonal system J correction = -residual for rows 0..count-1 by block elimination.

    Diagonal blocks and residuals in `equations` are used up. The correction of row `count` must be what is prescribed
    there. Returns -residual . correction, from the products that the elimination makes; it is positive where J is
    positive definite.
    """
    decrease = 0.0
    for i in range(count):
        row, above = equations[i], equations[i + 1]
        a0, a1, a2, a3, a4, a5 = row[DXX], row[DXY], row[DXZ], row[DYY], row[DYZ], row[DZZ]
        c0 = a3 * a5 - a4 * a4
        c1 = a2 * a4 - a1 * a5
        c2 = a1 * a4 - a2 * a3
        scale = 1.0 / (a0 * c0 + a1 * c1 + a2 * c2)
        i0, i1, i2 = c0 * scale, c1 * scale, c2 * scale
        i3 = (a0 * a5 - a2 * a2) * scale
        i4 = (a1 * a2 - a0 * a4) * scale
        i5 = (a0 * a3 - a1 * a1) * scale
        r0, r1, r2 = -row[RX], -row[RY], -row[RZ]
        y0 = i0 * r0 + i1 * r1 + i2 * r2
        y1 = i1 * r0 + i3 * r1 + i4 * r2
        y2 = i2 * r0 + i4 * r1 + i5 * r2
        row[CX], row[CY], row[CZ] = y0, y1, y2
        decrease += r0 * y0 + r1 * y1 + r2 * y2
        if i == count - 1:
            break
        u0, u1, u2, u3, u4, u5 = row[UXX], row[UXY], row[UXZ], row[UYY], row[UYZ], row[UZZ]
        w00 = i0 * u0 + i1 * u1 + i2 * u2
        w01 = i0 * u1 + i1 * u3 + i2 * u4
        w02 = i0 * u2 + i1 * u4 + i2 * u5
        w10 = i1 * u0 + i3 * u1 + i4 * u2
        w11 = i1 * u1 + i3 * u3 + i4 * u4
        w12 = i1 * u2 + i3 * u4 + i4 * u5
        w20 = i2 * u0 + i4 * u1 + i5 * u2
        w21 = i2 * u1 + i4 * u3 + i5 * u4
        w22 = i2 * u2 + i4 * u4 + i5 * u5
        row[SWEEP], row[SWEEP + 1], row[SWEEP + 2] = w00, w01, w02
        row[SWEEP + 3], row[SWEEP + 4], row[SWEEP + 5] = w10, w11, w12
        row[SWEEP + 6], row[SWEEP + 7], row[SWEEP + 8] = w20, w21, w22
        above[DXX] -= u0 * w00 + u1 * w10 + u2 * w20
        above[DXY] -= u0 * w01 + u1 * w11 + u2 * w21
        above[DXZ] -= u0 * w02 + u1 * w12 + u2 * w22
        above[DYY] -= u1 * w01 + u3 * w11 + u4 * w21
        above[DYZ] -= u1 * w02 + u3 * w12 + u4 * w22
        above[DZZ] -= u2 * w02 + u4 * w12 + u5 * w22
        above[RX] += u0 * y0 + u1 * y1 + u2 * y2
        above[RY] += u1 * y0 + u3 * y1 + u4 * y2
        above[RZ] += u2 * y0 + u4 * y1 + u5 * y2
    for i in range(count - 2, -1, -1):
        row, above = equations[i], equations[i + 1]
        z0, z1, z2 = above[CX], above[CY], above[CZ]
        row[CX] -= row[SWEEP] * z0 + row[SWEEP + 1] * z1 + row[SWEEP + 2] * z2
        row[CY] -= row[SWEEP + 3] * z0 + row[SWEEP + 4] * z1 + row[SWEEP + 5] * z2
        row[CZ] -= row[SWEEP + 6] * z0 + row[SWEEP + 7] * z1 + row[SWEEP + 8] * z2
    return decrease
