"""From parameters to the arrays of a line: the grid of material points from the unit upwards, and what stands on it."""

from __future__ import annotations

import math

import numpy as np
from heave_node.arrays import Array

from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays, allocate
from cable_sim_node.parameters import CableParameters, CableSimParameters

_SPARE_SEGMENTS = 8
"""Grid segments beyond the longest line, so that the kernels may look ahead."""


def build_line(parameters: CableSimParameters, total: float) -> LineArrays:
    """Return the arrays of a line whose grid reaches beyond `total` [m] of unstretched length."""
    grid_s = grid_points(parameters, total)
    middles = 0.5 * (grid_s[1:] + grid_s[:-1])
    grid = np.zeros((len(grid_s), at.GRID_COLUMNS))
    grid[:-1, : at.SEGMENT_COLUMNS] = [segment_row(parameters, s) for s in middles]
    grid[:-1, at.LENGTH] = np.diff(grid_s)
    grid[:, at.START] = grid_s
    _add_lumps(parameters, grid)
    profile = parameters.current_profile
    current = np.array([profile.depth, profile.velocity_x, profile.velocity_y]).T
    if not profile.depth:
        current = np.array([[0.0, *parameters.current]])
    schedule = np.array([profile.time, profile.factor]).T if profile.time else np.array([[0.0, 1.0]])
    return allocate(
        grid,
        unit_row(parameters),
        np.ascontiguousarray(current),
        np.ascontiguousarray(schedule),
        settings_row(parameters),
        bending=parameters.cable.bending_stiffness > 0.0,
    )


def grid_points(parameters: CableSimParameters, total: float) -> Array:
    """Return the material coordinates [m] of the grid, beyond `total`; section ends and clumps are grid points.

    Between those, segments are equal and at most `length / segments` long.
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


def segment_row(parameters: CableSimParameters, s: float) -> Array:
    """Return the properties of the cable at material coordinate `s` [m] (length left at 0)."""
    cable = cable_at(parameters, s)
    density = parameters.water_density
    row = np.zeros(at.SEGMENT_COLUMNS)
    row[at.STIFFNESS] = cable.axial_stiffness
    row[at.QUADRATIC] = cable.stiffness_quadratic
    row[at.CUBIC] = cable.stiffness_cubic
    row[at.DAMPING] = cable.internal_damping
    row[at.MASS] = cable.mass_per_length
    row[at.ADDED_MASS] = density * cable.added_mass * cable.displaced_area
    row[at.WEIGHT] = cable.weight_in_fluid(density, parameters.gravity)
    row[at.NORMAL_DRAG] = 0.5 * density * cable.normal_drag * cable.diameter
    row[at.TANGENTIAL_DRAG] = 0.5 * math.pi * density * cable.tangential_drag * cable.diameter
    row[at.DISPLACED] = density * cable.displaced_area
    row[at.BENDING] = cable.bending_stiffness
    return row


def cable_at(parameters: CableSimParameters, s: float) -> CableParameters:
    """Return the cable at material coordinate `s` [m]: a section's, or the main cable above the last section."""
    main, sections = parameters.cable, parameters.sections
    for i, end in enumerate(np.cumsum(sections.length)):
        if s < end:
            return CableParameters(
                diameter=sections.diameter[i],
                displaced_diameter=sections.displaced_diameter[i] if sections.displaced_diameter else 0.0,
                mass_per_length=sections.mass_per_length[i],
                axial_stiffness=sections.axial_stiffness[i],
                stiffness_quadratic=main.stiffness_quadratic,
                stiffness_cubic=main.stiffness_cubic,
                internal_damping=main.internal_damping,
                bending_stiffness=main.bending_stiffness,
                normal_drag=main.normal_drag,
                tangential_drag=main.tangential_drag,
                added_mass=main.added_mass,
            )
    return main


def unit_row(parameters: CableSimParameters) -> Array:
    """Return inertia, drag, steady force and moved fluid of the unit along each axis."""
    unit, density = parameters.unit, parameters.water_density
    row = np.zeros(at.UNIT_COLUMNS)
    added = np.array(unit.added_mass) if density > 0.0 else np.zeros(3)
    row[at.UNIT_INERTIA : at.UNIT_INERTIA + 3] = unit.mass + added
    row[at.UNIT_DRAG : at.UNIT_DRAG + 3] = 0.5 * density * np.array(unit.drag_coefficient) * np.array(unit.drag_area)
    row[at.UNIT_FORCE : at.UNIT_FORCE + 3] = unit.thrust
    row[at.UNIT_FORCE + 2] -= unit.weight_in_fluid(density, parameters.gravity)
    row[at.UNIT_FLUID : at.UNIT_FLUID + 3] = density * unit.volume + added
    return row


def settings_row(parameters: CableSimParameters) -> Array:
    """Return the settings of the kernels.

    Generalised-alpha coefficients from the spectral radius (Chung & Hulbert 1993).
    """
    row = np.zeros(at.SETTING_COLUMNS)
    solver, bed, wave, spring = parameters.solver, parameters.seabed, parameters.wave, parameters.compensator
    radius = solver.spectral_radius
    alpha_m, alpha_f = (2.0 * radius - 1.0) / (radius + 1.0), radius / (radius + 1.0)
    row[at.ALPHA_M], row[at.ALPHA_F] = alpha_m, alpha_f
    row[at.GAMMA] = 0.5 - alpha_m + alpha_f
    row[at.BETA] = 0.25 * (1.0 - alpha_m + alpha_f) ** 2
    row[at.TOLERANCE], row[at.ITERATIONS], row[at.STEP] = solver.tolerance, solver.iterations, solver.time_step
    row[at.BED_ON], row[at.BED_DEPTH] = float(bed.depth > 0.0), bed.depth
    row[at.BED_SLOPE_X], row[at.BED_SLOPE_Y] = bed.slope
    row[at.BED_STIFFNESS], row[at.BED_DAMPING], row[at.BED_FRICTION] = bed.stiffness, bed.damping, bed.friction
    row[at.BED_UNIT_STIFFNESS], row[at.BED_UNIT_DAMPING] = bed.unit_stiffness, bed.unit_damping
    row[at.BED_SLIP] = bed.slip_velocity
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


def _add_lumps(parameters: CableSimParameters, grid: Array) -> None:
    clumps, density = parameters.clumps, parameters.water_density
    for i, position in enumerate(clumps.position):
        row = grid[int(np.argmin(np.abs(grid[:, at.START] - position)))]
        displaced = density * clumps.volume[i]
        row[at.LUMP_MASS] += clumps.mass[i]
        row[at.LUMP_ADDED_MASS] += clumps.added_mass[i] if density > 0.0 else 0.0
        row[at.LUMP_WEIGHT] += (clumps.mass[i] - displaced) * parameters.gravity
        row[at.LUMP_DRAG] += 0.5 * density * clumps.drag_area[i]
        row[at.LUMP_DISPLACED] += displaced
