"""Time integration of the axial cable on a fixed domain (thesis 3.2), in numba.

Material is counted from the unit: label s in [0, L(t)], s = 0 at the unit. With y = s/L(t) the domain is [0, 1] and

    d/dt|material = d/dt - (y L'/L) d/dy

so that the unit (y = 0) has no convective term and new cable enters at y = 1, where the top's position is given. The
unknown is P = z - s, the elevation of a material point less its label: smooth, and equal to the unit's elevation where
the cable is rigid. Space: N linear elements, lumped mass. Time: BDF2 as in thesis 3.2.6 (damps what the mesh cannot
resolve), solved by Newton with a tridiagonal matrix, so that slack and quadratic drag are implicit.
"""

from __future__ import annotations

import math

import numpy as np
from heave_node.arrays import Array
from numba import njit

NEWTON_LIMIT = 60
NEWTON_TOLERANCE = 1e-10
"""Largest last correction of a position [m] at which a step counts as solved."""


@njit(cache=True)
def cumulative(label: float, starts: Array, totals: Array, densities: Array) -> float:
    """Return the integral of a piecewise constant density from label 0 to `label`.

    `starts` are the labels at which the sections begin, `totals` the integral up to each of them; the last section has
    no end.
    """
    section = len(starts) - 1
    while section > 0 and label < starts[section]:
        section -= 1
    return totals[section] + densities[section] * (label - starts[section])


@njit(cache=True)
def _discretise(
    length: float,
    starts: Array,
    totals: Array,
    densities: Array,
    clumps: Array,
    stiffness: Array,
    damping: Array,
    lumps: Array,
) -> None:
    """Fill element stiffness [N/m] and damping [N s/m] and the node lumps (mass [kg], weight [N], drag [N s2/m2]).

    Rows of `totals` and `densities`: compliance 1/EA, mass, weight, drag, internal damping over stiffness; of `clumps`:
    label, inertia, weight, drag. A clump between two nodes is shared by the lever rule, so it passes them smoothly.
    """
    elements = len(stiffness)
    size = length / elements
    lumps[:] = 0.0
    for j in range(elements):
        low, high = j * size, (j + 1) * size
        compliance = cumulative(high, starts, totals[0], densities[0]) - cumulative(
            low, starts, totals[0], densities[0]
        )
        stiffness[j] = 1.0 / compliance
        delay = cumulative(high, starts, totals[4], densities[4]) - cumulative(low, starts, totals[4], densities[4])
        damping[j] = stiffness[j] * delay / size
        for row in range(3):
            amount = cumulative(high, starts, totals[row + 1], densities[row + 1])
            amount -= cumulative(low, starts, totals[row + 1], densities[row + 1])
            lumps[row, j] += 0.5 * amount
            lumps[row, j + 1] += 0.5 * amount
    for body in clumps:
        if body[0] <= length:
            j = min(int(body[0] / size), elements - 1)
            share = body[0] / size - j
            for row in range(3):
                lumps[row, j] += (1.0 - share) * body[row + 1]
                lumps[row, j + 1] += share * body[row + 1]


@njit(cache=True)
def _velocities(
    position: Array,
    before: Array,
    earlier: Array,
    length: float,
    rate: float,
    top_velocity: float,
    h: float,
    out: Array,
) -> None:
    """Material velocities from BDF2 in time and central differences in the convective term."""
    elements = len(position) - 1
    out[0] = (3.0 * position[0] - 4.0 * before[0] + earlier[0]) / (2.0 * h)
    for i in range(1, elements):
        convection = 0.5 * i * rate / length
        out[i] = (3.0 * position[i] - 4.0 * before[i] + earlier[i]) / (2.0 * h)
        out[i] -= convection * (position[i + 1] - position[i - 1])
    strain = (position[elements] - position[elements - 1]) * elements / length
    out[elements] = top_velocity - rate * (1.0 + strain)


@njit(cache=True)
def _acceleration(
    i: int, velocity: Array, before: Array, earlier: Array, length: float, rate: float, h: float
) -> float:
    """Material acceleration of node `i`; one-sided at the top, where the cable ends."""
    elements = len(velocity) - 1
    local = (3.0 * velocity[i] - 4.0 * before[i] + earlier[i]) / (2.0 * h)
    if i == 0:
        return local
    if i == elements:
        return local - i * rate / length * (velocity[i] - velocity[i - 1])
    return local - 0.5 * i * rate / length * (velocity[i + 1] - velocity[i - 1])


@njit(cache=True)
def _tensions(
    position: Array, velocity: Array, stiffness: Array, damping: Array, allow_slack: bool, tension: Array, taut: Array
) -> None:
    """Element tensions, none of them negative where slack is allowed; `taut` is 1 where the element carries load."""
    for j in range(len(stiffness)):
        value = stiffness[j] * (position[j + 1] - position[j]) + damping[j] * (velocity[j + 1] - velocity[j])
        taut[j] = 1.0
        if allow_slack and value <= 0.0:
            value = 0.0
            taut[j] = 0.0
        tension[j] = value


@njit(cache=True)
def _solve_tridiagonal(lower: Array, diagonal: Array, upper: Array, right: Array, n: int) -> None:
    """Solve in place (Thomas); the answer is in `right`."""
    for i in range(1, n):
        factor = lower[i] / diagonal[i - 1]
        diagonal[i] -= factor * upper[i - 1]
        right[i] -= factor * right[i - 1]
    right[n - 1] /= diagonal[n - 1]
    for i in range(n - 2, -1, -1):
        right[i] = (right[i] - upper[i] * right[i + 1]) / diagonal[i]


@njit(cache=True)
def steady_positions(
    top: float, length: float, velocity: float, stiffness: Array, lumps: Array, unit: Array, position: Array
) -> None:
    """Fill P of the steady state in which the whole cable moves at `velocity`: weight and drag against tension.

    `unit` holds mass with added mass [kg], weight [N] and drag [N s2/m2]. A part pushed up by drag is left at its
    unstretched length, not compressed.
    """
    elements = len(stiffness)
    speed_squared = abs(velocity) * velocity
    load = unit[1] + unit[2] * speed_squared
    position[elements] = top - length
    stretch = 0.0
    for j in range(elements):
        load += lumps[1, j] + lumps[2, j] * speed_squared
        position[j] = max(load, 0.0) / stiffness[j]
    for j in range(elements - 1, -1, -1):
        stretch += position[j]
        position[j] = top - length - stretch


@njit(cache=True)
def integrate(
    starts: Array,
    totals: Array,
    densities: Array,
    clumps: Array,
    unit: Array,
    top: Array,
    top_velocity: Array,
    length: Array,
    length_rate: Array,
    h: float,
    substeps: int,
    elements: int,
    allow_slack: bool,
    output: Array,
) -> int:
    """Integrate the axial cable from steady motion; return -1, or the number of the step that Newton could not solve.

    `top`, `top_velocity`, `length`, `length_rate` are given at every substep (period `h`); `output` takes, at every
    `substeps`-th of them, unit elevation [m], unit velocity [m/s], top tension and least tension [N].
    """
    nodes = elements + 1
    stiffness, damping, tension, taut = np.empty(elements), np.empty(elements), np.empty(elements), np.empty(elements)
    lumps = np.empty((3, nodes))
    position, before, earlier = np.empty(nodes), np.empty(nodes), np.empty(nodes)
    velocity, velocity_before, velocity_earlier = np.empty(nodes), np.empty(nodes), np.empty(nodes)
    lower, diagonal, upper, right = np.empty(nodes), np.empty(nodes), np.empty(nodes), np.empty(nodes)

    _discretise(length[0], starts, totals, densities, clumps, stiffness, damping, lumps)
    first_velocity = top_velocity[0] - length_rate[0]
    steady_positions(top[0], length[0], first_velocity, stiffness, lumps, unit, position)
    before[:] = position - h * first_velocity
    velocity[:] = first_velocity
    velocity_before[:] = first_velocity
    _tensions(position, velocity, stiffness, damping, allow_slack, tension, taut)
    for step in range(len(top)):
        if step > 0:
            earlier[:] = before
            before[:] = position
            velocity_earlier[:] = velocity_before
            velocity_before[:] = velocity
            for i in range(nodes):  # start Newton from constant velocity
                position[i] = 2.0 * before[i] - earlier[i]
            _discretise(length[step], starts, totals, densities, clumps, stiffness, damping, lumps)
            position[elements] = top[step] - length[step]
            solved = _newton(
                position, before, earlier, velocity, velocity_before, velocity_earlier, length[step], length_rate[step],
                top_velocity[step], h, stiffness, damping, lumps, unit, allow_slack, tension, taut, lower, diagonal,
                upper, right,
            )  # fmt: skip
            if not solved:
                return step
        if step % substeps == 0:
            row = step // substeps
            speed = velocity[elements]
            top_force = tension[elements - 1] + lumps[1, elements] + lumps[2, elements] * abs(speed) * speed
            if step > 0:
                top_force += lumps[0, elements] * _acceleration(
                    elements, velocity, velocity_before, velocity_earlier, length[step], length_rate[step], h
                )
            output[row, 0] = position[0]
            output[row, 1] = velocity[0]
            output[row, 2] = top_force
            output[row, 3] = tension.min()
    return -1


@njit(cache=True)
def _newton(
    position: Array,
    before: Array,
    earlier: Array,
    velocity: Array,
    velocity_before: Array,
    velocity_earlier: Array,
    length: float,
    rate: float,
    top_velocity: float,
    h: float,
    stiffness: Array,
    damping: Array,
    lumps: Array,
    unit: Array,
    allow_slack: bool,
    tension: Array,
    taut: Array,
    lower: Array,
    diagonal: Array,
    upper: Array,
    right: Array,
) -> bool:
    """Solve one BDF2 step for `position` and leave velocity and tension of the answer; return whether it converged.

    The matrix leaves out terms of second order in (speed of the label)/(size over step), which cost no iteration.
    """
    elements = len(stiffness)
    rate_of_bdf = 1.5 / h
    for _ in range(NEWTON_LIMIT):
        _velocities(position, before, earlier, length, rate, top_velocity, h, velocity)
        _tensions(position, velocity, stiffness, damping, allow_slack, tension, taut)
        for i in range(elements):
            inertia, weight, drag = lumps[0, i], lumps[1, i], lumps[2, i]
            if i == 0:
                inertia, weight, drag = inertia + unit[0], weight + unit[1], drag + unit[2]
            acceleration = _acceleration(i, velocity, velocity_before, velocity_earlier, length, rate, h)
            residual = inertia * acceleration + weight + drag * abs(velocity[i]) * velocity[i] - tension[i]
            above = taut[i] * (stiffness[i] + damping[i] * rate_of_bdf)
            below = 0.0
            if i > 0:
                residual += tension[i - 1]
                below = taut[i - 1] * (stiffness[i - 1] + damping[i - 1] * rate_of_bdf)
            resistance = inertia * rate_of_bdf + 2.0 * drag * abs(velocity[i])
            convection = 0.5 * i * rate / length * (resistance + inertia * rate_of_bdf)
            diagonal[i] = resistance * rate_of_bdf + above + below
            lower[i] = convection - below
            upper[i] = -convection - above
            right[i] = -residual
        _solve_tridiagonal(lower, diagonal, upper, right, elements)
        largest = 0.0
        for i in range(elements):
            position[i] += right[i]
            largest = max(largest, abs(right[i]))
        if not math.isfinite(largest):
            return False
        if largest < NEWTON_TOLERANCE:
            _velocities(position, before, earlier, length, rate, top_velocity, h, velocity)
            _tensions(position, velocity, stiffness, damping, allow_slack, tension, taut)
            return True
    return False
