"""From parameters to the arrays of a line: the grid of material points from the unit upwards, and what stands on it."""

from __future__ import annotations

import math

import numpy as np
from heave_node.numerics.arrays import Array

from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays, allocate
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.physics.current import profile_of, schedule_of
from cable_sim_node.physics.properties import CableProperties, body_properties, cable_sections, unit_properties
from cable_sim_node.physics.seabed import Seabed

_SPARE_SEGMENTS = 8
"""Grid segments beyond the longest line, so that the kernels may look ahead."""


def build_line(parameters: CableSimParameters, total: float) -> LineArrays:
    """Return the arrays of a line of these parameters whose grid reaches beyond `total` [m] of unstretched length."""
    points = grid_points(parameters, total)
    grid = np.zeros((len(points), at.GRID_COLUMNS))
    grid[:, at.START] = points
    _fill_segments(parameters, grid)
    _add_lumps(parameters, grid)
    return allocate(
        grid,
        unit_row(parameters),
        profile_of(parameters),
        schedule_of(parameters),
        settings_row(parameters),
        bending=parameters.cable.bending_stiffness > 0.0,
    )


def grid_points(parameters: CableSimParameters, total: float) -> Array:
    """Return the unstretched lengths [m] from the unit to the grid points, beyond `total`.

    Ends of sections and bodies are grid points. Between those, segments are equal and at most `length / segments` of
    the parameters long.
    """
    size = parameters.length / parameters.segments
    goal = max(total, parameters.length) + _SPARE_SEGMENTS * size
    marks = {parameters.length, *np.cumsum(parameters.sections.length), *parameters.clumps.position}
    points = [0.0]
    for mark in sorted(float(m) for m in marks):
        gap = mark - points[-1]
        if gap < 1e-6 * size:
            continue
        pieces = math.ceil(gap / size - 1e-9)
        points += list(points[-1] + gap * np.arange(1, pieces + 1) / pieces)
    beyond = math.ceil((goal - points[-1]) / size)
    if beyond > 0:
        points += list(points[-1] + size * np.arange(1, beyond + 1))
    return np.array(points)


def segment_row(cable: CableProperties) -> Array:
    """Return the properties of a segment of `cable`; its length is left at 0."""
    row = np.zeros(at.SEGMENT_COLUMNS)
    row[at.STIFFNESS] = cable.axial_stiffness
    row[at.QUADRATIC] = cable.quadratic
    row[at.CUBIC] = cable.cubic
    row[at.DAMPING] = cable.internal_damping
    row[at.MASS] = cable.mass
    row[at.ADDED_MASS] = cable.added_mass
    row[at.WEIGHT] = cable.weight
    row[at.NORMAL_DRAG] = cable.normal_drag
    row[at.TANGENTIAL_DRAG] = cable.tangential_drag
    row[at.DISPLACED] = cable.displaced_mass
    row[at.BENDING] = cable.bending_stiffness
    return row


def unit_row(parameters: CableSimParameters) -> Array:
    """Return inertia, drag, steady force and moved fluid of the parameters' unit along each axis."""
    unit = unit_properties(parameters)
    row = np.zeros(at.UNIT_COLUMNS)
    row[at.UNIT_INERTIA : at.UNIT_INERTIA + 3] = unit.inertia
    row[at.UNIT_DRAG : at.UNIT_DRAG + 3] = unit.drag
    row[at.UNIT_BODY_DRAG] = unit.body_drag
    row[at.UNIT_FORCE : at.UNIT_FORCE + 3] = unit.force
    row[at.UNIT_FLUID : at.UNIT_FLUID + 3] = unit.fluid
    return row


def settings_row(parameters: CableSimParameters) -> Array:
    """Return the parameters' settings of the kernels.

    The coefficients of generalised-alpha follow from the spectral radius (Chung & Hulbert 1993).
    """
    seabed = Seabed(parameters.seabed)
    row = np.append(np.zeros(at.SETTING_COLUMNS), seabed.profile)
    solver, bed, wave, spring = parameters.solver, parameters.seabed, parameters.wave, parameters.compensator
    radius = solver.spectral_radius
    alpha_m, alpha_f = (2.0 * radius - 1.0) / (radius + 1.0), radius / (radius + 1.0)
    row[at.ALPHA_M], row[at.ALPHA_F] = alpha_m, alpha_f
    row[at.GAMMA] = 0.5 - alpha_m + alpha_f
    row[at.BETA] = 0.25 * (1.0 - alpha_m + alpha_f) ** 2
    row[at.TOLERANCE], row[at.ITERATIONS], row[at.STEP] = solver.tolerance, solver.iterations, solver.time_step
    row[at.BED_ON], row[at.BED_DEPTH] = float(bed.depth > 0.0), bed.depth
    row[at.BED_SLOPE_X], row[at.BED_SLOPE_Y] = bed.slope
    (row[at.PROFILE_X], row[at.PROFILE_Y]), row[at.PROFILE_ROWS] = seabed.direction, len(seabed.profile)
    row[at.BED_STIFFNESS], row[at.BED_DAMPING], row[at.BED_FRICTION] = bed.stiffness, bed.damping, bed.friction
    row[at.BED_UNIT_STIFFNESS], row[at.BED_UNIT_DAMPING] = bed.unit_stiffness, bed.unit_damping
    omega = 2.0 * math.pi / wave.period
    row[at.WAVE_AMPLITUDE], row[at.WAVE_FREQUENCY] = wave.amplitude, omega
    row[at.WAVE_NUMBER] = omega**2 / parameters.gravity if parameters.gravity > 0.0 else 0.0
    row[at.WAVE_X], row[at.WAVE_Y] = math.cos(wave.direction), math.sin(wave.direction)
    row[at.SPRING_ON] = float(spring.stiffness > 0.0)
    row[at.SPRING_STIFFNESS], row[at.SPRING_DAMPING] = spring.stiffness, spring.damping
    row[at.SPRING_MASS], row[at.SPRING_HALF_STROKE] = spring.moving_mass, 0.5 * spring.stroke
    row[at.SPRING_STOP], row[at.SPRING_STOP_DAMPING] = spring.stop_stiffness, spring.stop_damping
    row[at.SPRING_PRELOAD] = spring.preload
    row[at.BENDING_ON] = float(parameters.cable.bending_stiffness > 0.0)
    return row


def _fill_segments(parameters: CableSimParameters, grid: Array) -> None:
    middles = 0.5 * (grid[1:, at.START] + grid[:-1, at.START])
    for section in cable_sections(parameters):
        inside = (middles >= section.start) & (middles < section.start + section.length)
        grid[:-1, : at.SEGMENT_COLUMNS][inside] = segment_row(section.cable)
    grid[:-1, at.LENGTH] = np.diff(grid[:, at.START])


def _add_lumps(parameters: CableSimParameters, grid: Array) -> None:
    for body in body_properties(parameters):
        row = grid[int(np.argmin(np.abs(grid[:, at.START] - body.label)))]
        row[at.LUMP_MASS] += body.mass
        row[at.LUMP_ADDED_MASS] += body.added_mass
        row[at.LUMP_WEIGHT] += body.weight
        row[at.LUMP_DRAG] += body.drag
        row[at.LUMP_DISPLACED] += body.displaced_mass
