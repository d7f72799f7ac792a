"""The three boundary value problems of thesis 2.2.4: submerged, towing and mooring cable."""

from __future__ import annotations

import numpy as np
from cable_sim_node.errors import NoEquilibriumError, StaticsError
from cable_sim_node.physics.current import Current, current_at
from cable_sim_node.physics.drag import segment_drag
from heave_node.numerics.arrays import Array
from numpy.typing import ArrayLike

from heave_statics.dead_loads import EndCondition, solve_dead_loads
from heave_statics.newton import follow_current, solve_newton
from heave_statics.shape import StaticShape, shape_from
from heave_statics.system import StaticCable
from heave_statics.tables import FORCE, LENGTH, NORMAL, STIFFNESS, TANGENTIAL

STILL_WATER = Current()

RELAXATION = (0.3,) * 150 + (0.1,) * 300 + (0.03,) * 600
"""Part of the change in drag that each pass of `_relax_drag` takes: smaller where larger parts go round in circles."""

RELAXATION_TOLERANCE = 1e-9


def submerged_cable(
    cable: StaticCable, start: ArrayLike, end: ArrayLike, current: Current = STILL_WATER
) -> StaticShape:
    """Return the equilibrium of a cable held at both ends (thesis 2.3.1).

    Parameters
    ----------
    cable : the cable, s = 0 at `start`
    start, end : positions of both ends [m], z up
    current : steady current

    Raises
    ------
    StaticsError
        for positions that are not finite, and for a weightless cable longer than its span with no load on it, whose
        shape is not determined.
    NoEquilibriumError
        if the current's answer cannot be reached.
    """
    origin, target = _point(start, "start"), _point(end, "end")
    span = target - origin
    scale = cable.length + float(np.linalg.norm(span))

    def evaluate(unknowns: Array, factor: float, drag: Array | None) -> tuple[Array, Array, StaticShape] | None:
        shape = shape_from(cable, current, origin, unknowns, factor=factor, drag_guess=drag)
        if shape is None:
            return None
        return (shape.positions[-1] - target) / scale, shape.partials[:3, 3:] / scale, shape

    start_tension, drag = _start_of_submerged(cable, current, origin, span)
    if current.is_still and cable.feed == 0.0:
        shape = shape_from(cable, current, origin, start_tension)
        assert shape is not None, "the answer of a search can be marched"
        return shape
    answer = solve_newton(evaluate, start_tension, 1.0)
    if answer is not None:
        return answer[1]
    try:
        return follow_current(evaluate, start_tension, "submerged cable")
    except NoEquilibriumError:
        shape = _relax_drag(cable, current, origin, span, start_tension, drag)
        if shape is None:
            raise
        polished = solve_newton(evaluate, -shape.start_force, 1.0, shape.drag)
        return shape if polished is None else polished[1]


def towing_cable(
    cable: StaticCable, end: ArrayLike, current: Current = STILL_WATER, *, free_force: ArrayLike = (0.0, 0.0, 0.0)
) -> StaticShape:
    """Return the equilibrium of a cable hung at `end` (s = L) with known forces at its free end s = 0 (thesis 2.3.2).

    The shape follows directly from the free end; the only unknown left is its depth, on which current and drag depend.

    Parameters
    ----------
    cable : the cable; the unit is a point load at label 0
    end : position of the held end [m], z up
    current : steady current
    free_force : force on the free end beside the point loads, for example thrust [N]

    Raises
    ------
    NoEquilibriumError
        if there is no depth of the free end that fits.
    """
    target = _point(end, "end")
    start = _point(free_force, "free_force") * -1.0
    scale = cable.length

    def evaluate(unknowns: Array, factor: float, drag: Array | None) -> tuple[Array, Array, StaticShape] | None:
        shape = shape_from(cable, current, unknowns, start, factor=factor, drag_guess=drag)
        if shape is None:
            return None
        return (shape.positions[-1] - target) / scale, shape.partials[:3, :3] / scale, shape

    guess = target - np.array([0.0, 0.0, cable.length])
    still = shape_from(cable, current, guess, start, factor=0.0)
    if still is not None:
        guess = guess + target - still.positions[-1]
    return follow_current(evaluate, guess, "towing cable")


def mooring_cable(
    cable: StaticCable,
    start: ArrayLike,
    height: float,
    horizontal_force: ArrayLike,
    current: Current = STILL_WATER,
) -> StaticShape:
    """Return the equilibrium of a cable anchored at s = 0 whose other end is pulled sideways at a given height (2.3.3).

    Parameters
    ----------
    cable : the cable, s = 0 at the anchor
    start : position of the anchor [m]
    height : z of the other end [m]
    horizontal_force : force x, y on that end [N], beside the point loads there
    current : steady current

    Raises
    ------
    StaticsError
        for values that are not finite, or no pull on a weightless cable.
    NoEquilibriumError
        if no vertical force brings the end to that height, or the current's answer cannot be reached.
    """
    origin = _point(start, "start")
    pull = np.asarray(horizontal_force, dtype=np.float64)
    if pull.shape != (2,) or not (np.all(np.isfinite(pull)) and np.isfinite(height)):
        raise StaticsError(f"horizontal_force must be two finite numbers and height finite; got {pull} and {height}")
    force_scale = float(np.abs(cable.steady_loads[:, 2]) @ cable.segments[:, LENGTH])
    force_scale += float(np.linalg.norm(pull)) + float(np.abs(cable.nodes[:, FORCE : FORCE + 3]).sum())
    if force_scale == 0.0:
        raise StaticsError("the shape of a weightless mooring cable without load is undetermined: give it a load")
    length_scale = cable.length + abs(height - origin[2])

    def evaluate(unknowns: Array, factor: float, drag: Array | None) -> tuple[Array, Array, StaticShape] | None:
        shape = shape_from(cable, current, origin, unknowns, factor=factor, drag_guess=drag)
        if shape is None:
            return None
        residual = np.array([*((shape.end_force[:2] - pull) / force_scale), (shape.positions[-1, 2] - height)])
        jacobian = np.vstack((shape.partials[3:5, 3:] / force_scale, shape.partials[2:3, 3:]))
        residual[2] /= length_scale
        jacobian[2] /= length_scale
        return residual, jacobian, shape

    steady = cable.nodes[:, FORCE : FORCE + 3].sum(axis=0)
    span = np.array([0.0, 0.0, height - origin[2]])
    no_drag = np.zeros_like(cable.steady_loads)
    guess = _catenary_guess(cable, span, no_drag)
    guess[:2] = pull + steady[:2]
    ends = EndCondition(origin, span, known=np.array([True, True, False]))
    start_tension = solve_dead_loads(cable, current, ends, guess, no_drag)
    if start_tension is None:
        raise NoEquilibriumError("mooring cable: no vertical force brings the end to that height")
    return follow_current(evaluate, start_tension, "mooring cable")


def _point(value: ArrayLike, name: str) -> Array:
    point = np.asarray(value, dtype=np.float64)
    if point.shape != (3,) or not np.all(np.isfinite(point)):
        raise StaticsError(f"{name} must be three finite numbers x, y, z; got {value!r}")
    return point


def _start_of_submerged(cable: StaticCable, current: Current, origin: Array, span: Array) -> tuple[Array, Array]:
    """Return the tension vector at s = 0 under dead loads, and the drag that was among them [N/m].

    Drag is none, or where a slack weightless part would leave the shape open in still water, that of a cable along the
    span.
    """
    drag = np.zeros_like(cable.steady_loads)
    is_still = current.is_still and cable.feed == 0.0
    has_weightless_part = bool(np.any(cable.steady_loads[:, 2] == 0.0))
    if has_weightless_part and is_still and not _is_loaded(cable) and np.linalg.norm(span) <= cable.length:
        raise StaticsError(
            "the shape of a weightless cable longer than its span is undetermined in still water: give it a load"
        )
    if has_weightless_part and not is_still:
        drag = _drag_on_chord(cable, current, origin, span)
    guess = _catenary_guess(cable, span, drag)
    tension = solve_dead_loads(cable, current, EndCondition(origin, span), guess, drag)
    if tension is None:
        hint = ": a weightless part of it is slack, and its shape is undetermined" if has_weightless_part else ""
        raise NoEquilibriumError(f"submerged cable: no equilibrium was found under dead loads{hint}")
    return tension, drag


def _is_loaded(cable: StaticCable) -> bool:
    """Whether weight or a point load between the ends pulls the cable into a shape."""
    return bool(np.any(cable.steady_loads) or np.any(cable.nodes[1:-1, FORCE : FORCE + 3]))


def _drag_on_chord(cable: StaticCable, current: Current, origin: Array, span: Array) -> Array:
    """Drag of every segment were it to lie along the span, at its depth there; shape (n, 3) [N/m]."""
    shares = 0.5 * (cable.labels[:-1] + cable.labels[1:]) / cable.length
    chord = span if np.any(span) else np.array([0.0, 0.0, 1.0])
    return _drag_of_segments(cable, current, np.tile(chord, (len(shares), 1)), origin[2] + shares * span[2])


def _drag_of_shape(cable: StaticCable, current: Current, shape: StaticShape) -> Array:
    """Drag of every segment as it lies; shape (n, 3) [N/m]."""
    heights = 0.5 * (shape.positions[:-1, 2] + shape.positions[1:, 2])
    return _drag_of_segments(cable, current, np.diff(shape.positions, axis=0), heights)


def _drag_of_segments(cable: StaticCable, current: Current, chords: Array, heights: Array) -> Array:
    """Drag of every segment along its chord at its height; shape (n, 3) [N/m]."""
    drag, scratch = np.empty_like(chords), (np.empty((3, 3)), np.empty((3, 3)))
    for index, (row, chord, height) in enumerate(zip(cable.segments, chords, heights, strict=True)):
        flow, _ = current_at(-height, current.profile, 1.0)
        drag[index] = segment_drag(chord, flow, cable.feed, row[NORMAL], row[TANGENTIAL], *scratch)
    return drag


def _catenary_guess(cable: StaticCable, span: Array, drag: Array) -> Array:
    """Tension vector at s = 0 of a shallow curve under the mean load: good enough to start a convex search."""
    lengths = cable.segments[:, LENGTH]
    total = lengths @ (cable.steady_loads + drag) + cable.nodes[:, FORCE : FORCE + 3].sum(axis=0)
    distance = float(np.linalg.norm(span))
    stiffness = cable.length / float(np.sum(lengths / cable.segments[:, STIFFNESS]))
    if distance == 0.0:
        return np.asarray(0.5 * total)
    along = span / distance
    across = float(np.linalg.norm(total - along * (total @ along)))
    slack = cable.length / distance - 1.0
    pull = across / np.sqrt(24.0 * max(slack, 1e-6)) + stiffness * max(-slack, 0.0)
    pull = max(pull, 1e-6 * (float(np.linalg.norm(total)) + stiffness * 1e-6))
    return np.asarray(pull * along + 0.5 * total)


def _relax_drag(
    cable: StaticCable, current: Current, origin: Array, span: Array, start: Array, drag: Array
) -> StaticShape | None:
    """Thesis 2.5: solve under the last shape's drag as dead loads, again and again, until drag and shape agree.

    Each solution is certain, for dead loads are convex; taking a part of the change in drag at a time lets a slack
    cable settle as it would in the water. Slow, so the last resort. None if it does not settle.
    """
    tension = start
    for part in RELAXATION:
        answer = solve_dead_loads(cable, current, EndCondition(origin, span), tension, drag, factor=1.0)
        shape = None if answer is None else shape_from(cable, current, origin, answer, frozen_drag=drag)
        if answer is None or shape is None:
            return None
        change = _drag_of_shape(cable, current, shape) - drag
        if float(np.abs(change).max()) < RELAXATION_TOLERANCE * (1e-12 + float(np.abs(drag).max())):
            return shape
        drag = drag + part * change
        tension = answer
    return None
