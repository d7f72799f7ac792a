"""From one end of the cable to the other: the closed form of every segment, joined, with exact derivatives.

Given position and tension vector at s = 0 the whole shape follows (thesis Eq. 2.34-2.39). Drag is part of it: each
segment's drag belongs to its own chord and depth, solved segment by segment, so that no outer drag iteration (thesis
2.5) is left and the derivatives are those of the whole problem.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from cable_sim_node.physics.current import FLOW, current_at
from cable_sim_node.physics.drag import segment_drag
from heave_node.numerics.arrays import Array
from heave_node.numerics.compiled import inner_kernel, kernel

from heave_statics.segment import segment_span
from heave_statics.tables import (
    AXIS_DRAG,
    BODY_DRAG,
    FORCE,
    LENGTH,
    NORMAL,
    STIFFNESS,
    TANGENTIAL,
    WEIGHT,
    CableTables,
    ShapeTables,
)

LOCAL_ITERATIONS = 60
LOCAL_TOLERANCE = 1e-13


class SegmentState(NamedTuple):
    """One segment on the way: what is known at its start, and what is found for it."""

    position: Array  # position of the segment's start [m]
    tension: Array  # tension vector at its start [N]
    span: Array  # from its start to its end [m]
    force: Array  # drag on the segment [N/m]
    load: Array  # drag and weight of the segment [N/m]
    by_tension: Array  # derivative of the span by the tension, shape (3, 3) [m/N]
    by_load: Array  # derivative of the span by the load, shape (3, 3) [m^2/N]
    by_chord: Array  # derivative of the drag by the span, that of its middle's depth included, shape (3, 3) [N/m^2]
    by_depth: Array  # derivative of the drag by the depth of the start, shape (3,) [N/m^2]
    matrix: Array  # I - by_load by_chord, shape (3, 3)


@inner_kernel
def solve3(matrix: Array, right: Array, answer: Array) -> bool:
    """Solve a 3 x 3 system, `matrix` times `answer` = `right`, by Cramer's rule; return False if it is singular."""
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


@inner_kernel
def _pass_node(node: Array, cable: CableTables, at: SegmentState, partials: Array) -> None:
    """Take the forces on a node off the tension vector; `partials` are rows (position, tension) by the six unknowns."""
    flow, gradient = current_at(-at.position[2], cable.current, cable.factor)
    speed = math.sqrt(flow[0] ** 2 + flow[1] ** 2 + flow[2] ** 2)
    slip = flow[0] * gradient[0] + flow[1] * gradient[1] + flow[2] * gradient[2]
    for i in range(3):
        axis = node[AXIS_DRAG + i]
        at.tension[i] -= node[FORCE + i] + axis * abs(flow[i]) * flow[i] + node[BODY_DRAG] * speed * flow[i]
        by_depth = 2.0 * axis * abs(flow[i]) * gradient[i]
        if speed > 0.0:
            by_depth += node[BODY_DRAG] * (speed * gradient[i] + slip * flow[i] / speed)
        for k in range(6):
            partials[3 + i, k] += by_depth * partials[2, k]  # depth = -z


@inner_kernel
def _set_load(row: Array, at: SegmentState) -> None:
    """Set the segment's load to its drag and weight."""
    for i in range(3):
        at.load[i] = at.force[i]
    at.load[2] -= row[WEIGHT]


@inner_kernel
def _solve_drag(row: Array, cable: CableTables, at: SegmentState) -> float:
    """Solve span and drag of one segment together (Newton); return the integral of its tension, NaN if it fails.

    `at.span` is the first guess and the answer.
    """
    by_flow, before, miss = np.empty((3, 3)), np.empty(3), np.empty(3)
    for _ in range(LOCAL_ITERATIONS):
        flow, gradient = current_at(-at.position[2] - 0.5 * at.span[2], cable.current, cable.factor)
        force = segment_drag(at.span, flow, cable.feed, row[NORMAL], row[TANGENTIAL], at.by_chord, by_flow)
        for i in range(3):
            at.by_depth[i] = by_flow[i, 0] * gradient[0] + by_flow[i, 1] * gradient[1] + by_flow[i, 2] * gradient[2]
            at.by_chord[i, 2] -= 0.5 * at.by_depth[i]  # depth = -z
            at.force[i] = force[i]
            before[i] = at.span[i]
        _set_load(row, at)
        integral = segment_span(at.tension, at.load, row[LENGTH], row[STIFFNESS], at.span, at.by_tension, at.by_load)
        largest = 0.0
        for i in range(3):
            miss[i] = at.span[i] - before[i]
            largest = max(largest, abs(miss[i]))
            for j in range(3):
                at.matrix[i, j] = 1.0 if i == j else 0.0
                for k in range(3):
                    at.matrix[i, j] -= at.by_load[i, k] * at.by_chord[k, j]
        if largest < LOCAL_TOLERANCE * row[LENGTH]:
            return integral
        if not solve3(at.matrix, miss, at.span):
            return np.nan
        for i in range(3):
            at.span[i] += before[i]
    return np.nan


@inner_kernel
def _carry_dead(at: SegmentState, partials: Array) -> None:
    """Carry the partials across a segment under a dead load: only its span changes."""
    for k in range(6):
        for i in range(3):
            for j in range(3):
                partials[i, k] += at.by_tension[i, j] * partials[3 + j, k]


@inner_kernel
def _carry_drag(length: float, at: SegmentState, partials: Array) -> bool:
    """Carry the partials across a segment whose drag turns with it; False if its equations are singular."""
    right, change = np.empty(3), np.empty(3)
    for k in range(6):
        for i in range(3):
            right[i] = 0.0
            for j in range(3):
                right[i] += (
                    at.by_tension[i, j] * partials[3 + j, k] - at.by_load[i, j] * at.by_depth[j] * partials[2, k]
                )
        if not solve3(at.matrix, right, change):
            return False
        for i in range(3):
            slope = -at.by_depth[i] * partials[2, k]
            for j in range(3):
                slope += at.by_chord[i, j] * change[j]
            partials[3 + i, k] -= length * slope
        for i in range(3):
            partials[i, k] += change[i]
    return True


@inner_kernel
def _begin(origin: Array, start: Array, partials: Array) -> SegmentState:
    """Return the state at node 0."""
    for i in range(6):
        for k in range(6):
            partials[i, k] = 1.0 if i == k else 0.0
    return SegmentState(
        position=origin.copy(),
        tension=start.copy(),
        span=np.empty(3),
        force=np.zeros(3),
        load=np.empty(3),
        by_tension=np.empty((3, 3)),
        by_load=np.empty((3, 3)),
        by_chord=np.empty((3, 3)),
        by_depth=np.empty(3),
        matrix=np.empty((3, 3)),
    )


@inner_kernel
def _pass_load(length: float, stiffness: float, at: SegmentState) -> float:
    """Go to the segment's end; return the elastic part of its complementary energy [N m]."""
    squares = 0.0
    for i in range(3):
        middle = at.tension[i] - 0.5 * at.load[i] * length
        squares += middle * middle + (at.load[i] * length) ** 2 / 12.0
        at.tension[i] -= at.load[i] * length
        at.position[i] += at.span[i]
    return 0.5 * length * squares / stiffness


@inner_kernel
def _is_moving(cable: CableTables) -> bool:
    """Return whether water flows past the cable anywhere."""
    if cable.feed != 0.0:
        return True
    for row in cable.current:
        if cable.factor != 0.0 and (row[FLOW] != 0.0 or row[FLOW + 1] != 0.0 or row[FLOW + 2] != 0.0):
            return True
    return False


@kernel
def march(cable: CableTables, origin: Array, start: Array, shape: ShapeTables) -> float:
    """Fill the shape from the end s = 0; return its complementary energy [N m], or NaN where a segment has no solution.

    Parameters
    ----------
    cable : cable and current, n segments
    origin : position of node 0 [m]
    start : tension vector below node 0, minus the force that holds the end [N]
    shape : out; unless frozen the rows of its drag are where the search for each segment's drag begins, or NaN to begin
        at the drag of the segment below
    """
    at = _begin(origin, start, shape.partials)
    is_dead = cable.frozen or not _is_moving(cable)
    energy = 0.0
    _pass_node(cable.nodes[0], cable, at, shape.partials)
    for index in range(len(cable.segments)):
        row, drag = cable.segments[index], shape.drag[index]
        length = row[LENGTH]
        for i in range(3):
            shape.positions[index, i] = at.position[i]
            shape.lower[index, i] = at.tension[i]
        if is_dead and not cable.frozen:
            drag[0] = drag[1] = drag[2] = 0.0
        if math.isfinite(drag[0]):
            for i in range(3):
                at.force[i] = drag[i]
        _set_load(row, at)
        integral = segment_span(at.tension, at.load, length, row[STIFFNESS], at.span, at.by_tension, at.by_load)
        if is_dead:
            _carry_dead(at, shape.partials)
        else:
            integral = _solve_drag(row, cable, at)
            if not math.isfinite(integral) or not _carry_drag(length, at, shape.partials):
                return np.nan
        energy += integral + _pass_load(length, row[STIFFNESS], at)
        for i in range(3):
            drag[i] = at.force[i]
            shape.upper[index, i] = at.tension[i]
        _pass_node(cable.nodes[index + 1], cable, at, shape.partials)
    for i in range(3):
        shape.positions[len(cable.segments), i] = at.position[i]
        shape.end[i] = at.tension[i]
    return energy
