"""From parameters to the arrays of a line: the grid of material points from the unit upwards, and what stands on it."""

from __future__ import annotations

import math

import numpy as np
from heave_node.interface.waves import Waves
from heave_node.numerics.arrays import Array

from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays, allocate
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.physics.current import FLOW, current_of
from cable_sim_node.physics.properties import (
    CableProperties,
    body_properties,
    box_height,
    cable_sections,
    unit_properties,
)
from cable_sim_node.physics.seabed import HEIGHT, Seabed
from cable_sim_node.physics.tension_law import friction_of

_SPARE_SEGMENTS = 8
"""Grid segments beyond the longest line, so that the kernels may look ahead."""


def build_line(parameters: CableSimParameters, total: float) -> LineArrays:
    """Return the arrays of a line of these parameters whose grid reaches beyond `total` [m] of unstretched length."""
    points = grid_points(parameters, total)
    grid = np.zeros((len(points), at.PART_COLUMNS))
    _fill_segments(parameters, points, grid)
    _add_lumps(parameters, points, grid)
    bending = parameters.cable.bending_stiffness > 0.0
    line = allocate(grid, points, numbers_of(parameters), current_of(parameters).profile, bending=bending)
    _set_steady_flow(line)
    line.numbers[at.GRID_END] = line.grid_points[-5]
    return line


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
    """Return the properties of a segment of `cable` in the order of the columns; those of its length are left at 0."""
    return np.array(
        [
            0.0,
            0.0,
            cable.axial_stiffness,
            cable.quadratic,
            cable.cubic,
            cable.internal_damping,
            cable.mass,
            cable.added_mass,
            cable.weight,
            cable.normal_drag,
            cable.tangential_drag,
            cable.displaced_mass,
            cable.bending_stiffness,
        ]
    )


def numbers_of(parameters: CableSimParameters) -> Array:
    """Return the numbers of a line of these parameters: unit and settings; all else is 0."""
    unit, settings = unit_properties(parameters), settings_of(parameters)
    numbers = np.zeros(at.SETTINGS + len(settings))
    deep = np.concatenate((unit.inertia, unit.drag, unit.force, unit.fluid, [unit.body_drag]))
    numbers[: at.DEEP] = numbers[at.DEEP : at.UNIT_MASS] = deep
    numbers[at.UNIT_MASS] = unit.mass
    numbers[at.SETTINGS :] = settings
    return numbers


def settings_of(parameters: CableSimParameters) -> Array:
    """Return the parameters' settings of the kernels, from the index SETTINGS on, and the seabed's profile.

    The coefficients of generalised-alpha follow from the spectral radius (Chung & Hulbert 1993).
    """
    seabed = Seabed(parameters.seabed)
    numbers = np.concatenate((np.zeros(at.NUMBERS), seabed.profile.ravel(), unit_table(parameters).ravel()))
    solver, bed, spring = parameters.solver, parameters.seabed, parameters.top_spring
    radius = solver.spectral_radius
    alpha_m, alpha_f = (2.0 * radius - 1.0) / (radius + 1.0), radius / (radius + 1.0)
    numbers[at.ALPHA_M], numbers[at.ALPHA_F] = alpha_m, alpha_f
    numbers[at.GAMMA] = 0.5 - alpha_m + alpha_f
    numbers[at.BETA] = 0.25 * (1.0 - alpha_m + alpha_f) ** 2
    numbers[at.TOLERANCE], numbers[at.ITERATIONS], numbers[at.STEP] = (
        solver.tolerance,
        solver.iterations,
        solver.time_step,
    )
    numbers[at.BED_ON], numbers[at.BED_DEPTH] = float(bed.depth > 0.0), bed.depth
    numbers[at.BED_SLOPE_X], numbers[at.BED_SLOPE_Y] = bed.slope
    numbers[at.BED_FOLLOWS] = float(bed.deck)
    (numbers[at.PROFILE_X], numbers[at.PROFILE_Y]), numbers[at.PROFILE_ROWS] = seabed.direction, len(seabed.profile)
    numbers[at.BED_TOP] = max(seabed.profile[:, HEIGHT], default=0.0)
    numbers[at.BED_STIFFNESS], numbers[at.BED_DAMPING], numbers[at.BED_FRICTION] = (
        bed.stiffness,
        bed.damping,
        bed.friction,
    )
    numbers[at.BED_UNIT_STIFFNESS], numbers[at.BED_UNIT_DAMPING] = bed.unit_stiffness, bed.unit_damping
    rows = len(current_of(parameters).profile)
    numbers[at.PROFILE_END], numbers[at.FLOW_VARIES] = rows, float(rows > 1)
    numbers[at.SPRING_ON] = float(spring.stiffness > 0.0)
    numbers[at.SPRING_STIFFNESS], numbers[at.SPRING_DAMPING] = spring.stiffness, spring.damping
    numbers[at.SPRING_MASS], numbers[at.SPRING_HALF_STROKE] = spring.moving_mass, 0.5 * spring.stroke
    numbers[at.SPRING_STOP], numbers[at.SPRING_STOP_DAMPING] = spring.stop_stiffness, spring.stop_damping
    numbers[at.SPRING_PRELOAD] = spring.preload
    numbers[at.LUMPS_ON] = float(len(parameters.clumps.position) > 0)
    numbers[at.BENDING_ON] = float(parameters.cable.bending_stiffness > 0.0)
    numbers[at.SURFACE_ON] = float(parameters.surface and parameters.water_density > 0.0)
    numbers[at.GRAVITY] = parameters.gravity
    friction = friction_of(parameters.cable.loss_factor, parameters.cable.loss_swing)
    numbers[at.FRICTION_ON] = float(parameters.cable.loss_factor > 0.0)
    numbers[at.FRICTION_STICKS], numbers[at.FRICTION_SLIDES] = friction
    _set_unit(parameters, numbers)
    return numbers[at.SETTINGS :]


def with_waves(line: LineArrays, waves: Waves) -> LineArrays:
    """Return the arrays of a `line` on which these `waves` act, in place of those before."""
    numbers = line.numbers
    table, end = _wave_table(waves, float(numbers[at.GRAVITY])), int(numbers[at.PROFILE_END])
    line = line._replace(water=np.concatenate((line.water[:end], table)))
    numbers[at.WAVES], numbers[at.WAVE_START], numbers[at.WAVE_RAMP] = len(table), waves.start, waves.ramp
    numbers[at.LEVEL] = 0.0
    numbers[at.FLOW_VARIES] = float(len(table) > 0 or end > 1)
    _set_steady_flow(line)
    return line


def _set_steady_flow(line: LineArrays) -> None:
    """Set the flow of steady water, which is the same everywhere and always; a flow that varies is set in each step."""
    for axis in range(3):
        flow = at.FLOW_X + axis * at.STRIDE
        line.tiles[:, flow : flow + at.STRIDE] = line.water[0, FLOW + axis]
    line.tiles[:, at.FLOW_AX : at.FLOW_AX + 3 * at.STRIDE] = 0.0


def _wave_table(waves: Waves, gravity: float) -> Array:
    """Return the components of `waves` under `gravity` [m/s^2] as the kernels take them, shape (n, WATER_COLUMNS)."""
    order = np.argsort(waves.frequency, kind="stable")
    omega, encounter, amplitude, phase, direction = (column[order] for column in waves.columns)
    cosine, sine = np.cos(direction), np.sin(direction)
    number = omega**2 / gravity if gravity > 0.0 else np.zeros_like(omega)
    return np.column_stack(
        (encounter, omega, number, number * cosine, number * sine, phase, amplitude, amplitude * omega, cosine, sine)
    )


def unit_table(parameters: CableSimParameters) -> Array:
    """Return the table of the parameters' unit over KC, see `layout`; shape (k, 3)."""
    table = parameters.unit.oscillation
    drag = 0.5 * parameters.water_density * parameters.unit.drag_area[2] * np.array(table.drag_coefficient)
    return np.column_stack((table.kc, table.added_mass, drag))


def _set_unit(parameters: CableSimParameters, numbers: Array) -> None:
    """Set the settings of a unit that depends on its place or motion."""
    unit, density = parameters.unit, parameters.water_density
    numbers[at.KC_ROWS] = len(unit_table(parameters))
    numbers[at.KC_WIDTH], numbers[at.KC_MEMORY] = unit.oscillation.width, unit.oscillation.memory
    numbers[at.BOX_HEIGHT] = box_height(parameters)
    numbers[at.BUOYANCY] = unit_properties(parameters).buoyancy
    numbers[at.SLAMMING] = 0.5 * density * unit.box.slamming * unit.box.area
    varies = numbers[at.KC_ROWS] > 0.0 or numbers[at.BOX_HEIGHT] > 0.0
    numbers[at.UNIT_VARIES] = float(density > 0.0 and varies)


def _fill_segments(parameters: CableSimParameters, points: Array, grid: Array) -> None:
    middles = 0.5 * (points[1:] + points[:-1])
    for section in cable_sections(parameters):
        inside = (middles >= section.start) & (middles < section.start + section.length)
        grid[:-1, : at.SEGMENT_COLUMNS][inside] = segment_row(section.cable)
    lengths = np.diff(points)
    grid[:-1, 0], grid[:-1, 1] = lengths, 1.0 / lengths


def _add_lumps(parameters: CableSimParameters, points: Array, grid: Array) -> None:
    for body in body_properties(parameters):
        row = grid[int(np.argmin(np.abs(points - body.label)))]
        row[at.SEGMENT_COLUMNS :] += (body.mass, body.added_mass, body.weight, body.drag, body.displaced_mass)
