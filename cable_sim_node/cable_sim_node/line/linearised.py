"""The three-dimensional line made linear about its equilibrium: mass, damping and stiffness matrices, modes, responses.

The lumped line of `dynamics` in the position in which it hangs in its current, moved a little: node 0 is the unit, node
N the boom tip, whose motion is the input. Drag is linear about the steady flow; where the water is still it is made
linear about a speed amplitude. Bending, seabed and compensator are left out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from heave_node.arrays import Array, ComplexArray
from numpy.typing import ArrayLike
from scipy.linalg import eigh

from cable_sim_node.line import layout as at
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.line.equilibrium import strain_at
from cable_sim_node.line.grid import segment_row, unit_row
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.statics.drag import current_at, segment_drag
from cable_sim_node.statics.report import current_of
from cable_sim_node.statics.system import Current
from cable_sim_node.vertical.linear import HARMONIC_DRAG, LinearisationError


@dataclass(frozen=True)
class LineResponse:
    """Answer to boom-tip motion at each frequency; the last axis is the boom tip's x, y, z.

    Attributes
    ----------
    omegas : [rad/s]
    unit : unit motion over boom-tip motion, shape (k, 3, 3) [-]
    top_tension : top tension over boom-tip motion, shape (k, 3) [N/m]
    """

    omegas: Array
    unit: ComplexArray
    top_tension: ComplexArray


@dataclass(frozen=True)
class LinearLine:
    """M x'' + C x' + K x = force, x the displacements of all nodes, x y z of node 0 first, the boom tip's last.

    Attributes
    ----------
    mass, damping, stiffness : shape (3N + 3, 3N + 3) [kg], [N s/m], [N/m]; drag makes the last two unsymmetric
    elastic : the stiffness without drag, symmetric
    labels : unstretched length from the unit to each node [m]
    positions : of the equilibrium, shape (N + 1, 3) [m]
    """

    mass: Array
    damping: Array
    stiffness: Array
    elastic: Array
    labels: Array
    positions: Array

    def natural_frequencies(self, count: int) -> tuple[Array, Array]:
        """Return the lowest undamped frequencies with the boom tip held, and their modes.

        Returns
        -------
        omegas : [rad/s], ascending
        modes : shape (count, N + 1, 3), largest displacement 1
        """
        free = len(self.mass) - 3
        if not 1 <= count <= free:
            raise LinearisationError(f"count must be from 1 to {free}; got {count}")
        squares, vectors = eigh(self.elastic[:free, :free], self.mass[:free, :free], subset_by_index=[0, count - 1])
        modes = np.zeros((count, free // 3 + 1, 3))
        modes[:, :-1] = vectors.T.reshape(count, -1, 3)
        modes /= np.abs(modes).max(axis=(1, 2), keepdims=True)
        return np.sqrt(np.maximum(squares, 0.0)), modes

    def poles(self) -> ComplexArray:
        """Return the damped eigenvalues of the line with the boom tip held [rad/s]; all decay if it is stable."""
        free = len(self.mass) - 3
        inverse = np.linalg.inv(self.mass[:free, :free])
        system = np.zeros((2 * free, 2 * free))
        system[:free, free:] = np.eye(free)
        system[free:, :free] = -inverse @ self.stiffness[:free, :free]
        system[free:, free:] = -inverse @ self.damping[:free, :free]
        return np.linalg.eigvals(system).astype(np.complex128)

    def response(self, omegas: ArrayLike) -> LineResponse:
        """Return unit motion and top tension for harmonic boom-tip motion."""
        frequencies = np.atleast_1d(np.asarray(omegas, dtype=np.float64))
        free = len(self.mass) - 3
        direction = self.positions[-1] - self.positions[-2]
        direction /= np.linalg.norm(direction)
        unit, tension = [], []
        for omega in frequencies:
            dynamic = self.stiffness + 1j * omega * self.damping - omega**2 * self.mass
            moved = np.linalg.solve(dynamic[:free, :free], -dynamic[:free, free:])
            unit.append(moved[:3])
            force = dynamic[free:, :free] @ moved + dynamic[free:, free:]
            tension.append(direction @ force)
        return LineResponse(frequencies, np.array(unit), np.array(tension))


def linearise(
    parameters: CableSimParameters,
    boom_tip: ArrayLike = (0.0, 0.0, 0.0),
    *,
    payout: float = 0.0,
    speed_amplitude: float = 0.0,
) -> LinearLine:
    """Make the line linear about the equilibrium in which it hangs from `boom_tip` [m] with `payout` [m].

    `speed_amplitude` [m/s] is the amplitude of the oscillating flow past cable and unit for which their quadratic drag
    is made linear at equal energy; it adds to the steady current's drag as the root of the sum of squares.

    Raises
    ------
    NoEquilibriumError, PlantError
        where the line does not hang.
    """
    dynamics = CableDynamics(parameters)
    dynamics.start_at_equilibrium(boom_tip, payout)
    positions, tensions = dynamics.node_positions, dynamics.segment_tensions
    labels = dynamics.material_coordinates
    size = 3 * len(positions)
    builder = _Builder(
        np.zeros((size, size)), np.zeros((size, size)), np.zeros((size, size)), np.zeros((size, size)),
        current_of(parameters), HARMONIC_DRAG * speed_amplitude,
    )  # fmt: skip
    for index, tension in enumerate(tensions):
        low, high = float(labels[index]), float(labels[index + 1])
        builder.add_segment(index, segment_row(parameters, 0.5 * (low + high)), high - low, positions, float(tension))
    builder.add_unit(unit_row(parameters), positions[0])
    clumps, density = parameters.clumps, parameters.water_density
    for number, label in enumerate(clumps.position):
        if label <= labels[-1]:
            node = int(np.argmin(np.abs(labels - label)))
            inertia = clumps.mass[number] + (clumps.added_mass[number] if density > 0.0 else 0.0)
            builder.add_body(node, inertia, 0.5 * density * clumps.drag_area[number], positions[node])
    return LinearLine(
        builder.mass, builder.damping, builder.elastic + builder.drag_stiffness, builder.elastic, labels, positions
    )


@dataclass(frozen=True)
class _Builder:
    mass: Array
    damping: Array
    elastic: Array
    drag_stiffness: Array
    current: Current
    drag_speed: float

    def flow(self, height: float) -> tuple[Array, Array]:
        """Return the current at z = `height` and its derivative by depth."""
        flow, gradient = np.empty(3), np.empty(3)
        current_at(-height, self.current.depths, self.current.velocities, 1.0, flow, gradient)
        return flow, gradient

    def add_segment(self, index: int, row: Array, length: float, positions: Array, tension: float) -> None:
        chord = positions[index + 1] - positions[index]
        stretched = float(np.linalg.norm(chord))
        along = chord / stretched
        across = np.eye(3) - np.outer(along, along)
        strain = strain_at(row, tension)
        slope = row[at.STIFFNESS] * (1.0 + strain * (2.0 * row[at.QUADRATIC] + 3.0 * row[at.CUBIC] * strain))
        spring = slope / length * np.outer(along, along) + tension / stretched * across
        damper = row[at.DAMPING] / length * np.outer(along, along)
        half_mass = 0.5 * length * (row[at.MASS] * np.eye(3) + row[at.ADDED_MASS] * across)
        lower, upper = slice(3 * index, 3 * index + 3), slice(3 * index + 3, 3 * index + 6)
        for node, other in ((lower, upper), (upper, lower)):
            self.elastic[node, node] += spring
            self.elastic[node, other] -= spring
            self.damping[node, node] += damper
            self.damping[node, other] -= damper
            self.mass[node, node] += half_mass
        self._add_drag(row, length, chord, 0.5 * float(positions[index, 2] + positions[index + 1, 2]), lower, upper)

    def _add_drag(self, row: Array, length: float, chord: Array, height: float, lower: slice, upper: slice) -> None:
        flow, gradient = self.flow(height)
        force, by_chord, by_flow = np.empty(3), np.empty((3, 3)), np.empty((3, 3))
        normal, tangential = row[at.NORMAL_DRAG], row[at.TANGENTIAL_DRAG]
        segment_drag(chord, flow, 0.0, normal, tangential, force, by_chord, by_flow)
        by_depth = by_flow @ gradient
        along = chord / np.linalg.norm(chord)
        slide = float(flow @ along)
        normal_flow = flow - slide * along
        speed = math.hypot(float(np.linalg.norm(normal_flow)), self.drag_speed)
        damper = normal * speed * (np.eye(3) - np.outer(along, along))
        if speed > 0.0:
            damper += normal * np.outer(normal_flow, normal_flow) / speed
        damper += tangential * math.hypot(2.0 * slide, self.drag_speed) * np.outer(along, along)
        for node in (lower, upper):
            for other, sign in ((lower, -1.0), (upper, 1.0)):
                self.damping[node, other] += 0.25 * length * damper
                self.drag_stiffness[node, other] -= 0.5 * sign * length * by_chord
                self.drag_stiffness[node, other.start + 2] += 0.25 * length * by_depth  # depth = -z

    def add_unit(self, unit: Array, position: Array) -> None:
        flow, gradient = self.flow(float(position[2]))
        for axis in range(3):
            drag = unit[at.UNIT_DRAG + axis]
            self.mass[axis, axis] += unit[at.UNIT_INERTIA + axis]
            self.damping[axis, axis] += drag * math.hypot(2.0 * flow[axis], self.drag_speed)
            self.drag_stiffness[axis, 2] += 2.0 * drag * abs(flow[axis]) * gradient[axis]

    def add_body(self, node: int, inertia: float, drag: float, position: Array) -> None:
        flow, gradient = self.flow(float(position[2]))
        speed = math.hypot(float(np.linalg.norm(flow)), self.drag_speed)
        by_flow = drag * speed * np.eye(3)
        if speed > 0.0:
            by_flow += drag * np.outer(flow, flow) / speed
        block = slice(3 * node, 3 * node + 3)
        self.mass[block, block] += inertia * np.eye(3)
        self.damping[block, block] += by_flow
        self.drag_stiffness[block, 3 * node + 2] += by_flow @ gradient
