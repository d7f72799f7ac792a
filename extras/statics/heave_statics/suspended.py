"""From the parameters of a plant to the cable that statics solves: its sections, unit, bodies and tension law."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

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
STIFFNESS_ITERATIONS = 50
SURFACE_ITERATIONS = 50


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
    solve : as `with_tension_law` takes it
    end_load : what is at s = 0; the unit, as wet as it is where it comes to rest, if None

    Raises as `with_tension_law` and `suspended_cable`.
    """
    if end_load is not None:
        return _shape_under(parameters, solve, end_load)

    def shape_at(depth: float) -> StaticShape:
        return _shape_under(parameters, solve, unit_load(parameters, depth))

    return shape_at(depth_at_rest(parameters, lambda depth: -float(shape_at(depth).positions[0, 2])))


def _shape_under(
    parameters: CableSimParameters, solve: Callable[[StaticCable], StaticShape], end_load: PointLoad
) -> StaticShape:
    dry = 0.0
    for _ in range(SURFACE_ITERATIONS):
        shape = with_tension_law(parameters, suspended_cable(parameters, end_load, dry=dry), solve)
        if parameters.surface:
            refuse_floating(float(shape.positions[0, 2]), float(shape.positions[-1, 2]))
        before, dry = dry, _length_in_air(shape) if parameters.surface else 0.0
        if abs(dry - before) < 1e-9 * parameters.length:
            return shape
    raise NoEquilibriumError("the length of cable above the surface does not converge")


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


def with_tension_law(
    parameters: CableSimParameters, cable: StaticCable, solve: Callable[[StaticCable], StaticShape]
) -> StaticShape:
    """Return the shape that a solver finds under the tension law of the parameters.

    Parameters
    ----------
    parameters : of the plant
    cable : with the stiffness of small strain
    solve : solver, which takes each segment's tension law as linear; where it is not, it is called again and again with
        every segment's secant stiffness at its mean tension, until that settles

    Raises
    ------
    NoEquilibriumError
        if the law carries no load at the static strain, or the strain does not settle.
    StaticsError
        if the cable is strained by more than LARGEST_STRAIN.
    """
    quadratic, cubic = parameters.cable.stiffness_quadratic, parameters.cable.stiffness_cubic
    shape = solve(cable)
    if quadratic == 0.0 and cubic == 0.0:
        refuse_overstrained(parameters, shape.largest_strain)
        return shape
    small_strain = cable.segments[:, STIFFNESS].copy()
    for _ in range(STIFFNESS_ITERATIONS):
        tension = 0.5 * (np.linalg.norm(shape.lower, axis=1) + np.linalg.norm(shape.upper, axis=1))
        strain = tension / cable.segments[:, STIFFNESS]
        wanted = small_strain * stiffening.py_func(quadratic, cubic, strain)
        if not np.all(wanted > 0.0):
            raise NoEquilibriumError(yielding_words(quadratic, cubic))
        segments = cable.segments.copy()
        segments[:, STIFFNESS] = wanted
        settled = float(np.max(np.abs(wanted / cable.segments[:, STIFFNESS] - 1.0))) < 1e-12
        cable = replace(cable, segments=segments)
        shape = solve(cable)
        if settled:
            refuse_overstrained(parameters, shape.largest_strain)
            return shape
    raise NoEquilibriumError("the static strain does not converge under the cable's tension law")


def refuse_overstrained(parameters: CableSimParameters, strain: float) -> None:
    """Raise StaticsError for a `strain` [-] in which a cable of the `parameters` parts."""
    words = overstrained_words(strain, parameters.cable.axial_stiffness)
    if words:
        raise StaticsError(words)


def refuse_unbearable(parameters: CableSimParameters, strain: float) -> None:
    """Raise as `with_tension_law` for a tension that strains a linear cable of the `parameters` by `strain` [-]."""
    law = parameters.cable.stiffness_quadratic, parameters.cable.stiffness_cubic
    true = float(strain_at(1.0, *law, strain))
    if math.isnan(true):
        raise NoEquilibriumError(yielding_words(*law))
    refuse_overstrained(parameters, true)


def _triple(values: Array) -> tuple[float, float, float]:
    return float(values[0]), float(values[1]), float(values[2])
