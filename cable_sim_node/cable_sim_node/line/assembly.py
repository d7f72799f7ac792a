"""Equations of motion of the lumped line: residual and symmetric block-tridiagonal Jacobian (thesis Eq. 5.1-5.6).

Node 0 is the unit, node n the sheave (boom tip); segment i joins nodes i and i + 1. Blocks are symmetric 3 x 3, stored
as xx, xy, xz, yy, yz, zz. The top segment changes its length L' at the sheave, where material passes: with q = (x_n -
x_{n-1})/l, material at the sheave has velocity x_n' - L' q and acceleration x_n'' - L'' q - 2 L' q'.

Everything is taken in the middle state (`layout.MIDDLE`). Arguments have the same names everywhere: `line` the arrays,
`tiles` and `numbers` two of them (see `arrays`), `n` segments in use, `tile` and `j` a row of the tiles and a place in
it. The Jacobian is that of the residual by a node's position if its velocity moves by `c_velocity` [1/s] and its
acceleration by `c_mass` [1/s^2] times as much.
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inlined_kernel, inner_kernel

from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.forces.contact import add_contacts
from cable_sim_node.line.forces.direction import FOLDED, folded
from cable_sim_node.line.forces.flow import set_flow_at
from cable_sim_node.line.forces.friction import add_friction
from cable_sim_node.line.forces.segment import rank_one, tension_of
from cable_sim_node.line.forces.surface import (
    dry_part,
    put_all_back,
    put_back,
    take_from_water,
    take_out_of_water,
)
from cable_sim_node.line.forces.waves import add_wave_force
from cable_sim_node.line.tiles import largest_of
from cable_sim_node.physics.drag import drag_force, resolve


@inner_kernel
def assemble_segments(tile: Array, count: int, c_mass: float, c_velocity: float) -> None:
    """Set what the first `count` segments of `tile` give to the equations R = M a - F and their Jacobian.

    Residual and upper block go to the lower end's place, what the upper end gets to its own columns at its place; the
    diagonal block is the same for both ends. Minus the strain is left in SCRATCH. What drag and added mass owe to
    the turning of a segment is left out of the Jacobian (not of the residual): both are small beside inertia, and
    the blocks stay symmetric. The loop has no branch, so that it is compiled to vector instructions.
    """
    for j in range(count):
        vx, vy, vz = tile[at.MIDDLE + at.VX + j], tile[at.MIDDLE + at.VY + j], tile[at.MIDDLE + at.VZ + j]
        wx, wy, wz = tile[at.MIDDLE + at.VX + j + 1], tile[at.MIDDLE + at.VY + j + 1], tile[at.MIDDLE + at.VZ + j + 1]
        ex = tile[at.MIDDLE + at.X + j + 1] - tile[at.MIDDLE + at.X + j]
        ey = tile[at.MIDDLE + at.Y + j + 1] - tile[at.MIDDLE + at.Y + j]
        ez = tile[at.MIDDLE + at.Z + j + 1] - tile[at.MIDDLE + at.Z + j]
        # direction e, strain and its rate e.(w - v)/l; a folded segment has the smooth direction of `forces.direction`
        per_length = tile[at.PER_LENGTH + j]
        stretched = math.sqrt(ex * ex + ey * ey + ez * ez)
        ratio = stretched * per_length
        inverse = 1.0 / (stretched + 1e-300)
        size = inverse if ratio >= FOLDED else per_length * folded(ratio)
        ex, ey, ez = ex * size, ey * size, ez * size
        strain = ratio - 1.0
        strain_rate = (ex * (wx - vx) + ey * (wy - vy) + ez * (wz - vz)) * per_length
        stiffness, damping = tile[at.STIFFNESS + j], tile[at.DAMPING + j]
        tension, by_strain, by_rate = tension_of(
            stiffness, tile[at.QUADRATIC + j], tile[at.CUBIC + j], damping, strain, strain_rate
        )
        tile[at.TENSION + j], tile[at.SCRATCH + j] = tension, -strain
        # h: half of drag and weight, for the mean velocity u of the ends through the water, with its part n across
        half = 0.5 * tile[at.LENGTH + j]
        ux = 0.5 * (vx + wx) - tile[at.FLOW_X + j + 1]
        uy = 0.5 * (vy + wy) - tile[at.FLOW_Y + j + 1]
        uz = 0.5 * (vz + wz) - tile[at.FLOW_Z + j + 1]
        normal, tangential = half * tile[at.NORMAL_DRAG + j], half * tile[at.TANGENTIAL_DRAG + j]
        slip, n, speed = resolve((ex, ey, ez), ux, uy, uz)
        hx, hy, hz = drag_force(normal, tangential, (ex, ey, ez), slip, n, speed)
        hz += half * tile[at.WEIGHT + j]
        # R = M a + h -+ T e with M = m I - a e e', at the lower and at the upper end
        added = half * tile[at.ADDED_MASS + j]
        mass = half * tile[at.MASS + j] + added
        ax, ay, az = tile[at.MIDDLE + at.AX + j], tile[at.MIDDLE + at.AY + j], tile[at.MIDDLE + at.AZ + j]
        along = added * (ex * ax + ey * ay + ez * az) + tension
        tile[at.RX + j], tile[at.RY + j] = mass * ax + hx - along * ex, mass * ay + hy - along * ey
        tile[at.RZ + j] = mass * az + hz - along * ez
        ax, ay, az = tile[at.MIDDLE + at.AX + j + 1], tile[at.MIDDLE + at.AY + j + 1], tile[at.MIDDLE + at.AZ + j + 1]
        along = added * (ex * ax + ey * ay + ez * az) - tension
        tile[at.END_RX + j + 1], tile[at.END_RY + j + 1] = mass * ax + hx - along * ex, mass * ay + hy - along * ey
        tile[at.END_RZ + j + 1] = mass * az + hz - along * ez
        # stiffness k = T/l' I + (dT/l - T/l') e e'; drag c B = p I + (q - p) e e' + r n n'; both ends move u by half
        turning = tension * inverse
        stretching = (by_strain + c_velocity * by_rate) * per_length - turning
        p, q = 0.5 * c_velocity * normal * speed, c_velocity * tangential * abs(slip)
        xx, xy, xz, yy, yz, zz = rank_one(0.0, 0.5 * c_velocity * normal / (speed + 1e-12), n[0], n[1], n[2])
        # upper block c B - k, diagonal block c B + k + c_mass M
        u = rank_one(p - turning, q - p - stretching, ex, ey, ez)
        d = rank_one(p + turning + c_mass * mass, q - p + stretching - c_mass * added, ex, ey, ez)
        tile[at.UXX + j], tile[at.UXY + j], tile[at.UXZ + j] = u[0] + xx, u[1] + xy, u[2] + xz
        tile[at.UYY + j], tile[at.UYZ + j], tile[at.UZZ + j] = u[3] + yy, u[4] + yz, u[5] + zz
        tile[at.END_XX + j + 1], tile[at.END_XY + j + 1], tile[at.END_XZ + j + 1] = d[0] + xx, d[1] + xy, d[2] + xz
        tile[at.END_YY + j + 1], tile[at.END_YZ + j + 1], tile[at.END_ZZ + j + 1] = d[3] + yy, d[4] + yz, d[5] + zz


@inlined_kernel
def assemble_tile(tile: Array, count: int, numbers: Array, c_mass: float, c_velocity: float) -> None:
    """Do `assemble_segments` for `count` segments, and add what not every line has: waves, friction between wires."""
    assemble_segments(tile, count, c_mass, c_velocity)
    if numbers[at.WAVES] > 0.0:
        add_wave_force(tile, count)
    if numbers[at.FRICTION_ON] > 0.0:
        add_friction(tile, count, numbers)


@inlined_kernel
def swap_sheave(line: LineArrays, n: int) -> None:
    """Put the motion of the material at the sheave (see the text of the module) where that of the sheave is.

    It is the upper end of the top segment, whose place `restore_sheave` gives back.
    """
    tile, j = line.tiles[(n - 1) >> at.SHIFT], (n - 1) & at.LANES
    rate, acceleration = line.numbers[at.MIDWAY + at.RATE], line.numbers[at.MIDWAY + at.ACCELERATION]
    per_length = tile[at.PER_LENGTH + j]
    for axis in range(3):
        node = tile[at.MIDDLE + axis * at.STRIDE :]
        q = (node[at.X + j + 1] - node[at.X + j]) * per_length
        material = node[at.VX + j + 1] - rate * q
        node[at.AX + j + 1] -= acceleration * q + 2.0 * rate * (material - node[at.VX + j]) * per_length
        node[at.VX + j + 1] = material


@inlined_kernel
def motion_of(tile: Array, j: int) -> tuple[float, float, float, float, float, float]:
    """Return velocity and acceleration of place `j` of `tile` in the middle state."""
    return (
        tile[at.MIDDLE + at.VX + j],
        tile[at.MIDDLE + at.VY + j],
        tile[at.MIDDLE + at.VZ + j],
        tile[at.MIDDLE + at.AX + j],
        tile[at.MIDDLE + at.AY + j],
        tile[at.MIDDLE + at.AZ + j],
    )


@inlined_kernel
def restore_sheave(tile: Array, j: int, motion: tuple[float, float, float, float, float, float]) -> None:
    """Give place `j` of `tile` its `motion` back, as `motion_of` returned it."""
    vx, vy, vz, ax, ay, az = motion
    tile[at.MIDDLE + at.VX + j], tile[at.MIDDLE + at.VY + j], tile[at.MIDDLE + at.VZ + j] = vx, vy, vz
    tile[at.MIDDLE + at.AX + j], tile[at.MIDDLE + at.AY + j], tile[at.MIDDLE + at.AZ + j] = ax, ay, az


@inlined_kernel
def join_segments(tiles: Array, n: int) -> None:
    """Give the nodes 0..n of the line the diagonal blocks and residuals of the segments below and above them."""
    last, top = tiles[n >> at.SHIFT], n & at.LANES
    for column in range(6):
        last[at.END_XX + column * at.STRIDE + top + 1] = 0.0
        tiles[0, at.END_XX + column * at.STRIDE] = 0.0
    for axis in range(3):
        last[at.RX + axis * at.STRIDE + top] = 0.0
        tiles[0, at.END_RX + axis * at.STRIDE] = 0.0
    for t in range((n >> at.SHIFT) + 1):
        tile = tiles[t]
        if t > 0:
            for column in range(9):
                end = at.END_XX + column * at.STRIDE
                tile[end] = tiles[t - 1, end + at.TILE]
        count = min(at.TILE, n + 1 - (t << at.SHIFT))
        for column in range(6):
            row = tile[column * at.STRIDE :]
            for j in range(count):
                row[at.DXX + j] = row[at.END_XX + j] + row[at.END_XX + j + 1]
        for axis in range(3):
            row = tile[axis * at.STRIDE :]
            for j in range(count):
                row[at.RX + j] += row[at.END_RX + j]


@inlined_kernel
def add_unit(tile: Array, numbers: Array, c_mass: float, c_velocity: float) -> None:
    """Add the unit to the equations of node 0, in the first `tile`.

    Its drag works along each axis by itself (thesis 5.2.2): (1/2) rho C_Dx S_x abs(u_x) u_x, and so on; that of an
    isotropic unit is (1/2) rho C_D S abs(u) u.
    """
    ux, uy = tile[at.MIDDLE + at.VX] - tile[at.FLOW_X], tile[at.MIDDLE + at.VY] - tile[at.FLOW_Y]
    uz = tile[at.MIDDLE + at.VZ] - tile[at.FLOW_Z]
    body_drag = numbers[at.UNIT_BODY_DRAG] * math.sqrt(ux * ux + uy * uy + uz * uz)
    for axis in range(3):
        column = axis * at.STRIDE
        u = tile[at.MIDDLE + at.VX + column] - tile[at.FLOW_X + column]
        inertia = numbers[at.UNIT_INERTIA + axis]
        drag = numbers[at.UNIT_DRAG + axis] * abs(u) + body_drag
        force = numbers[at.UNIT_FORCE + axis] + numbers[at.UNIT_FLUID + axis] * tile[at.FLOW_AX + column]
        tile[at.RX + column] += inertia * tile[at.MIDDLE + at.AX + column] + drag * u - force
        diagonal = at.DXX if axis == 0 else (at.DYY if axis == 1 else at.DZZ)
        tile[diagonal] += c_mass * inertia + c_velocity * 2.0 * drag


@inner_kernel
def add_lump(tiles: Array, i: int, c_mass: float, c_velocity: float) -> None:
    """Add the lump on node `i`, above the unit, to the equations."""
    tile, j = tiles[i >> at.SHIFT], i & at.LANES
    inertia = tile[at.LUMP_MASS + j] + tile[at.LUMP_ADDED_MASS + j]
    if inertia == 0.0 and tile[at.LUMP_DRAG + j] == 0.0:
        return
    water, place = tiles[(i - 1) >> at.SHIFT], ((i - 1) & at.LANES) + 1
    fluid = tile[at.LUMP_DISPLACED + j] + tile[at.LUMP_ADDED_MASS + j]
    ux = tile[at.MIDDLE + at.VX + j] - water[at.FLOW_X + place]
    uy = tile[at.MIDDLE + at.VY + j] - water[at.FLOW_Y + place]
    uz = tile[at.MIDDLE + at.VZ + j] - water[at.FLOW_Z + place]
    drag = tile[at.LUMP_DRAG + j] * math.sqrt(ux * ux + uy * uy + uz * uz)
    tile[at.RX + j] += inertia * tile[at.MIDDLE + at.AX + j] + drag * ux - fluid * water[at.FLOW_AX + place]
    tile[at.RY + j] += inertia * tile[at.MIDDLE + at.AY + j] + drag * uy - fluid * water[at.FLOW_AY + place]
    tile[at.RZ + j] += inertia * tile[at.MIDDLE + at.AZ + j] + drag * uz - fluid * water[at.FLOW_AZ + place]
    tile[at.RZ + j] += tile[at.LUMP_WEIGHT + j]
    # the derivative lies between drag and 2 drag in all directions: the upper bound keeps the correction short
    added = c_mass * inertia + 2.0 * c_velocity * drag
    tile[at.DXX + j] += added
    tile[at.DYY + j] += added
    tile[at.DZZ + j] += added


@inner_kernel
def take_present_tip(numbers: Array) -> None:
    """Make the present boom tip and length those where the equations hold."""
    for c in range(at.TIP_NUMBERS):
        numbers[at.MIDWAY + c] = numbers[at.NOW + c]


@inlined_kernel
def take_present_place(tile: Array, j: int) -> None:
    """Set the middle state at place `j` of `tile` to the present one."""
    for column in range(at.MOTION_COLUMNS):
        tile[at.MIDDLE + column * at.STRIDE + j] = tile[column * at.STRIDE + j]


@inner_kernel
def assemble_present(line: LineArrays, n: int, i: int) -> None:
    """Set what segment `i` alone gives to the equations of its ends in the present state, see `assemble_segments`.

    Boom tip and length where the equations hold must be the present ones (`take_present_tip`), and so the surface
    below the boom tip (`set_level`).
    """
    tile, j, numbers = line.tiles[i >> at.SHIFT], i & at.LANES, line.numbers
    take_present_place(tile, j)
    take_present_place(tile, j + 1)
    if numbers[at.FLOW_VARIES] > 0.0:
        set_flow_at(line, i >> at.SHIFT, j, j + 1, numbers[at.NOW + at.TIME])
    dry = dry_part(tile, j, numbers[at.LEVEL]) if numbers[at.SURFACE_ON] > 0.0 else 0.0
    if dry > 0.0:
        take_from_water(tile, j, dry, numbers[at.GRAVITY])
    sheave = motion_of(tile, j + 1)
    if i == n - 1:
        swap_sheave(line, n)
    assemble_tile(tile[j:], at.ONE, numbers, 0.0, 0.0)
    restore_sheave(tile, j + 1, sheave)
    if dry > 0.0:
        put_back(tile, j)


@inner_kernel
def assemble(line: LineArrays, n: int, c_mass: float, c_velocity: float) -> tuple[float, bool]:
    """Assemble the equations of all nodes but for bending stiffness and a compensator.

    Returns the least strain, and whether the equations may have a kink: where the seabed is touched, where wires slide.
    """
    tiles, numbers = line.tiles, line.numbers
    top_tile, end = tiles[(n - 1) >> at.SHIFT], ((n - 1) & at.LANES) + 1
    sheave = motion_of(top_tile, end)
    swap_sheave(line, n)
    dry = take_out_of_water(line, n) if numbers[at.SURFACE_ON] > 0.0 else 0
    most = -1e300
    for t in range(((n - 1) >> at.SHIFT) + 1):
        tile, count = tiles[t], min(at.TILE, n - (t << at.SHIFT))
        assemble_tile(tile, count, numbers, c_mass, c_velocity)
        most = max(most, largest_of(tile, count))
    put_all_back(line, n, dry)
    restore_sheave(top_tile, end, sheave)
    join_segments(tiles, n)
    add_unit(tiles[0], numbers, c_mass, c_velocity)
    # without bodies on the cable a lump is where the top segment spans several sections: on its two ends
    for i in range(1 if numbers[at.LUMPS_ON] > 0.0 else max(n - 1, 1), n + 1):
        add_lump(tiles, i, c_mass, c_velocity)
    touches = add_contacts(line, n, c_velocity)
    return -most, touches or numbers[at.FRICTION_ON] > 0.0
