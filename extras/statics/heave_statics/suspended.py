"""From the parameters of a plant to the cable that statics solves: its sections, unit, bodies and tension law."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from cable_sim_node.errors import NoEquilibriumError, StaticsError
from cable_sim_node.line.rest.hanging import refuse_floating
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.physics.properties import body_properties, cable_sections, depth_at_rest, unit_properties
from cable_sim_node.physics.tension_law import overstrained_words, stiffening, strain_at, yielding_words
from heave_node.numerics.arrays import Array

from heave_statics.shape import StaticShape
from heave_statics.system import PointLoad, StaticCable, StaticSection, static_cable
from heave_statics.tables import STIFFNESS

FEWEST_SEGMENTS = 100
REST_ITERATIONS = 60
SETTLED = 1e-11
"""Relative change of a segment below which it is the same again."""


def suspended_cable(parameters: CableSimParameters, end_load: PointLoad, *, dry: float = 0.0) -> StaticCable:
    """Return the cable with its bodies, cut into `segments` but 100 at least.

    Parameters
    ----------
    parameters : of the plant
    end_load : what is at s = 0
    dry : unstretched length at the top that is above the surface [m]

    Raises
    ------
    StaticsError
        if sections or bodies do not fit on the cable.
    """
    loads = [end_load]
    loads += [PointLoad(b.label, (0.0, 0.0, -b.weight), body_drag=b.drag) for b in body_properties(parameters)]
    segments = max(parameters.segments, FEWEST_SEGMENTS)
    return static_cable(static_sections(parameters, dry=dry), loads, segments=segments)


def unit_load(parameters: CableSimParameters, depth: float = math.inf, *, is_carried: bool = False) -> PointLoad:
    """Return the unit of the parameters, as wet as it is at `depth` [m], as a load at s = 0.

    One that something else carries (`is_carried`) has its drag alone.
    """
    unit = unit_properties(parameters, depth)
    force = np.zeros(3) if is_carried else unit.force
    return PointLoad(0.0, _triple(force), _triple(unit.drag), unit.body_drag)


def static_sections(parameters: CableSimParameters, *, dry: float = 0.0) -> list[StaticSection]:
    """Return the sections of the parameters' cable that is out, from the unit upwards; `dry` [m] of it hang in air."""
    level = parameters.length - dry
    sections = []
    for section in cable_sections(parameters):
        cable, end = section.cable, min(section.start + section.length, parameters.length)
        wet, in_air = min(end, level) - section.start, end - max(section.start, level)
        if wet > 0.0:
            drags = (cable.normal_drag, cable.tangential_drag)
            sections.append(StaticSection(wet, cable.axial_stiffness, cable.weight, *drags))
        if in_air > 0.0:
            sections.append(StaticSection(in_air, cable.axial_stiffness, cable.weight_in_air))
    return sections


def shape_at_rest(
    parameters: CableSimParameters,
    solve: Callable[[StaticCable], StaticShape],
    end_load: PointLoad | None = None,
) -> StaticShape:
    """Return the shape that a solver finds for the parameters' cable, under its tension law and with its top in air.

    Parameters
    ----------
    parameters : of the plant
    solve : returns the shape of a cable whose tension law is linear
    end_load : what is at s = 0; the unit, as wet as it is where it comes to rest, if None

    Raises as `shapes_at_rest`.
    """
    if end_load is not None:
        return shapes_at_rest([Rope(parameters, end_load)], lambda cables: [solve(cables[0])])[0]

    def shape_at(depth: float) -> StaticShape:
        return shape_at_rest(parameters, solve, unit_load(parameters, depth))

    return shape_at(depth_at_rest(parameters, lambda depth: -float(shape_at(depth).positions[0, 2])))


class Rope(NamedTuple):
    """A cable of a plant, and what is at its end s = 0."""

    parameters: CableSimParameters  # of the plant
    end_load: PointLoad  # at s = 0


def shapes_at_rest(
    ropes: Sequence[Rope], solve: Callable[[list[StaticCable]], Sequence[StaticShape]]
) -> list[StaticShape]:
    """Return the shapes that a solver finds for several ropes, under their tension laws and with their tops in air.

    Parameters
    ----------
    ropes : the lower end of each is s = 0
    solve : solver, which takes each segment's tension law as linear and knows nothing of the surface: it is called
        again and again, with every segment's secant stiffness at its mean tension and its weight in air or water, until
        these settle

    Raises
    ------
    NoEquilibriumError
        if a tension law carries no load at the static strain, this does not settle, or a load floats above the top.
    StaticsError
        if sections or bodies do not fit on a cable, or it is strained by more than LARGEST_STRAIN.
    """
    cables = [suspended_cable(*rope) for rope in ropes]
    for _ in range(REST_ITERATIONS):
        shapes = list(solve(cables))
        before, cables = cables, [_at_rest(rope, shape) for rope, shape in zip(ropes, shapes, strict=True)]
        if all(_is_settled(old, new) for old, new in zip(before, cables, strict=True)):
            for rope, shape in zip(ropes, shapes, strict=True):
                refuse_overstrained(rope.parameters, shape.largest_strain)
            return shapes
    raise NoEquilibriumError("the strain under the tension law, or the length above the surface, does not converge")


def _at_rest(rope: Rope, shape: StaticShape) -> StaticCable:
    """Return the cable of a rope as wet and as stiff as in a `shape`."""
    parameters = rope.parameters
    if parameters.surface and rope.end_load != PointLoad(0.0):
        refuse_floating(float(shape.positions[0, 2]), float(shape.positions[-1, 2]))
    cable = suspended_cable(*rope, dry=_length_in_air(shape) if parameters.surface else 0.0)
    quadratic, cubic = parameters.cable.stiffness_quadratic, parameters.cable.stiffness_cubic
    if quadratic == 0.0 and cubic == 0.0:
        return cable
    tension = 0.5 * (np.linalg.norm(shape.lower, axis=1) + np.linalg.norm(shape.upper, axis=1))
    middles = [0.5 * (one.labels[1:] + one.labels[:-1]) for one in (cable, shape.cable)]
    strain = np.interp(middles[0], middles[1], tension / shape.cable.segments[:, STIFFNESS])
    segments = cable.segments.copy()
    segments[:, STIFFNESS] *= stiffening.py_func(quadratic, cubic, strain)
    if not np.all(segments[:, STIFFNESS] > 0.0):
        raise NoEquilibriumError(yielding_words(quadratic, cubic))
    return replace(cable, segments=segments)


def _is_settled(before: StaticCable, after: StaticCable) -> bool:
    """Return whether a cable is the same again: lengths, stiffness, weight and drag of all segments."""
    old, new = before.segments, after.segments
    return old.shape == new.shape and bool(np.allclose(new, old, rtol=SETTLED, atol=0.0))


def _length_in_air(shape: StaticShape) -> float:
    """Return the unstretched length at the top that is above z = 0 [m]."""
    heights, labels = shape.positions[:, 2], shape.cable.labels
    below = np.flatnonzero(heights <= 0.0)
    if len(below) == 0:
        return float(labels[-1])
    i = int(below[-1])
    if i == len(heights) - 1:
        return 0.0
    share = -heights[i] / (heights[i + 1] - heights[i])
    return float(labels[-1] - labels[i] - share * (labels[i + 1] - labels[i]))


def refuse_overstrained(parameters: CableSimParameters, strain: float) -> None:
    """Raise StaticsError for a `strain` [-] in which a cable of the `parameters` parts."""
    words = overstrained_words(strain, parameters.cable.axial_stiffness)
    if words:
        raise StaticsError(words)


def refuse_unbearable(parameters: CableSimParameters, strain: float) -> None:
    """Raise as `shapes_at_rest` for a tension that strains a linear cable of the `parameters` by `strain` [-]."""
    law = parameters.cable.stiffness_quadratic, parameters.cable.stiffness_cubic
    true = float(strain_at(1.0, *law, strain))
    if math.isnan(true):
        raise NoEquilibriumError(yielding_words(*law))
    refuse_overstrained(parameters, true)


def _triple(values: Array) -> tuple[float, float, float]:
    return float(values[0]), float(values[1]), float(values[2])
