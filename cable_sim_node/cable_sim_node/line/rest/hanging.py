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
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.bending import solve_with_bending
from cable_sim_node.line.flow import set_flow
from cable_sim_node.line.layout import (
    BENDING_ON,
    CENTRE,
    CUBIC,
    CX,
    CY,
    CZ,
    FLOW_AX,
    FLOW_X,
    FLOW_Y,
    FLOW_Z,
    LENGTH,
    LUMP_DRAG,
    LUMP_WEIGHT,
    NORMAL_DRAG,
    NOW,
    QUADRATIC,
    SEGMENTS,
    STIFFNESS,
    TANGENTIAL_DRAG,
    TIME,
    UNIT_BODY_DRAG,
    UNIT_DRAG,
    UNIT_FORCE,
    WAVE_AMPLITUDE,
    WEIGHT,
    X,
    Y,
    Z,
)
from cable_sim_node.line.step import assemble
from cable_sim_node.physics.drag import drag_force, resolve
from cable_sim_node.physics.tension_law import strain_at, yielding_words

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
def aim(force: Array, u: Array, normal: float, tangential: float, direction: Array, drag: Array) -> float:
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
def march(line: LineArrays, n: int) -> bool:
    """Place nodes 1..n above the unit by equilibrium in the current that flows where the nodes of `line` are until now.

    Returns False where nothing pulls.
    """
    now, parts, unit = line.now, line.parts, line.unit
    set_flow(n, line.top[NOW, TIME], now, line.settings, line.current, line.schedule, line.flow)
    force, drag, direction = line.middle[0], line.middle[1], line.middle[2]  # free until the first step
    water = line.flow[0]
    speed = math.sqrt(water[FLOW_X] ** 2 + water[FLOW_Y] ** 2 + water[FLOW_Z] ** 2)
    for k in range(3):
        u = water[FLOW_X + k]
        # what the line above must hold: minus all steady forces below
        force[k] = -(unit[UNIT_FORCE + k] + (unit[UNIT_DRAG + k] * abs(u) + unit[UNIT_BODY_DRAG] * speed) * u)
    for i in range(n):
        part, water = parts[i], line.flow[i + 1]
        length = part[LENGTH]
        force[2] += 0.5 * part[WEIGHT] * length
        half = 0.5 * length
        tension = aim(force, water, part[NORMAL_DRAG] * half, part[TANGENTIAL_DRAG] * half, direction, drag)
        if not tension > 0.0:
            return False
        stretched = length * (1.0 + strain_at(part[STIFFNESS], part[QUADRATIC], part[CUBIC], tension))
        if not stretched > length:
            return False
        for k in range(3):
            now[i + 1, X + k] = now[i, X + k] + stretched * direction[k]
            # the upper half of the segment hangs on the next one
            force[k] -= 2.0 * drag[k]
        force[2] += 0.5 * part[WEIGHT] * length + parts[i + 1, LUMP_WEIGHT]
        speed = math.sqrt(water[FLOW_X] ** 2 + water[FLOW_Y] ** 2 + water[FLOW_Z] ** 2)
        lump_drag = parts[i + 1, LUMP_DRAG] * speed
        for k in range(3):
            force[k] -= lump_drag * water[FLOW_X + k]
    return True


@inner_kernel
def add_drag_turning(n: int, nodes: Array, parts: Array, flow: Array, band: Array) -> None:
    """Add to `band` how the drag of each segment at rest changes as the segment turns.

    With u the velocity through the water, the drag of `physics.drag` changes by

        -N (u_t u_n (u_n.de)/abs(u_n) + abs(u_n) ((u_n.de) e + u_t de)) + T (2 abs(u_t) (u_n.de) e + abs(u_t) u_t de)

    `n` segments are in use; `nodes`, `parts` and `flow` are arrays of `LineArrays`.
    """
    for i in range(n):
        row, low, high, water = parts[i], nodes[i], nodes[i + 1], flow[i + 1]
        ex, ey, ez = high[X] - low[X], high[Y] - low[Y], high[Z] - low[Z]
        stretched = math.sqrt(ex * ex + ey * ey + ez * ez)
        e = (ex / stretched, ey / stretched, ez / stretched)
        ut, un, speed = resolve(e, -water[FLOW_X], -water[FLOW_Y], -water[FLOW_Z])
        if speed == 0.0:
            continue
        normal, tangential = row[NORMAL_DRAG] * row[LENGTH], row[TANGENTIAL_DRAG] * row[LENGTH]
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
                    line_row = 3 * (i + end) + p
                    band[line_row, CENTRE + 3 * (1 - end) + q - p] += turning
                    band[line_row, CENTRE - 3 * end + q - p] -= turning


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
    equations = line.equations
    equations[n, CX] = equations[n, CY] = equations[n, CZ] = 0.0
    for _ in range(400):
        assemble(line, n, 0.0, 0.0)
        add_drag_turning(n, line.now, line.parts, line.flow, line.band)
        solve_with_bending(n, equations, line.band)
        largest = 0.0
        for i in range(n):
            for k in range(3):
                correction = equations[i, CX + k]
                line.now[i, X + k] += correction
                size = abs(correction)
                if not size <= largest:
                    largest = size
        if largest < tolerance:
            return True
        if not largest < 1e6:
            return False
    return False


def _cause(line: LineArrays, n: int) -> str:
    """Return why `n` segments of a line do not hang: their tension law, if they would hang by a straight one."""
    straight = line._replace(parts=line.parts.copy())
    straight.parts[:, QUADRATIC] = straight.parts[:, CUBIC] = 0.0
    if march(straight, n):
        return yielding_words(float(line.parts[0, QUADRATIC]), float(line.parts[0, CUBIC]))
    return "the line does not hang: the weight of unit and cable in water must exceed the upward forces"


def hang(line: LineArrays, boom_tip: Array) -> None:
    """Put the line at rest under the boom tip, in the current of the present time; a wave is taken to be still.

    Parameters
    ----------
    line : arrays, with its length, segments and time set
    boom_tip : position [m], shape (3,)

    Raises
    ------
    NoEquilibriumError
        where unit and cable do not hang (buoyant, or a tension law that yields).
    """
    n = int(line.counters[SEGMENTS])
    total = float(np.sum(line.parts[:n, LENGTH]))
    calm = line._replace(settings=line.settings.copy())
    calm.settings[WAVE_AMPLITUDE] = 0.0
    line.flow[:, FLOW_AX:] = 0.0
    unit_position = boom_tip - np.array([0.0, 0.0, total])
    line.x[: n + 1] = np.linspace(unit_position, boom_tip, n + 1)
    # the line's position depends on the current and the current on the position: each pass shifts it by much less than
    # the one before
    for _ in range(_PASSES):
        if not march(calm, n):
            raise NoEquilibriumError(_cause(calm, n))
        miss = boom_tip - line.x[n]
        line.x[: n + 1] += miss
        if np.max(np.abs(miss)) < 1e-12 * total:
            break
    else:
        raise NoEquilibriumError("the line has no equilibrium in the current: the current changes too fast with depth")
    line.x[n] = boom_tip
    line.v[:] = 0.0
    line.a[:] = 0.0
    if line.settings[BENDING_ON] > 0.0 and not bend(line, n, 1e-10 * total):
        raise NoEquilibriumError(
            "the bent line has no equilibrium: cable.bending_stiffness is too large for its tension"
        )
