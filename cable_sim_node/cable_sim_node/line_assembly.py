"""Equations of motion of the lumped line: residual and symmetric block-tridiagonal Jacobian (thesis Eq. 5.1-5.6).

Node 0 is the unit, node n the sheave (boom tip); segment i joins nodes i and i + 1. Blocks are symmetric 3 x 3, stored
as xx, xy, xz, yy, yz, zz. The top segment changes its length L' at the sheave, where material passes: with q = (x_n -
x_{n-1})/l, material at the sheave has velocity x_n' - L' q and acceleration x_n'' - L'' q - 2 L' q'.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cable_sim_node.compiled import inner_kernel, kernel
from cable_sim_node.line_layout import (
    ACCELERATION,
    ADDED_MASS,
    BED_DAMPING,
    BED_DEPTH,
    BED_FRICTION,
    BED_ON,
    BED_SLIP,
    BED_SLOPE_X,
    BED_SLOPE_Y,
    BED_STIFFNESS,
    BED_UNIT_DAMPING,
    BED_UNIT_STIFFNESS,
    CUBIC,
    DAMPING,
    DISPLACED,
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
    SPRING_DAMPING,
    SPRING_HALF_STROKE,
    SPRING_MASS,
    SPRING_ON,
    SPRING_PRELOAD,
    SPRING_STIFFNESS,
    SPRING_STOP,
    SPRING_STOP_DAMPING,
    STIFFNESS,
    TANGENTIAL_DRAG,
    UNIT_DRAG,
    UNIT_FLUID,
    UNIT_FORCE,
    UNIT_INERTIA,
    WAVE_AMPLITUDE,
    WEIGHT,
)

Array = NDArray[np.float64]
Vector = tuple[float, float, float]
Block = tuple[float, float, float, float, float, float]


@kernel
def tension_of(
    stiffness: float, q: float, c: float, damping: float, strain: float, strain_rate: float
) -> tuple[float, float, float]:
    """Return tension [N], its derivative to strain and to strain rate.

    A slack segment carries none. Damping r T_e grows as r/sqrt(1 + r^2) and so stays below the elastic tension
    T_e: it never pushes, and a line that comes
    taut meets no step in force.
    """
    if strain <= 0.0:
        return 0.0, 0.0, 0.0
    elastic = stiffness * strain * (1.0 + strain * (q + c * strain))
    slope = stiffness * (1.0 + strain * (2.0 * q + 3.0 * c * strain))
    if damping == 0.0:
        return elastic, slope, 0.0
    ratio = damping * strain_rate / elastic
    root = math.sqrt(1.0 + ratio * ratio)
    cosine = 1.0 / root
    sine = ratio * cosine
    return elastic * (1.0 + sine), slope * (1.0 + sine**3), damping * cosine**3


@kernel
def rank_one(a: float, b: float, x: float, y: float, z: float) -> Block:
    """Return the block a I + b w w' with w = (x, y, z)."""
    return a + b * x * x, b * x * y, b * x * z, a + b * y * y, b * y * z, a + b * z * z


@kernel
def add_blocks(p: Block, q: Block) -> Block:
    """Return p + q."""
    return p[0] + q[0], p[1] + q[1], p[2] + q[2], p[3] + q[3], p[4] + q[4], p[5] + q[5]


@kernel
def times(m: Block, x: float, y: float, z: float) -> Vector:
    """Return the block times a vector."""
    return m[0] * x + m[1] * y + m[2] * z, m[1] * x + m[3] * y + m[4] * z, m[2] * x + m[4] * y + m[5] * z


@kernel
def put_block(target: Array, i: int, m: Block) -> None:
    """Write a block into row i."""
    target[i, 0], target[i, 1], target[i, 2] = m[0], m[1], m[2]
    target[i, 3], target[i, 4], target[i, 5] = m[3], m[4], m[5]


@kernel
def drag_of(normal: float, tangential: float, e: Vector, ux: float, uy: float, uz: float) -> tuple[Vector, Block]:
    """Return half the drag [N] on a segment along `e` that moves with (ux, uy, uz) through the water, and
    d(drag)/d(velocity) / 4.

    `normal` = (1/2) rho C_N d l, `tangential` = (pi/2) rho C_tau d l: normal abs(u_n) u_n across, tangential
    abs(u_t) u_t along. The sign is that of the motion, the force on the segment the opposite.
    """
    ut = ux * e[0] + uy * e[1] + uz * e[2]
    nx, ny, nz = ux - ut * e[0], uy - ut * e[1], uz - ut * e[2]
    speed = math.sqrt(nx * nx + ny * ny + nz * nz)
    across = 0.5 * normal * speed
    slip = 0.5 * tangential * abs(ut)
    along = slip * ut
    half = (across * nx + along * e[0], across * ny + along * e[1], across * nz + along * e[2])
    slope = add_blocks(
        rank_one(0.5 * across, slip - 0.5 * across, e[0], e[1], e[2]),
        rank_one(0.0, 0.25 * normal / (speed + 1e-12), nx, ny, nz),
    )
    return half, slope


@kernel
def sheave_material(
    dx: float, v_top: float, a_top: float, v_low: float, length: float, rate: float, acceleration: float
) -> tuple[float, float]:
    """Return velocity and acceleration of the material at the sheave along one axis (see the module's text)."""
    q = dx / length
    velocity = v_top - rate * q
    return velocity, a_top - acceleration * q - 2.0 * rate * (velocity - v_low) / length


@inner_kernel
def assemble_segments(
    n: int,
    x: Array,
    v: Array,
    a: Array,
    seg: Array,
    flow: Array,
    flow_acceleration: Array,
    moving: Array,
    settings: Array,
    c_mass: float,
    c_velocity: float,
    diagonal: Array,
    upper: Array,
    residual: Array,
    tensions: Array,
) -> float:
    """Add all segments to residual R = M a - F and Jacobian c_mass M - c_velocity dF/dv - dF/dx; return the least
    strain.

    Rows 0..n of `diagonal` (6), `residual` (3), rows 0..n-1 of `upper` (6) and `tensions` [N] are overwritten.
    `flow[i + 1]`
    and `flow_acceleration[i + 1]` are the water's motion at segment i. What the drag and the added mass owe to
    the turning of
    a segment is left out of the Jacobian (not of the residual): both are small beside inertia, and the blocks
    stay symmetric.
    """
    least = 1e300
    below = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    r0 = r1 = r2 = 0.0
    waves = settings[WAVE_AMPLITUDE] > 0.0
    for i in range(n):
        row = seg[i]
        length = row[LENGTH]
        ex, ey, ez = x[i + 1, 0] - x[i, 0], x[i + 1, 1] - x[i, 1], x[i + 1, 2] - x[i, 2]
        wx, wy, wz = v[i + 1, 0], v[i + 1, 1], v[i + 1, 2]
        gx, gy, gz = a[i + 1, 0], a[i + 1, 1], a[i + 1, 2]
        if i == n - 1:
            wx, gx = sheave_material(ex, wx, gx, v[i, 0], length, moving[RATE], moving[ACCELERATION])
            wy, gy = sheave_material(ey, wy, gy, v[i, 1], length, moving[RATE], moving[ACCELERATION])
            wz, gz = sheave_material(ez, wz, gz, v[i, 2], length, moving[RATE], moving[ACCELERATION])
        stretched = math.sqrt(ex * ex + ey * ey + ez * ez)
        inverse = 1.0 / (stretched + 1e-300)
        ex, ey, ez = ex * inverse, ey * inverse, ez * inverse
        per_length = 1.0 / length
        strain = stretched * per_length - 1.0
        least = min(least, strain)
        strain_rate = (ex * (wx - v[i, 0]) + ey * (wy - v[i, 1]) + ez * (wz - v[i, 2])) * per_length
        tension, slope, viscous = tension_of(
            row[STIFFNESS], row[QUADRATIC], row[CUBIC], row[DAMPING], strain, strain_rate
        )
        tensions[i] = tension
        # the segment moves through the water with the mean of its ends; half its drag, weight and mass goes to each
        # of them
        ux = 0.5 * (v[i, 0] + wx) - flow[i + 1, 0]
        uy = 0.5 * (v[i, 1] + wy) - flow[i + 1, 1]
        uz = 0.5 * (v[i, 2] + wz) - flow[i + 1, 2]
        (hx, hy, hz), damping = drag_of(
            row[NORMAL_DRAG] * length, row[TANGENTIAL_DRAG] * length, (ex, ey, ez), ux, uy, uz
        )
        hz += 0.5 * row[WEIGHT] * length
        added = 0.5 * row[ADDED_MASS] * length
        mass = rank_one(0.5 * row[MASS] * length + added, -added, ex, ey, ez)
        if waves:
            fx, fy, fz = flow_acceleration[i + 1, 0], flow_acceleration[i + 1, 1], flow_acceleration[i + 1, 2]
            px, py, pz = times(rank_one(0.5 * row[DISPLACED] * length + added, -added, ex, ey, ez), fx, fy, fz)
            hx, hy, hz = hx - px, hy - py, hz - pz
        across = tension * inverse
        stiffness = rank_one(across, (slope + c_velocity * viscous) * per_length - across, ex, ey, ez)
        b, k, m = damping, stiffness, mass
        c = c_velocity
        put_block(
            upper,
            i,
            (c * b[0] - k[0], c * b[1] - k[1], c * b[2] - k[2], c * b[3] - k[3], c * b[4] - k[4], c * b[5] - k[5]),
        )
        own = (
            c * b[0] + k[0] + c_mass * m[0],
            c * b[1] + k[1] + c_mass * m[1],
            c * b[2] + k[2] + c_mass * m[2],
            c * b[3] + k[3] + c_mass * m[3],
            c * b[4] + k[4] + c_mass * m[4],
            c * b[5] + k[5] + c_mass * m[5],
        )
        put_block(diagonal, i, add_blocks(below, own))
        px, py, pz = times(mass, a[i, 0], a[i, 1], a[i, 2])
        residual[i, 0] = r0 + px + hx - tension * ex
        residual[i, 1] = r1 + py + hy - tension * ey
        residual[i, 2] = r2 + pz + hz - tension * ez
        px, py, pz = times(mass, gx, gy, gz)
        r0, r1, r2 = px + hx + tension * ex, py + hy + tension * ey, pz + hz + tension * ez
        below = own
    put_block(diagonal, n, below)
    residual[n, 0], residual[n, 1], residual[n, 2] = r0, r1, r2
    return least


@inner_kernel
def assemble_nodes(
    n: int,
    x: Array,
    v: Array,
    a: Array,
    seg: Array,
    lump: Array,
    unit: Array,
    flow: Array,
    flow_acceleration: Array,
    settings: Array,
    c_mass: float,
    c_velocity: float,
    diagonal: Array,
    residual: Array,
) -> bool:
    """Add unit, lumps and seabed to the residual and the Jacobian; return whether anything touches the seabed.

    The unit's drag works along each axis by itself (thesis 5.2.2): (1/2) rho C_Dx S_x abs(u_x) u_x, and so on.
    """
    for k in range(3):
        u = v[0, k] - flow[0, k]
        residual[0, k] += unit[UNIT_INERTIA + k] * a[0, k] + unit[UNIT_DRAG + k] * abs(u) * u - unit[UNIT_FORCE + k]
        residual[0, k] -= unit[UNIT_FLUID + k] * flow_acceleration[0, k]
        entry = 0 if k == 0 else (3 if k == 1 else 5)
        diagonal[0, entry] += c_mass * unit[UNIT_INERTIA + k] + c_velocity * 2.0 * unit[UNIT_DRAG + k] * abs(u)
    for i in range(1, n + 1):
        inertia = lump[i, LUMP_MASS] + lump[i, LUMP_ADDED_MASS]
        if inertia == 0.0 and lump[i, LUMP_DRAG] == 0.0:
            continue
        fluid = lump[i, LUMP_DISPLACED] + lump[i, LUMP_ADDED_MASS]
        ux, uy, uz = v[i, 0] - flow[i, 0], v[i, 1] - flow[i, 1], v[i, 2] - flow[i, 2]
        drag = lump[i, LUMP_DRAG] * math.sqrt(ux * ux + uy * uy + uz * uz)
        residual[i, 0] += inertia * a[i, 0] + drag * ux - fluid * flow_acceleration[i, 0]
        residual[i, 1] += inertia * a[i, 1] + drag * uy - fluid * flow_acceleration[i, 1]
        residual[i, 2] += inertia * a[i, 2] + drag * uz - fluid * flow_acceleration[i, 2] + lump[i, LUMP_WEIGHT]
        # the full derivative lies between drag and 2 drag: an upper bound keeps the correction short
        added = c_mass * inertia + 2.0 * c_velocity * drag
        diagonal[i, 0] += added
        diagonal[i, 3] += added
        diagonal[i, 5] += added
    touching = False
    if settings[BED_ON] > 0.0:
        for i in range(n):
            touching |= add_contact(i, x, v, seg, settings, c_velocity, diagonal, residual)
    return touching


@kernel
def add_contact(
    i: int, x: Array, v: Array, seg: Array, settings: Array, c_velocity: float, diagonal: Array, residual: Array
) -> bool:
    """Add the seabed's push and friction on node i; return whether it touches.

    Normal to the plane z = -depth + slope . (x, y): N = k d + c d' while positive, d the depth of penetration.
    Friction mu N tanh(v_t / v_s) against the sliding velocity.
    """
    sx, sy = settings[BED_SLOPE_X], settings[BED_SLOPE_Y]
    norm = 1.0 / math.sqrt(1.0 + sx * sx + sy * sy)
    depth = (-settings[BED_DEPTH] + sx * x[i, 0] + sy * x[i, 1] - x[i, 2]) * norm
    if depth <= 0.0:
        return False
    if i == 0:
        stiffness, damping = settings[BED_UNIT_STIFFNESS], settings[BED_UNIT_DAMPING]
    else:
        share = 0.5 * (seg[i - 1, LENGTH] + seg[i, LENGTH])
        stiffness, damping = settings[BED_STIFFNESS] * share, settings[BED_DAMPING] * share
    mx, my, mz = -sx * norm, -sy * norm, norm
    vn = v[i, 0] * mx + v[i, 1] * my + v[i, 2] * mz
    # damping grows in with the penetration over 1 cm: no jump in force at first touch
    grown = min(depth / 0.01, 1.0)
    push = stiffness * depth - damping * grown * vn
    if push <= 0.0:
        return True
    tx, ty, tz = v[i, 0] - vn * mx, v[i, 1] - vn * my, v[i, 2] - vn * mz
    speed = math.sqrt(tx * tx + ty * ty + tz * tz)
    ratio = speed / settings[BED_SLIP]
    # tanh(r)/r is 1 at rest
    per_speed = settings[BED_FRICTION] * push / settings[BED_SLIP] * (math.tanh(ratio) / ratio if ratio > 1e-6 else 1.0)
    residual[i, 0] += per_speed * tx - push * mx
    residual[i, 1] += per_speed * ty - push * my
    residual[i, 2] += per_speed * tz - push * mz
    hard = stiffness + c_velocity * damping * grown
    soft = c_velocity * per_speed
    diagonal[i, 0] += soft + (hard - soft) * mx * mx
    diagonal[i, 1] += (hard - soft) * mx * my
    diagonal[i, 2] += (hard - soft) * mx * mz
    diagonal[i, 3] += soft + (hard - soft) * my * my
    diagonal[i, 4] += (hard - soft) * my * mz
    diagonal[i, 5] += soft + (hard - soft) * mz * mz
    return True


@inner_kernel
def add_compensator(
    n: int,
    x: Array,
    v: Array,
    a: Array,
    tip: Array,
    settings: Array,
    c_mass: float,
    c_velocity: float,
    diagonal: Array,
    residual: Array,
) -> bool:
    """Make node n the sheave on a passive compensator, free along z only; `tip` is position and velocity of the boom
    tip, shape (2, 3).

    Stroke s = z_tip - z_n, upward force on the sheave F0 + k s + c s', beyond the half stroke stiffened by the stops.
    The preload F0 carries the moving mass as well, so that the static stroke is 0 where F0 is the static top
    tension. Returns whether a
    stop is near.
    """
    if settings[SPRING_ON] == 0.0:
        return False
    stroke = tip[0, 2] - x[n, 2]
    speed = tip[1, 2] - v[n, 2]
    force = settings[SPRING_PRELOAD] + settings[SPRING_STIFFNESS] * stroke + settings[SPRING_DAMPING] * speed
    stiffness = settings[SPRING_STIFFNESS] + c_velocity * settings[SPRING_DAMPING]
    over = abs(stroke) - settings[SPRING_HALF_STROKE]
    if over > 0.0:
        side = math.copysign(1.0, stroke)
        push = settings[SPRING_STOP] * over + settings[SPRING_STOP_DAMPING] * side * speed
        if push > 0.0:
            force += side * push
            stiffness += settings[SPRING_STOP] + c_velocity * settings[SPRING_STOP_DAMPING]
    residual[n, 0] = 0.0
    residual[n, 1] = 0.0
    residual[n, 2] += settings[SPRING_MASS] * a[n, 2] - force
    diagonal[n, 5] += c_mass * settings[SPRING_MASS] + stiffness
    diagonal[n, 0] = diagonal[n, 3] = 1e30
    diagonal[n, 1] = diagonal[n, 2] = diagonal[n, 4] = 0.0
    return over > -0.1 * settings[SPRING_HALF_STROKE]


@inner_kernel
def solve_blocks(count: int, diagonal: Array, upper: Array, residual: Array, sweep: Array, correction: Array) -> None:
    """Solve the symmetric block-tridiagonal system J correction = -residual for rows 0..count-1 (block Gauss, one pass
    each way).

    `sweep` (9 columns) is scratch; `diagonal` and `residual` are used up. Row `count` of `correction` must be what is
    prescribed there.
    """
    for i in range(count):
        a0, a1, a2, a3, a4, a5 = (
            diagonal[i, 0],
            diagonal[i, 1],
            diagonal[i, 2],
            diagonal[i, 3],
            diagonal[i, 4],
            diagonal[i, 5],
        )
        c0 = a3 * a5 - a4 * a4
        c1 = a2 * a4 - a1 * a5
        c2 = a1 * a4 - a2 * a3
        scale = 1.0 / (a0 * c0 + a1 * c1 + a2 * c2)
        i0, i1, i2 = c0 * scale, c1 * scale, c2 * scale
        i3 = (a0 * a5 - a2 * a2) * scale
        i4 = (a1 * a2 - a0 * a4) * scale
        i5 = (a0 * a3 - a1 * a1) * scale
        r0, r1, r2 = -residual[i, 0], -residual[i, 1], -residual[i, 2]
        y0 = i0 * r0 + i1 * r1 + i2 * r2
        y1 = i1 * r0 + i3 * r1 + i4 * r2
        y2 = i2 * r0 + i4 * r1 + i5 * r2
        correction[i, 0] = y0
        correction[i, 1] = y1
        correction[i, 2] = y2
        if i == count - 1:
            break
        u0, u1, u2, u3, u4, u5 = upper[i, 0], upper[i, 1], upper[i, 2], upper[i, 3], upper[i, 4], upper[i, 5]
        w00 = i0 * u0 + i1 * u1 + i2 * u2
        w01 = i0 * u1 + i1 * u3 + i2 * u4
        w02 = i0 * u2 + i1 * u4 + i2 * u5
        w10 = i1 * u0 + i3 * u1 + i4 * u2
        w11 = i1 * u1 + i3 * u3 + i4 * u4
        w12 = i1 * u2 + i3 * u4 + i4 * u5
        w20 = i2 * u0 + i4 * u1 + i5 * u2
        w21 = i2 * u1 + i4 * u3 + i5 * u4
        w22 = i2 * u2 + i4 * u4 + i5 * u5
        sweep[i, 0], sweep[i, 1], sweep[i, 2] = w00, w01, w02
        sweep[i, 3], sweep[i, 4], sweep[i, 5] = w10, w11, w12
        sweep[i, 6], sweep[i, 7], sweep[i, 8] = w20, w21, w22
        diagonal[i + 1, 0] -= u0 * w00 + u1 * w10 + u2 * w20
        diagonal[i + 1, 1] -= u0 * w01 + u1 * w11 + u2 * w21
        diagonal[i + 1, 2] -= u0 * w02 + u1 * w12 + u2 * w22
        diagonal[i + 1, 3] -= u1 * w01 + u3 * w11 + u4 * w21
        diagonal[i + 1, 4] -= u1 * w02 + u3 * w12 + u4 * w22
        diagonal[i + 1, 5] -= u2 * w02 + u4 * w12 + u5 * w22
        residual[i + 1, 0] += u0 * y0 + u1 * y1 + u2 * y2
        residual[i + 1, 1] += u1 * y0 + u3 * y1 + u4 * y2
        residual[i + 1, 2] += u2 * y0 + u4 * y1 + u5 * y2
    for i in range(count - 2, -1, -1):
        z0, z1, z2 = correction[i + 1, 0], correction[i + 1, 1], correction[i + 1, 2]
        correction[i, 0] -= sweep[i, 0] * z0 + sweep[i, 1] * z1 + sweep[i, 2] * z2
        correction[i, 1] -= sweep[i, 3] * z0 + sweep[i, 4] * z1 + sweep[i, 5] * z2
        correction[i, 2] -= sweep[i, 6] * z0 + sweep[i, 7] * z1 + sweep[i, 8] * z2
