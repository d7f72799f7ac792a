"""From one end of the cable to the other: the closed form of every segment, joined, with exact derivatives.

Given position and tension vector at s = 0 the whole shape follows (thesis Eq. 2.34-2.39). Drag is part of it: each
segment's drag belongs to its own chord and depth, solved segment by segment, so that no outer drag iteration (thesis
2.5) is left and the derivatives are those of the whole problem.
"""

from __future__ import annotations

import math

import numpy as np
from heave_node.arrays import Array
from numba import njit

from cable_sim_node.statics.drag import current_at, segment_drag
from cable_sim_node.statics.segment import segment_span

# columns of the segment table: unstretched length [m], EA [N], weight in water [N/m], drag factors [N s2/m3]
LENGTH, STIFFNESS, WEIGHT, NORMAL, TANGENTIAL = range(5)
SEGMENT_COLUMNS = 5

# columns of the node table: steady force x, y, z [N]; drag per axis x, y, z and drag of a body [N s2/m2]
FORCE, AXIS_DRAG, BODY_DRAG = 0, 3, 6
NODE_COLUMNS = 7

LOCAL_ITERATIONS = 60
LOCAL_TOLERANCE = 1e-13


@njit(cache=True, error_model="numpy")
def solve3(matrix: Array, right: Array, answer: Array) -> bool:
    """Solve a 3 x 3 system by Cramer's rule; return False if it is singular."""
    a, b, c = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    d, e, f = matrix[1, 0], matrix[1, 1], matrix[1, 2]
    g, h, i = matrix[2, 0], matrix[2, 1], matrix[2, 2]
    cofactor0, cofactor1, cofactor2 = e * i - f * h, f * g - d * i, d * h - e * g
    determinant = a * cofactor0 + b * cofactor1 + c * cofactor2
    if determinant == 0.0 or not math.isfinite(determinant):
        return False
    x, y, z = right[0], right[1], right[2]
    answer[0] = (x * cofactor0 + y * (c * h - b * i) + z * (b * f - c * e)) / determinant
    answer[1] = (x * cofactor1 + y * (a * i - c * g) + z * (c * d - a * f)) / determinant
    answer[2] = (x * cofactor2 + y * (b * g - a * h) + z * (a * e - b * d)) / determinant
    return True


@njit(cache=True, error_model="numpy")
def _pass_node(
    node: Array, position: Array, depths: Array, velocities: Array, factor: float, tension: Array, partials: Array
) -> None:
    """Take the forces on a node off the tension vector; `partials` are rows (position, tension) by the six unknowns."""
    flow, gradient = np.empty(3), np.empty(3)
    current_at(-position[2], depths, velocities, factor, flow, gradient)
    speed = math.sqrt(flow[0] ** 2 + flow[1] ** 2 + flow[2] ** 2)
    slip = flow[0] * gradient[0] + flow[1] * gradient[1] + flow[2] * gradient[2]
    for i in range(3):
        axis = node[AXIS_DRAG + i]
        tension[i] -= node[FORCE + i] + axis * abs(flow[i]) * flow[i] + node[BODY_DRAG] * speed * flow[i]
        by_depth = 2.0 * axis * abs(flow[i]) * gradient[i]
        if speed > 0.0:
            by_depth += node[BODY_DRAG] * (speed * gradient[i] + slip * flow[i] / speed)
        for k in range(6):
            partials[3 + i, k] += by_depth * partials[2, k]  # depth = -z


@njit(cache=True, error_model="numpy")
def _drag_and_span(
    row: Array,
    position: Array,
    tension: Array,
    depths: Array,
    velocities: Array,
    factor: float,
    feed: float,
    span: Array,
    force: Array,
    by_tension: Array,
    by_load: Array,
    by_chord: Array,
    by_depth: Array,
    matrix: Array,
) -> float:
    """Solve span and drag of one segment together (Newton); return the integral of its tension, NaN if it fails.

    `span` is the first guess and the answer; `by_chord` and `by_depth` are the derivatives of the drag by the span (the
    depth of its middle included) and by the depth of its start, `matrix` is I - by_load by_chord.
    """
    flow, gradient, by_flow = np.empty(3), np.empty(3), np.empty((3, 3))
    load, before, miss = np.empty(3), np.empty(3), np.empty(3)
    for _ in range(LOCAL_ITERATIONS):
        current_at(-position[2] - 0.5 * span[2], depths, velocities, factor, flow, gradient)
        segment_drag(span, flow, feed, row[NORMAL], row[TANGENTIAL], force, by_chord, by_flow)
        for i in range(3):
            by_depth[i] = by_flow[i, 0] * gradient[0] + by_flow[i, 1] * gradient[1] + by_flow[i, 2] * gradient[2]
            by_chord[i, 2] -= 0.5 * by_depth[i]  # depth = -z
            load[i] = force[i]
            before[i] = span[i]
        load[2] -= row[WEIGHT]
        integral = segment_span(tension, load, row[LENGTH], row[STIFFNESS], span, by_tension, by_load)
        largest = 0.0
        for i in range(3):
            miss[i] = span[i] - before[i]
            largest = max(largest, abs(miss[i]))
            for j in range(3):
                matrix[i, j] = 1.0 if i == j else 0.0
                for k in range(3):
                    matrix[i, j] -= by_load[i, k] * by_chord[k, j]
        if largest < LOCAL_TOLERANCE * row[LENGTH]:
            return integral
        if not solve3(matrix, miss, span):
            return np.nan
        for i in range(3):
            span[i] += before[i]
    return np.nan


@njit(cache=True, error_model="numpy")
def _carry_dead(by_tension: Array, partials: Array) -> None:
    """Carry the partials across a segment under a dead load: only its span changes."""
    for k in range(6):
        for i in range(3):
            for j in range(3):
                partials[i, k] += by_tension[i, j] * partials[3 + j, k]


@njit(cache=True, error_model="numpy")
def _carry_drag(
    length: float, by_tension: Array, by_load: Array, by_chord: Array, by_depth: Array, matrix: Array, partials: Array
) -> bool:
    """Carry the partials across a segment whose drag turns with it; False if its equations are singular."""
    right, change = np.empty(3), np.empty(3)
    for k in range(6):
        for i in range(3):
            right[i] = 0.0
            for j in range(3):
                right[i] += by_tension[i, j] * partials[3 + j, k] - by_load[i, j] * by_depth[j] * partials[2, k]
        if not solve3(matrix, right, change):
            return False
        for i in range(3):
            slope = -by_depth[i] * partials[2, k]
            for j in range(3):
                slope += by_chord[i, j] * change[j]
            partials[3 + i, k] -= length * slope
        for i in range(3):
            partials[i, k] += change[i]
    return True


@njit(cache=True, error_model="numpy")
def march(
    origin: Array,
    start: Array,
    segments: Array,
    nodes: Array,
    depths: Array,
    velocities: Array,
    factor: float,
    feed: float,
    frozen: bool,
    drag: Array,
    positions: Array,
    lower: Array,
    upper: Array,
    end: Array,
    partials: Array,
) -> float:
    """Fill the shape from the end s = 0; return its complementary energy [N m], or NaN where a segment has no solution.

    Parameters
    ----------
    origin : position of node 0 [m]
    start : tension vector below node 0, minus the force that holds the end [N]
    segments, nodes : tables with the columns above, n and n + 1 rows
    depths, velocities, factor : the current, as `current_at` takes it
    feed : see `segment_drag`
    frozen : True takes the segments' drag from `drag` as a dead load, False computes it and leaves it in `drag`
    drag : shape (n, 3) [N/m]; unless frozen its rows are where the search for each segment's drag begins, or NaN to
        begin at the drag of the segment below
    positions : out, shape (n + 1, 3) [m]
    lower, upper : out, shape (n, 3), tension vectors at each segment's two ends [N]
    end : out, tension vector beyond node n: the force that holds the other end [N]
    partials : out, shape (6, 6): (position of node n, `end`) by (origin, start)
    """
    count = len(segments)
    position, tension = origin.copy(), start.copy()
    span, load, force = np.empty(3), np.empty(3), np.zeros(3)
    by_tension, by_load, by_chord = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    by_depth, matrix = np.empty(3), np.empty((3, 3))
    partials[:] = 0.0
    for i in range(6):
        partials[i, i] = 1.0
    is_dead = frozen or (feed == 0.0 and (factor == 0.0 or not np.any(velocities)))
    energy = 0.0
    _pass_node(nodes[0], position, depths, velocities, factor, tension, partials)
    for index in range(count):
        row = segments[index]
        length = row[LENGTH]
        positions[index] = position
        lower[index] = tension
        if is_dead and not frozen:
            force[:] = 0.0
        elif math.isfinite(drag[index, 0]):
            force[:] = drag[index]
        load[:] = force
        load[2] -= row[WEIGHT]
        integral = segment_span(tension, load, length, row[STIFFNESS], span, by_tension, by_load)
        if is_dead:
            _carry_dead(by_tension, partials)
        else:
            integral = _drag_and_span(
                row, position, tension, depths, velocities, factor, feed, span, force, by_tension, by_load, by_chord,
                by_depth, matrix,
            )  # fmt: skip
            if not math.isfinite(integral) or not _carry_drag(
                length, by_tension, by_load, by_chord, by_depth, matrix, partials
            ):
                return np.nan
            load[:] = force
            load[2] -= row[WEIGHT]
        drag[index] = force
        squares = 0.0
        for i in range(3):
            middle = tension[i] - 0.5 * load[i] * length
            squares += middle * middle + (load[i] * length) ** 2 / 12.0
            tension[i] -= load[i] * length
            position[i] += span[i]
        energy += integral + 0.5 * length * squares / row[STIFFNESS]
        upper[index] = tension
        _pass_node(nodes[index + 1], position, depths, velocities, factor, tension, partials)
    positions[count] = position
    end[:] = tension
    return energy
