"""The hanging line at rest: exact equilibrium of the discrete equations, so that a run starts without a transient.

From the unit upwards the force in each segment is known: what hangs below pulls on it. Its direction follows from its
own drag: one angle, found by bisection. Its stretch follows from the tension law.
"""

from __future__ import annotations

import math

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel, kernel

from cable_sim_node.errors import NoEquilibriumError
from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.forces.bending import solve_with_bending
from cable_sim_node.line.forces.body import set_unit
from cable_sim_node.line.forces.flow import set_flow
from cable_sim_node.line.forces.surface import dry_part, put_back, take_from_water
from cable_sim_node.line.observation import evaluate
from cable_sim_node.line.tiles import take_present
from cable_sim_node.physics.drag import Vector, drag_force, resolve
from cable_sim_node.physics.tension_law import strain_at, yielding_words


def refuse_floating(unit_height: float, boom_tip_height: float) -> None:
    """Raise NoEquilibriumError for a unit that hangs upwards, its `unit_height` above the `boom_tip_height` [m]."""
    if unit_height > boom_tip_height:
        raise NoEquilibriumError(floating_words(unit_height))


def floating_words(unit_height: float) -> str:
    """Return in words that a unit floats up to its `unit_height` [m], above the boom tip."""
    return (
        f"the line does not hang: the unit's buoyancy lifts it above the boom tip, to {unit_height:.0f} m; "
        "there is no surface here to float on: use a heavier unit or more cable"
    )


_PASSES = 200


@inner_kernel
def turn_of(pull: float, normal: float, along: float, across: float) -> float:
    """Return the angle [rad] by which a current turns a segment against itself, from the pull of what hangs below.

    `pull` [N]; `normal` is half the segment's drag across at 1 m/s; `along` and `across` (>= 0) are the current's
    components [m/s] to the pull. In the plane of both, with w the current across the turned segment, the forces across
    vanish: pull sin(turn) = normal abs(w) w, w = across cos(turn) + along sin(turn). The least root is wanted.
    """
    low, high = 0.0, math.pi
    for k in range(1, 65):
        turn = math.pi * k / 64.0
        w = across * math.cos(turn) + along * math.sin(turn)
        if pull * math.sin(turn) - normal * abs(w) * w >= 0.0:
            low, high = math.pi * (k - 1) / 64.0, turn
            break
    for _ in range(60):
        turn = 0.5 * (low + high)
        w = across * math.cos(turn) + along * math.sin(turn)
        if pull * math.sin(turn) - normal * abs(w) * w >= 0.0:
            high = turn
        else:
            low = turn
    return 0.5 * (low + high)


@inner_kernel
def aim(force: Array, u: Vector, normal: float, tangential: float, direction: Array, drag: Array) -> float:
    """Set `direction` of a segment that holds `force` [N] below it in the current `u`, and half its `drag` [N].

    `normal` and `tangential` are half the segment's drags at 1 m/s. Returns the tension; at or below 0 nothing pulls.
    """
    pull = math.sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2)
    if pull == 0.0:
        return 0.0
    along = (u[0] * force[0] + u[1] * force[1] + u[2] * force[2]) / pull
    across = 0.0
    for k in range(3):
        drag[k] = u[k] - along * force[k] / pull
        across += drag[k] ** 2
    across = math.sqrt(across)
    turn = turn_of(pull, normal, along, across) if across > 0.0 else 0.0
    for k in range(3):
        sideways = drag[k] / across if across > 0.0 else 0.0
        direction[k] = math.cos(turn) * force[k] / pull - math.sin(turn) * sideways
    e = (direction[0], direction[1], direction[2])
    slip, n, speed = resolve(e, u[0], u[1], u[2])
    half = drag_force(normal, tangential, e, slip, n, speed)
    tension = 0.0
    for k in range(3):
        drag[k] = half[k]
        tension += (force[k] - half[k]) * e[k]
    return tension


@kernel
def march(line: LineArrays, n: int, force: Array, drag: Array, direction: Array) -> bool:
    """Place nodes 1..n above the unit by equilibrium in the current that flows where the nodes of `line` are until now.

    `force`, `drag` and `direction` are scratch, shape (3,). Returns False where nothing pulls.
    """
    tiles, numbers = line.tiles, line.numbers
    take_present(tiles, n)
    set_flow(line, n, numbers[at.NOW + at.TIME])
    if numbers[at.UNIT_VARIES] > 0.0:
        set_unit(line, numbers[at.NOW + at.TIME], 0.0)
    water = tiles[0]
    speed = math.sqrt(water[at.FLOW_X] ** 2 + water[at.FLOW_Y] ** 2 + water[at.FLOW_Z] ** 2)
    for k in range(3):
        u = water[at.FLOW_X + k * at.STRIDE]
        # what the line above must hold: minus all steady forces below
        force[k] = -(
            numbers[at.UNIT_FORCE + k] + (numbers[at.UNIT_DRAG + k] * abs(u) + numbers[at.UNIT_BODY_DRAG] * speed) * u
        )
    for i in range(n):
        tile, j = tiles[i >> at.SHIFT], i & at.LANES
        above, m = tiles[(i + 1) >> at.SHIFT], (i + 1) & at.LANES
        length = tile[at.LENGTH + j]
        half = 0.5 * length
        u = (tile[at.FLOW_X + j + 1], tile[at.FLOW_Y + j + 1], tile[at.FLOW_Z + j + 1])
        dry = dry_part(tile, j, 0.0) if numbers[at.SURFACE_ON] > 0.0 else 0.0
        if dry > 0.0:
            take_from_water(tile, j, dry, numbers[at.GRAVITY])
        weight = half * tile[at.WEIGHT + j]
        force[2] += weight
        tension = aim(force, u, half * tile[at.NORMAL_DRAG + j], half * tile[at.TANGENTIAL_DRAG + j], direction, drag)
        if dry > 0.0:
            put_back(tile, j)
        if not tension > 0.0:
            return False
        strain = strain_at(tile[at.STIFFNESS + j], tile[at.QUADRATIC + j], tile[at.CUBIC + j], tension)
        stretched = length * (1.0 + strain)
        if not stretched > length:
            return False
        for k in range(3):
            above[at.X + k * at.STRIDE + m] = tile[at.X + k * at.STRIDE + j] + stretched * direction[k]
            # the upper half of the segment hangs on the next one
            force[k] -= 2.0 * drag[k]
        force[2] += weight + above[at.LUMP_WEIGHT + m]
        lump_drag = above[at.LUMP_DRAG + m] * math.sqrt(u[0] ** 2 + u[1] ** 2 + u[2] ** 2)
        for k in range(3):
            force[k] -= lump_drag * u[k]
    return True


@inner_kernel
def add_drag_turning(line: LineArrays, n: int) -> None:
    """Add to the band of `line` how the drag of each segment at rest changes as the segment turns.

    With u the velocity through the water, the drag of `physics.drag` changes by

        -N (u_t u_n (u_n.de)/abs(u_n) + abs(u_n) ((u_n.de) e + u_t de)) + T (2 abs(u_t) (u_n.de) e + abs(u_t) u_t de)

    `n` segments are in use.
    """
    for i in range(n):
        tile, j = line.tiles[i >> at.SHIFT], i & at.LANES
        ex = tile[at.MIDDLE + at.X + j + 1] - tile[at.MIDDLE + at.X + j]
        ey = tile[at.MIDDLE + at.Y + j + 1] - tile[at.MIDDLE + at.Y + j]
        ez = tile[at.MIDDLE + at.Z + j + 1] - tile[at.MIDDLE + at.Z + j]
        stretched = math.sqrt(ex * ex + ey * ey + ez * ez)
        e = (ex / stretched, ey / stretched, ez / stretched)
        ut, un, speed = resolve(e, -tile[at.FLOW_X + j + 1], -tile[at.FLOW_Y + j + 1], -tile[at.FLOW_Z + j + 1])
        if speed == 0.0:
            continue
        normal, tangential = (
            tile[at.NORMAL_DRAG + j] * tile[at.LENGTH + j],
            tile[at.TANGENTIAL_DRAG + j] * tile[at.LENGTH + j],
        )
        across = -normal * ut / speed
        mixed = 2.0 * tangential * abs(ut) - normal * speed
        same = tangential * abs(ut) * ut - normal * speed * ut
        for p in range(3):
            for q in range(3):
                # (across un + mixed e) un' + same (I - e e'), half of it on each end
                turning = (across * un[p] + mixed * e[p]) * un[q] - same * e[p] * e[q]
                if p == q:
                    turning += same
                turning *= 0.5 / stretched
                for end in range(2):
                    row = 3 * (i + end) + p
                    line.band[row, at.CENTRE + 3 * (1 - end) + q - p] += turning
                    line.band[row, at.CENTRE - 3 * end + q - p] -= turning


@kernel
def bend(line: LineArrays, n: int, tolerance: float) -> bool:
    """Move the nodes from the flexible line's equilibrium to the stiff one's; return False where that does not settle.

    Parameters
    ----------
    line : arrays, with the flexible line's equilibrium
    n : segments in use
    tolerance : largest last correction of Newton's method [m]

    What the tangent leaves out (the current's change with depth, the turning of the bending forces) is small, and only
    slows it.
    """
    for _ in range(400):
        evaluate(line)
        add_drag_turning(line, n)
        solve_with_bending(line, n)
        largest = 0.0
        for i in range(n):
            tile, j = line.tiles[i >> at.SHIFT], i & at.LANES
            for k in range(0, 3 * at.STRIDE, at.STRIDE):
                correction = tile[at.CX + k + j]
                tile[at.X + k + j] += correction
                size = abs(correction)
                if not size <= largest:
                    largest = size
        if largest < tolerance:
            return True
        if not largest < 1e6:
            return False
    return False


def _cause(line: LineArrays, n: int, scratch: Array) -> str:
    """Return why `n` segments of a line do not hang: their tension law, if they would hang by a straight one."""
    straight = line._replace(tiles=line.tiles.copy())
    for column in (at.QUADRATIC, at.CUBIC):
        straight.write(column, np.zeros((n, 1)))
    if march(straight, n, *scratch):
        return yielding_words(float(line.column(at.QUADRATIC, 1)[0]), float(line.column(at.CUBIC, 1)[0]))
    return "the line does not hang: the weight of unit and cable in water must exceed the upward forces"


def hang(line: LineArrays, boom_tip: Array) -> None:
    """Put the line at rest under the boom tip, in the current of the present time, without waves.

    Parameters
    ----------
    line : arrays, with its length, segments and time set
    boom_tip : position [m], shape (3,)

    Raises
    ------
    NoEquilibriumError
        where unit and cable do not hang (buoyant, or a tension law that yields).
    """
    n = line.segments
    total = float(np.sum(line.column(at.LENGTH, n)))
    unit_position = boom_tip - np.array([0.0, 0.0, total])
    positions = np.linspace(unit_position, boom_tip, n + 1)
    line.write(at.X, positions)
    scratch = np.zeros((3, 3))
    # the line's position depends on the current and the current on the position: each pass shifts it by much less than
    # the one before
    for _ in range(_PASSES):
        if not march(line, n, *scratch):
            raise NoEquilibriumError(_cause(line, n, scratch))
        positions = line.read(at.X, 3, n + 1)
        miss = boom_tip - positions[n]
        positions += miss
        line.write(at.X, positions)
        if np.max(np.abs(miss)) < 1e-12 * total:
            break
        if positions[0, 2] > boom_tip[2] and line.numbers[at.SURFACE_ON] > 0.0:
            raise NoEquilibriumError(floating_words(float(positions[0, 2])))
    else:
        raise NoEquilibriumError("the line has no equilibrium in the current: the current changes too fast with depth")
    positions[n] = boom_tip
    line.write(at.X, positions)
    line.write(at.VX, np.zeros((n + 1, 6)))
    if line.numbers[at.BENDING_ON] > 0.0 and not bend(line, n, 1e-10 * total):
        raise NoEquilibriumError(
            "the bent line has no equilibrium: cable.bending_stiffness is too large for its tension"
        )
