"""The hanging line at rest: exact equilibrium of the discrete equations, so that a run starts without a transient.

From the unit upwards the force in each segment is known: what hangs below pulls on it. Its direction follows from its
own drag by a small fixed-point iteration, its stretch from the tension law.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cable_sim_node.errors import NoEquilibriumError
from cable_sim_node.line_arrays import LineArrays
from cable_sim_node.line_bending import solve_with_bending
from cable_sim_node.line_flow import set_flow
from cable_sim_node.line_layout import (
    BENDING_ON,
    CUBIC,
    LENGTH,
    LUMP_DRAG,
    LUMP_WEIGHT,
    NORMAL_DRAG,
    QUADRATIC,
    SEGMENTS,
    STIFFNESS,
    TANGENTIAL_DRAG,
    UNIT_DRAG,
    UNIT_FORCE,
    WAVE_AMPLITUDE,
    WEIGHT,
)
from cable_sim_node.line_step import assemble

Array = NDArray[np.float64]

_PASSES = 200


@njit(cache=True, error_model="numpy")
def strain_at(row: Array, tension: float) -> float:
    """Return the strain at which the tension law gives `tension` [N]; NaN where it does not reach it."""
    strain = tension / row[STIFFNESS]
    for _ in range(50):
        q, c = row[QUADRATIC], row[CUBIC]
        value = row[STIFFNESS] * strain * (1.0 + strain * (q + c * strain)) - tension
        slope = row[STIFFNESS] * (1.0 + strain * (2.0 * q + 3.0 * c * strain))
        if slope <= 0.0:
            return math.nan
        change = value / slope
        strain -= change
        if abs(change) < 1e-15 * (1e-12 + abs(strain)):
            break
    return strain


@njit(cache=True, error_model="numpy")
def march(line: LineArrays, n: int, unit_position: Array) -> bool:
    """Place nodes 0..n above the unit by equilibrium, with the flow as it stands in `line.flow`.

    False where nothing pulls.
    """
    x = line.x
    force = np.empty(3)
    drag = np.zeros(3)
    for k in range(3):
        x[0, k] = unit_position[k]
        u = line.flow[0, k]
        # what the rest of the line must hold: minus all steady forces below
        force[k] = -(line.unit[UNIT_FORCE + k] + line.unit[UNIT_DRAG + k] * abs(u) * u)
    direction = np.array([0.0, 0.0, 1.0])
    for i in range(n):
        row = line.seg[i]
        length = row[LENGTH]
        ux, uy, uz = line.flow[i + 1, 0], line.flow[i + 1, 1], line.flow[i + 1, 2]
        force[2] += 0.5 * row[WEIGHT] * length
        tension = 0.0
        for _ in range(200):
            ex, ey, ez = direction[0], direction[1], direction[2]
            ut = ux * ex + uy * ey + uz * ez
            nx, ny, nz = ux - ut * ex, uy - ut * ey, uz - ut * ez
            normal = row[NORMAL_DRAG] * length * math.sqrt(nx * nx + ny * ny + nz * nz)
            along = row[TANGENTIAL_DRAG] * length * abs(ut) * ut
            drag[0] = 0.5 * (normal * nx + along * ex)
            drag[1] = 0.5 * (normal * ny + along * ey)
            drag[2] = 0.5 * (normal * nz + along * ez)
            px, py, pz = force[0] - drag[0], force[1] - drag[1], force[2] - drag[2]
            tension = math.sqrt(px * px + py * py + pz * pz)
            if tension == 0.0:
                return False
            change = abs(px / tension - ex) + abs(py / tension - ey) + abs(pz / tension - ez)
            direction[0], direction[1], direction[2] = px / tension, py / tension, pz / tension
            if change < 1e-15:
                break
        stretched = length * (1.0 + strain_at(row, tension))
        if not stretched > length:
            return False
        for k in range(3):
            x[i + 1, k] = x[i, k] + stretched * direction[k]
            # the upper half of the segment hangs on the next one
            force[k] -= 2.0 * drag[k]
        force[2] += 0.5 * row[WEIGHT] * length
        ux, uy, uz = line.flow[i + 1, 0], line.flow[i + 1, 1], line.flow[i + 1, 2]
        lump_drag = line.lump[i + 1, LUMP_DRAG] * math.sqrt(ux * ux + uy * uy + uz * uz)
        force[0] -= lump_drag * ux
        force[1] -= lump_drag * uy
        force[2] += line.lump[i + 1, LUMP_WEIGHT] - lump_drag * uz
    return True


@njit(cache=True, error_model="numpy")
def bend(line: LineArrays, n: int, tolerance: float) -> bool:
    """Move the nodes from the flexible line's equilibrium to the stiff one's; False where that does not settle.

    Newton with the tangent that `assemble` gives. It leaves out how drag turns with the line, so the last digits come
    by a contraction; `tolerance` [m] is on the largest correction.
    """
    correction = line.correction
    for k in range(3):
        correction[n, k] = 0.0
    for _ in range(400):
        assemble(line, n, False, 0.0, 0.0)
        solve_with_bending(n, line.diagonal, line.upper, line.residual, line.band, correction)
        largest = 0.0
        for i in range(n):
            for k in range(3):
                line.x[i, k] += correction[i, k]
                size = abs(correction[i, k])
                if not size <= largest:
                    largest = size
        if largest < tolerance:
            return True
        if not largest < 1e6:
            return False
    return False


def hang(line: LineArrays, boom_tip: Array) -> None:
    """Put the line at rest under `boom_tip`, shape (3,) [m], in the current of the present time; a wave is taken to be
    still.

    Raises NoEquilibriumError where unit and cable do not hang (buoyant, or a tension law that yields).
    """
    n = int(line.counters[SEGMENTS])
    total = float(np.sum(line.seg[:n, LENGTH]))
    calm = line.settings.copy()
    calm[WAVE_AMPLITUDE] = 0.0
    line.flow_acceleration[:] = 0.0
    unit_position = boom_tip - np.array([0.0, 0.0, total])
    line.x[: n + 1] = np.linspace(unit_position, boom_tip, n + 1)
    # where the line hangs depends on the current, and that on where it hangs: the shift of each pass is much smaller
    # than the last
    for _ in range(_PASSES):
        set_flow(n, line.x, line.moving, calm, line.current, line.schedule, line.flow, line.flow_acceleration)
        if not march(line, n, unit_position):
            raise NoEquilibriumError(
                "the line does not hang: unit and cable must weigh more in water than what lifts them"
            )
        miss = boom_tip - line.x[n]
        unit_position = unit_position + miss
        line.x[: n + 1] += miss
        if np.max(np.abs(miss)) < 1e-12 * total:
            break
    else:
        raise NoEquilibriumError(
            "the line's place in the current does not settle: the current changes too fast with depth"
        )
    line.x[n] = boom_tip
    line.v[:] = 0.0
    line.a[:] = 0.0
    if line.settings[BENDING_ON] > 0.0 and not bend(line, n, 1e-10 * total):
        raise NoEquilibriumError("the bent line does not settle: cable.bending_stiffness is too large for it")
