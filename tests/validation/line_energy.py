"""Mechanical energy of a plant's line, and the power of all that takes energy from it: an account of its own.

It reads the arrays that the solver moves, but takes nothing from the solver's equations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from cable_sim_node.line import layout as at
from cable_sim_node.line.arrays import LineArrays
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.physics.current import current_of
from heave_node.numerics.arrays import Array


@dataclass(frozen=True)
class Energy:
    """Energy [J] of line and unit with their added mass; potential energy in water, zero at the origin's height."""

    kinetic: float
    elastic: float
    potential: float

    @property
    def total(self) -> float:
        """Sum of the three [J]."""
        return self.kinetic + self.elastic + self.potential


@dataclass(frozen=True)
class PowerLost:
    """Power [W] that leaves the line through each sink; drag can be negative where a current drives the line."""

    drag: float
    internal_damping: float
    seabed: float

    @property
    def total(self) -> float:
        """Sum of the three [W]."""
        return self.drag + self.internal_damping + self.seabed


def energy_of(plant: CableDynamics) -> Energy:
    """Return the energy at the present state. Bending, contact and compensator springs are not in it.

    Added mass works across each segment only; where segments turn, its energy is not conserved by the equations of
    thesis 5.2.1, which take M a, not d(M v)/dt.
    """
    line = plant._line
    n = line.segments
    length, stiffness, quadratic, cubic, mass, added, weight = _columns(
        line, n, at.LENGTH, at.STIFFNESS, at.QUADRATIC, at.CUBIC, at.MASS, at.ADDED_MASS, at.WEIGHT
    )
    lump_mass, lump_added, lump_weight = _columns(line, n + 1, at.LUMP_MASS, at.LUMP_ADDED_MASS, at.LUMP_WEIGHT)
    x, v = plant.node_positions, plant.node_velocities
    chord = np.diff(x, axis=0)
    v[n] -= line.numbers[at.NOW + at.RATE] * chord[-1] / length[-1]
    stretched = np.linalg.norm(chord, axis=1)
    e = chord / stretched[:, None]
    half_mass, half_added = 0.5 * mass * length, 0.5 * added * length
    kinetic = 0.0
    for ends in (v[:-1], v[1:]):
        square = np.sum(ends**2, axis=1)
        kinetic += 0.5 * float(half_mass @ square + half_added @ (square - np.sum(ends * e, axis=1) ** 2))
    kinetic += 0.5 * float(line.numbers[at.UNIT_INERTIA : at.UNIT_INERTIA + 3] @ v[0] ** 2)
    kinetic += 0.5 * float((lump_mass + lump_added) @ np.sum(v**2, axis=1))
    strain = np.maximum(stretched / length - 1.0, 0.0)
    law = 0.5 + strain * (quadratic / 3.0 + cubic * strain / 4.0)
    elastic = float(np.sum(length * stiffness * strain**2 * law))
    potential = float(0.5 * weight * length @ (x[:-1, 2] + x[1:, 2])) + float(lump_weight @ x[:, 2])
    potential -= float(line.numbers[at.UNIT_FORCE : at.UNIT_FORCE + 3] @ x[0])
    return Energy(kinetic, elastic, potential)


def power_lost(plant: CableDynamics) -> PowerLost:
    """Return the power lost at the present state."""
    tensions, line = plant.segment_tensions, plant._line
    n = line.segments
    length, stiffness, quadratic, cubic, normal, tangential = _columns(
        line, n, at.LENGTH, at.STIFFNESS, at.QUADRATIC, at.CUBIC, at.NORMAL_DRAG, at.TANGENTIAL_DRAG
    )
    x, v = plant.node_positions, plant.node_velocities
    chord = np.diff(x, axis=0)
    v[n] -= line.numbers[at.NOW + at.RATE] * chord[-1] / length[-1]
    stretched = np.linalg.norm(chord, axis=1)
    e = chord / stretched[:, None]
    mean, current = 0.5 * (v[:-1] + v[1:]), current_of(plant.parameters)
    flow = np.array([current.at(-z) for z in [x[0, 2], *(0.5 * (x[:-1, 2] + x[1:, 2]))]])
    u = mean - flow[1:]
    along = np.sum(u * e, axis=1)
    across = u - along[:, None] * e
    force = (normal * length * np.linalg.norm(across, axis=1))[:, None] * across
    force += (tangential * length * np.abs(along) * along)[:, None] * e
    drag = float(np.sum(force * mean))
    u = v[0] - flow[0]
    drag += float((line.numbers[at.UNIT_DRAG : at.UNIT_DRAG + 3] * np.abs(u) * u) @ v[0])
    u = v[1:] - flow[1:]
    drag += float(np.sum((line.column(at.LUMP_DRAG, n + 1)[1:] * np.linalg.norm(u, axis=1))[:, None] * u * v[1:]))
    strain = stretched / length - 1.0
    elastic = stiffness * strain * (1.0 + strain * (quadratic + cubic * strain))
    rate = np.sum(e * np.diff(v, axis=0), axis=1)
    damping = float(np.sum(np.where(strain > 0.0, (tensions - elastic) * rate, 0.0)))
    return PowerLost(drag, damping, _seabed_power(plant))


def _columns(line: LineArrays, rows: int, *columns: int) -> list[Array]:
    return [line.column(column, rows) for column in columns]


def _seabed_power(plant: CableDynamics) -> float:
    """Return the power of the seabed's damping and friction [W]; what touches it slides."""
    s, n = plant._line.numbers, plant.segments
    x, v, lengths = plant.node_positions, plant.node_velocities, plant._line.column(at.LENGTH, n)
    if s[at.BED_ON] == 0.0:
        return 0.0
    normal = np.array([-s[at.BED_SLOPE_X], -s[at.BED_SLOPE_Y], 1.0])
    normal /= np.linalg.norm(normal)
    power = 0.0
    for i in range(n):
        depth = -float((x[i] + np.array([0.0, 0.0, s[at.BED_DEPTH]])) @ normal)
        if depth <= 0.0:
            continue
        share = 1.0 if i == 0 else 0.5 * (lengths[i - 1] + lengths[i])
        stiffness = share * s[at.BED_UNIT_STIFFNESS if i == 0 else at.BED_STIFFNESS]
        damping = share * s[at.BED_UNIT_DAMPING if i == 0 else at.BED_DAMPING]
        speed = float(v[i] @ normal)
        push = max(stiffness * depth - damping * min(depth / 0.01, 1.0) * speed, 0.0)
        slide = float(np.linalg.norm(v[i] - speed * normal))
        power += (stiffness * depth - push) * speed
        power += s[at.BED_FRICTION] * push * slide
    return power
