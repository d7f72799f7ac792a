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
from heave_node.numerics.compiled import inner_kernel

from cable_sim_node.vertical import axial_layout as at

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
    while number > 0 and label < sections[number, at.START]:
        number -= 1
    row = sections[number]
    span = label - row[at.START]
    return (
        row[at.TOTAL + at.COMPLIANCE] + row[at.DENSITY + at.COMPLIANCE] * span,
        row[at.TOTAL + at.MASS] + row[at.DENSITY + at.MASS] * span,
        row[at.TOTAL + at.WEIGHT] + row[at.DENSITY + at.WEIGHT] * span,
        row[at.TOTAL + at.DRAG] + row[at.DENSITY + at.DRAG] * span,
        row[at.TOTAL + at.DELAY] + row[at.DENSITY + at.DELAY] * span,
    )


@inner_kernel
def discretise(length: float, line: at.AxialArrays) -> None:
    """Set stiffness and damping of the elements and the lumps on the nodes for `length` [m] of cable.

    A body between two nodes is shared by the law of the lever, so that it passes them smoothly.
    """
    nodes, elements = line.nodes, line.elements
    size = length / len(elements)
    for node in nodes:
        node[at.LUMP_MASS] = node[at.LUMP_WEIGHT] = node[at.LUMP_DRAG] = 0.0
    low = amounts_below(0.0, line.sections)
    for j in range(len(elements)):
        high = amounts_below((j + 1) * size, line.sections)
        element = elements[j]
        element[at.STIFFNESS] = 1.0 / (high[at.COMPLIANCE] - low[at.COMPLIANCE])
        element[at.DAMPING] = element[at.STIFFNESS] * (high[at.DELAY] - low[at.DELAY]) / size
        for node in (nodes[j], nodes[j + 1]):
            node[at.LUMP_MASS] += 0.5 * (high[at.MASS] - low[at.MASS])
            node[at.LUMP_WEIGHT] += 0.5 * (high[at.WEIGHT] - low[at.WEIGHT])
            node[at.LUMP_DRAG] += 0.5 * (high[at.DRAG] - low[at.DRAG])
        low = high
    for body in line.bodies:
        if body[at.LABEL] <= length:
            j = min(int(body[at.LABEL] / size), len(elements) - 1)
            share = body[at.LABEL] / size - j
            add_lump(nodes[j], body, 1.0 - share)
            add_lump(nodes[j + 1], body, share)


@inner_kernel
def add_lump(node: Array, body: Array, share: float) -> None:
    """Add a share of a body to a node's lump."""
    node[at.LUMP_MASS] += share * body[at.BODY_INERTIA]
    node[at.LUMP_WEIGHT] += share * body[at.BODY_WEIGHT]
    node[at.LUMP_DRAG] += share * body[at.BODY_DRAG]


@inner_kernel
def set_velocities(nodes: Array, motion: Array, h: float) -> None:
    """Set the material velocities from BDF2 in time and central differences in the convective term."""
    elements = len(nodes) - 1
    length, rate = motion[at.LENGTH], motion[at.LENGTH_RATE]
    for i in range(elements):
        node = nodes[i]
        velocity = (3.0 * node[at.POSITION] - 4.0 * node[at.BEFORE] + node[at.EARLIER]) / (2.0 * h)
        if i > 0:
            convection = 0.5 * i * rate / length
            velocity -= convection * (nodes[i + 1, at.POSITION] - nodes[i - 1, at.POSITION])
        node[at.VELOCITY] = velocity
    strain = (nodes[elements, at.POSITION] - nodes[elements - 1, at.POSITION]) * elements / length
    nodes[elements, at.VELOCITY] = motion[at.TOP_VELOCITY] - rate * (1.0 + strain)


@inner_kernel
def acceleration_of(i: int, nodes: Array, motion: Array, h: float) -> float:
    """Return the material acceleration of node `i`; one-sided at the top, where the cable ends."""
    elements = len(nodes) - 1
    length, rate = motion[at.LENGTH], motion[at.LENGTH_RATE]
    node = nodes[i]
    local = (3.0 * node[at.VELOCITY] - 4.0 * node[at.VELOCITY_BEFORE] + node[at.VELOCITY_EARLIER]) / (2.0 * h)
    if i == 0:
        return local
    if i == elements:
        return local - i * rate / length * (node[at.VELOCITY] - nodes[i - 1, at.VELOCITY])
    return local - 0.5 * i * rate / length * (nodes[i + 1, at.VELOCITY] - nodes[i - 1, at.VELOCITY])


@inner_kernel
def set_tensions(line: at.AxialArrays) -> None:
    """Set the tensions of the elements, none of them negative unless the material is linear."""
    for j in range(len(line.elements)):
        element, low, high = line.elements[j], line.nodes[j], line.nodes[j + 1]
        tension = element[at.STIFFNESS] * (high[at.POSITION] - low[at.POSITION])
        tension += element[at.DAMPING] * (high[at.VELOCITY] - low[at.VELOCITY])
        is_slack = tension <= 0.0 and not line.is_linear
        element[at.TENSION] = 0.0 if is_slack else tension
        element[at.TAUT] = 0.0 if is_slack else 1.0


@inner_kernel
def solve_tridiagonal(count: int, nodes: Array) -> None:
    """Solve the equations of nodes 0..count-1 in place (Thomas); the answer is in RIGHT."""
    for i in range(1, count):
        row, below = nodes[i], nodes[i - 1]
        factor = row[at.LOWER] / below[at.DIAGONAL]
        row[at.DIAGONAL] -= factor * below[at.UPPER]
        row[at.RIGHT] -= factor * below[at.RIGHT]
    nodes[count - 1, at.RIGHT] /= nodes[count - 1, at.DIAGONAL]
    for i in range(count - 2, -1, -1):
        nodes[i, at.RIGHT] = (nodes[i, at.RIGHT] - nodes[i, at.UPPER] * nodes[i + 1, at.RIGHT]) / nodes[i, at.DIAGONAL]


@inner_kernel
def start_steadily(line: at.AxialArrays, motion: Array, h: float) -> None:
    """Set the steady state in which the whole cable moves at the speed of its top end: weight and drag against tension.

    A part that is pushed up by drag is left at its unstretched length, not compressed.
    """
    nodes, elements = line.nodes, line.elements
    discretise(motion[at.LENGTH], line)
    velocity = motion[at.TOP_VELOCITY] - motion[at.LENGTH_RATE]
    speed_squared = abs(velocity) * velocity
    load = line.unit[at.UNIT_WEIGHT] + line.unit[at.UNIT_DRAG] * speed_squared
    nodes[-1, at.POSITION] = motion[at.TOP] - motion[at.LENGTH]
    for j in range(len(elements)):
        load += nodes[j, at.LUMP_WEIGHT] + nodes[j, at.LUMP_DRAG] * speed_squared
        nodes[j, at.POSITION] = max(load, 0.0) / elements[j, at.STIFFNESS]
    stretch = 0.0
    for j in range(len(elements) - 1, -1, -1):
        stretch += nodes[j, at.POSITION]
        nodes[j, at.POSITION] = motion[at.TOP] - motion[at.LENGTH] - stretch
    for node in nodes:
        node[at.BEFORE] = node[at.POSITION] - h * velocity
        node[at.VELOCITY] = node[at.VELOCITY_BEFORE] = velocity
    set_tensions(line)


@inner_kernel
def begin_step(line: at.AxialArrays, motion: Array) -> None:
    """Make the present the past, and start Newton from constant velocity."""
    for node in line.nodes:
        node[at.EARLIER] = node[at.BEFORE]
        node[at.BEFORE] = node[at.POSITION]
        node[at.VELOCITY_EARLIER] = node[at.VELOCITY_BEFORE]
        node[at.VELOCITY_BEFORE] = node[at.VELOCITY]
        node[at.POSITION] = 2.0 * node[at.BEFORE] - node[at.EARLIER]
    discretise(motion[at.LENGTH], line)
    line.nodes[-1, at.POSITION] = motion[at.TOP] - motion[at.LENGTH]


@inner_kernel
def assemble(line: at.AxialArrays, motion: Array, h: float) -> None:
    """Set the linear equations of all nodes but the top one.

    The matrix leaves out terms of second order in (speed of the label)/(size over step), which cost no iteration.
    """
    length, rate = motion[at.LENGTH], motion[at.LENGTH_RATE]
    rate_of_bdf = 1.5 / h
    below, tension_below = 0.0, 0.0
    for i in range(len(line.elements)):
        node, element = line.nodes[i], line.elements[i]
        inertia, weight, drag = node[at.LUMP_MASS], node[at.LUMP_WEIGHT], node[at.LUMP_DRAG]
        if i == 0:
            inertia += line.unit[at.UNIT_INERTIA]
            weight += line.unit[at.UNIT_WEIGHT]
            drag += line.unit[at.UNIT_DRAG]
        velocity = node[at.VELOCITY]
        residual = inertia * acceleration_of(i, line.nodes, motion, h) + weight + drag * abs(velocity) * velocity
        residual -= element[at.TENSION]
        residual += tension_below
        above = element[at.TAUT] * (element[at.STIFFNESS] + element[at.DAMPING] * rate_of_bdf)
        resistance = inertia * rate_of_bdf + 2.0 * drag * abs(velocity)
        convection = 0.5 * i * rate / length * (resistance + inertia * rate_of_bdf)
        node[at.DIAGONAL] = resistance * rate_of_bdf + above + below
        node[at.LOWER] = convection - below
        node[at.UPPER] = -convection - above
        node[at.RIGHT] = -residual
        below, tension_below = above, element[at.TENSION]


@inner_kernel
def solve_step(line: at.AxialArrays, motion: Array, h: float) -> bool:
    """Solve one BDF2 step by Newton and leave velocities and tensions of the answer; return whether it converged."""
    count = len(line.elements)
    for _ in range(NEWTON_LIMIT):
        set_velocities(line.nodes, motion, h)
        set_tensions(line)
        assemble(line, motion, h)
        solve_tridiagonal(count, line.nodes)
        largest = 0.0
        for i in range(count):
            line.nodes[i, at.POSITION] += line.nodes[i, at.RIGHT]
            largest = max(largest, abs(line.nodes[i, at.RIGHT]))
        if not math.isfinite(largest):
            return False
        if largest < NEWTON_TOLERANCE:
            set_velocities(line.nodes, motion, h)
            set_tensions(line)
            return True
    return False


@inner_kernel
def write_answer(line: at.AxialArrays, motion: Array, h: float, is_first: bool, answer: Array) -> None:
    """Write a sample to `answer`: motion of the unit, top and least tension.

    Nothing is known of the acceleration at the first one (`is_first`).
    """
    top, speed = line.nodes[-1], line.nodes[-1, at.VELOCITY]
    top_tension = line.elements[-1, at.TENSION] + top[at.LUMP_WEIGHT] + top[at.LUMP_DRAG] * abs(speed) * speed
    if not is_first:
        top_tension += top[at.LUMP_MASS] * acceleration_of(len(line.elements), line.nodes, motion, h)
    answer[at.UNIT_ELEVATION] = line.nodes[0, at.POSITION]
    answer[at.UNIT_VELOCITY] = line.nodes[0, at.VELOCITY]
    answer[at.TOP_TENSION] = top_tension
    answer[at.LEAST_TENSION] = line.elements[0, at.TENSION]
    for element in line.elements:
        answer[at.LEAST_TENSION] = min(answer[at.LEAST_TENSION], element[at.TENSION])
