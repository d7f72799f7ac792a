"""Time integration of the axial cable on a fixed domain (thesis 3.2), in numba.

Material is counted from the unit: label s in [0, L(t)], s = 0 at the unit. With y = s/L(t) the domain is [0, 1] and

    d/dt|material = d/dt - (y L'/L) d/dy

so that the unit (y = 0) has no convective term and new cable enters at y = 1, where the top's position is given. The
unknown is P = z - s, the elevation of a material point less its label: smooth, and equal to the unit's elevation where
the cable is rigid. Space: N linear elements, lumped mass. Time: BDF2 as in thesis 3.2.6 (damps what the mesh cannot
resolve), solved by Newton with a tridiagonal matrix, so that slack and quadratic drag are implicit.

Arguments have the same names everywhere: `line` the arrays, `nodes` its nodes, `motion` the top's motion at the end of
the step (a row of TOP to LENGTH_RATE), `h` the step [s].
"""

from __future__ import annotations

import math

from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel, kernel

from cable_sim_node.vertical.axial_layout import (
    BEFORE,
    BODY_DRAG,
    BODY_INERTIA,
    BODY_WEIGHT,
    COMPLIANCE,
    DAMPING,
    DELAY,
    DENSITY,
    DIAGONAL,
    DRAG,
    EARLIER,
    LABEL,
    LEAST_TENSION,
    LENGTH,
    LENGTH_RATE,
    LOWER,
    LUMP_DRAG,
    LUMP_MASS,
    LUMP_WEIGHT,
    MASS,
    POSITION,
    RIGHT,
    START,
    STIFFNESS,
    TAUT,
    TENSION,
    TOP,
    TOP_TENSION,
    TOP_VELOCITY,
    TOTAL,
    UNIT_DRAG,
    UNIT_ELEVATION,
    UNIT_INERTIA,
    UNIT_VELOCITY,
    UNIT_WEIGHT,
    UPPER,
    VELOCITY,
    VELOCITY_BEFORE,
    VELOCITY_EARLIER,
    WEIGHT,
    AxialArrays,
)

NEWTON_LIMIT = 60
NEWTON_TOLERANCE = 1e-10
"""Largest last correction of a position [m] at which a step counts as solved."""

Amounts = tuple[float, float, float, float, float]


@inner_kernel
def amounts_below(label: float, sections: Array) -> Amounts:
    """Return the integrals of compliance, mass, weight, drag and delay from the unit to `label` [m].

    They are constant in each of the `sections`; the last one has no end.
    """
    number = len(sections) - 1
    while number > 0 and label < sections[number, START]:
        number -= 1
    row = sections[number]
    span = label - row[START]
    return (
        row[TOTAL + COMPLIANCE] + row[DENSITY + COMPLIANCE] * span,
        row[TOTAL + MASS] + row[DENSITY + MASS] * span,
        row[TOTAL + WEIGHT] + row[DENSITY + WEIGHT] * span,
        row[TOTAL + DRAG] + row[DENSITY + DRAG] * span,
        row[TOTAL + DELAY] + row[DENSITY + DELAY] * span,
    )


@inner_kernel
def discretise(length: float, line: AxialArrays) -> None:
    """Set stiffness and damping of the elements and the lumps on the nodes for `length` [m] of cable.

    A body between two nodes is shared by the law of the lever, so that it passes them smoothly.
    """
    nodes, elements = line.nodes, line.elements
    size = length / len(elements)
    for node in nodes:
        node[LUMP_MASS] = node[LUMP_WEIGHT] = node[LUMP_DRAG] = 0.0
    low = amounts_below(0.0, line.sections)
    for j in range(len(elements)):
        high = amounts_below((j + 1) * size, line.sections)
        element = elements[j]
        element[STIFFNESS] = 1.0 / (high[COMPLIANCE] - low[COMPLIANCE])
        element[DAMPING] = element[STIFFNESS] * (high[DELAY] - low[DELAY]) / size
        for node in (nodes[j], nodes[j + 1]):
            node[LUMP_MASS] += 0.5 * (high[MASS] - low[MASS])
            node[LUMP_WEIGHT] += 0.5 * (high[WEIGHT] - low[WEIGHT])
            node[LUMP_DRAG] += 0.5 * (high[DRAG] - low[DRAG])
        low = high
    for body in line.bodies:
        if body[LABEL] <= length:
            j = min(int(body[LABEL] / size), len(elements) - 1)
            share = body[LABEL] / size - j
            add_lump(nodes[j], body, 1.0 - share)
            add_lump(nodes[j + 1], body, share)


@inner_kernel
def add_lump(node: Array, body: Array, share: float) -> None:
    """Add a share of a body to a node's lump."""
    node[LUMP_MASS] += share * body[BODY_INERTIA]
    node[LUMP_WEIGHT] += share * body[BODY_WEIGHT]
    node[LUMP_DRAG] += share * body[BODY_DRAG]


@inner_kernel
def set_velocities(nodes: Array, motion: Array, h: float) -> None:
    """Set the material velocities from BDF2 in time and central differences in the convective term."""
    elements = len(nodes) - 1
    length, rate = motion[LENGTH], motion[LENGTH_RATE]
    for i in range(elements):
        node = nodes[i]
        velocity = (3.0 * node[POSITION] - 4.0 * node[BEFORE] + node[EARLIER]) / (2.0 * h)
        if i > 0:
            convection = 0.5 * i * rate / length
            velocity -= convection * (nodes[i + 1, POSITION] - nodes[i - 1, POSITION])
        node[VELOCITY] = velocity
    strain = (nodes[elements, POSITION] - nodes[elements - 1, POSITION]) * elements / length
    nodes[elements, VELOCITY] = motion[TOP_VELOCITY] - rate * (1.0 + strain)


@inner_kernel
def acceleration_of(i: int, nodes: Array, motion: Array, h: float) -> float:
    """Return the material acceleration of node `i`; one-sided at the top, where the cable ends."""
    elements = len(nodes) - 1
    length, rate = motion[LENGTH], motion[LENGTH_RATE]
    node = nodes[i]
    local = (3.0 * node[VELOCITY] - 4.0 * node[VELOCITY_BEFORE] + node[VELOCITY_EARLIER]) / (2.0 * h)
    if i == 0:
        return local
    if i == elements:
        return local - i * rate / length * (node[VELOCITY] - nodes[i - 1, VELOCITY])
    return local - 0.5 * i * rate / length * (nodes[i + 1, VELOCITY] - nodes[i - 1, VELOCITY])


@inner_kernel
def set_tensions(line: AxialArrays) -> None:
    """Set the tensions of the elements, none of them negative unless the material is linear."""
    for j in range(len(line.elements)):
        element, low, high = line.elements[j], line.nodes[j], line.nodes[j + 1]
        tension = element[STIFFNESS] * (high[POSITION] - low[POSITION])
        tension += element[DAMPING] * (high[VELOCITY] - low[VELOCITY])
        is_slack = tension <= 0.0 and not line.is_linear
        element[TENSION] = 0.0 if is_slack else tension
        element[TAUT] = 0.0 if is_slack else 1.0


@inner_kernel
def solve_tridiagonal(count: int, nodes: Array) -> None:
    """Solve the equations of nodes 0..count-1 in place (Thomas); the answer is in RIGHT."""
    for i in range(1, count):
        row, below = nodes[i], nodes[i - 1]
        factor = row[LOWER] / below[DIAGONAL]
        row[DIAGONAL] -= factor * below[UPPER]
        row[RIGHT] -= factor * below[RIGHT]
    nodes[count - 1, RIGHT] /= nodes[count - 1, DIAGONAL]
    for i in range(count - 2, -1, -1):
        nodes[i, RIGHT] = (nodes[i, RIGHT] - nodes[i, UPPER] * nodes[i + 1, RIGHT]) / nodes[i, DIAGONAL]


@inner_kernel
def start_steadily(line: AxialArrays, motion: Array, h: float) -> None:
    """Set the steady state in which the whole cable moves at the speed of its top end: weight and drag against tension.

    A part that is pushed up by drag is left at its unstretched length, not compressed.
    """
    nodes, elements = line.nodes, line.elements
    discretise(motion[LENGTH], line)
    velocity = motion[TOP_VELOCITY] - motion[LENGTH_RATE]
    speed_squared = abs(velocity) * velocity
    load = line.unit[UNIT_WEIGHT] + line.unit[UNIT_DRAG] * speed_squared
    nodes[-1, POSITION] = motion[TOP] - motion[LENGTH]
    for j in range(len(elements)):
        load += nodes[j, LUMP_WEIGHT] + nodes[j, LUMP_DRAG] * speed_squared
        nodes[j, POSITION] = max(load, 0.0) / elements[j, STIFFNESS]
    stretch = 0.0
    for j in range(len(elements) - 1, -1, -1):
        stretch += nodes[j, POSITION]
        nodes[j, POSITION] = motion[TOP] - motion[LENGTH] - stretch
    for node in nodes:
        node[BEFORE] = node[POSITION] - h * velocity
        node[VELOCITY] = node[VELOCITY_BEFORE] = velocity
    set_tensions(line)


@inner_kernel
def begin_step(line: AxialArrays, motion: Array) -> None:
    """Make the present the past, and start Newton from constant velocity."""
    for node in line.nodes:
        node[EARLIER] = node[BEFORE]
        node[BEFORE] = node[POSITION]
        node[VELOCITY_EARLIER] = node[VELOCITY_BEFORE]
        node[VELOCITY_BEFORE] = node[VELOCITY]
        node[POSITION] = 2.0 * node[BEFORE] - node[EARLIER]
    discretise(motion[LENGTH], line)
    line.nodes[-1, POSITION] = motion[TOP] - motion[LENGTH]


@inner_kernel
def assemble(line: AxialArrays, motion: Array, h: float) -> None:
    """Set the linear equations of all nodes but the top one.

    The matrix leaves out terms of second order in (speed of the label)/(size over step), which cost no iteration.
    """
    length, rate = motion[LENGTH], motion[LENGTH_RATE]
    rate_of_bdf = 1.5 / h
    below, tension_below = 0.0, 0.0
    for i in range(len(line.elements)):
        node, element = line.nodes[i], line.elements[i]
        inertia, weight, drag = node[LUMP_MASS], node[LUMP_WEIGHT], node[LUMP_DRAG]
        if i == 0:
            inertia += line.unit[UNIT_INERTIA]
            weight += line.unit[UNIT_WEIGHT]
            drag += line.unit[UNIT_DRAG]
        velocity = node[VELOCITY]
        residual = inertia * acceleration_of(i, line.nodes, motion, h) + weight + drag * abs(velocity) * velocity
        residual -= element[TENSION]
        residual += tension_below
        above = element[TAUT] * (element[STIFFNESS] + element[DAMPING] * rate_of_bdf)
        resistance = inertia * rate_of_bdf + 2.0 * drag * abs(velocity)
        convection = 0.5 * i * rate / length * (resistance + inertia * rate_of_bdf)
        node[DIAGONAL] = resistance * rate_of_bdf + above + below
        node[LOWER] = convection - below
        node[UPPER] = -convection - above
        node[RIGHT] = -residual
        below, tension_below = above, element[TENSION]


@inner_kernel
def solve_step(line: AxialArrays, motion: Array, h: float) -> bool:
    """Solve one BDF2 step by Newton and leave velocities and tensions of the answer; return whether it converged."""
    count = len(line.elements)
    for _ in range(NEWTON_LIMIT):
        set_velocities(line.nodes, motion, h)
        set_tensions(line)
        assemble(line, motion, h)
        solve_tridiagonal(count, line.nodes)
        largest = 0.0
        for i in range(count):
            line.nodes[i, POSITION] += line.nodes[i, RIGHT]
            largest = max(largest, abs(line.nodes[i, RIGHT]))
        if not math.isfinite(largest):
            return False
        if largest < NEWTON_TOLERANCE:
            set_velocities(line.nodes, motion, h)
            set_tensions(line)
            return True
    return False


@inner_kernel
def write_answer(line: AxialArrays, motion: Array, h: float, is_first: bool, answer: Array) -> None:
    """Write a sample to `answer`: motion of the unit, top and least tension.

    Nothing is known of the acceleration at the first one (`is_first`).
    """
    top, speed = line.nodes[-1], line.nodes[-1, VELOCITY]
    top_tension = line.elements[-1, TENSION] + top[LUMP_WEIGHT] + top[LUMP_DRAG] * abs(speed) * speed
    if not is_first:
        top_tension += top[LUMP_MASS] * acceleration_of(len(line.elements), line.nodes, motion, h)
    answer[UNIT_ELEVATION] = line.nodes[0, POSITION]
    answer[UNIT_VELOCITY] = line.nodes[0, VELOCITY]
    answer[TOP_TENSION] = top_tension
    answer[LEAST_TENSION] = line.elements[0, TENSION]
    for element in line.elements:
        answer[LEAST_TENSION] = min(answer[LEAST_TENSION], element[TENSION])


@kernel
def integrate(line: AxialArrays, motion: Array, h: float, substeps: int, answer: Array) -> int:
    """Integrate the axial cable from steady motion; return -1, or the number of the step that Newton could not solve.

    Parameters
    ----------
    line : cable, unit and bodies; nodes and elements are filled
    motion : of the top at every step, columns TOP to LENGTH_RATE
    h : step [s]
    substeps : steps from sample to sample
    answer : out, a row for every sample
    """
    start_steadily(line, motion[0], h)
    for step in range(len(motion)):
        is_first = step == 0
        if not is_first:
            begin_step(line, motion[step])
            if not solve_step(line, motion[step], h):
                return step
        if step % substeps == 0:
            write_answer(line, motion[step], h, is_first, answer[step // substeps])
    return -1
