"""The three-dimensional line, linearised about its equilibrium: mass, damping and stiffness matrices, modes, responses.

The lumped line of `dynamics` moves a little about the position in which it hangs in its current: node 0 is the unit,
node N the boom tip, whose motion is the input. Drag is linear about the steady flow; where the water is still it is
linearised about a speed amplitude. Bending, seabed and compensator are left out.
"""

from __future__ import annotations

import bisect
import math
from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array, ComplexArray
from numpy.typing import ArrayLike
from scipy.linalg import eigh

from cable_sim_node.errors import LinearisationError
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.physics.current import Current, current_at, current_of
from cable_sim_node.physics.drag import HARMONIC_DRAG, linear_drag, segment_drag
from cable_sim_node.physics.properties import (
    BodyProperties,
    CableProperties,
    UnitProperties,
    body_properties,
    cable_sections,
    unit_properties,
)
from cable_sim_node.physics.tension_law import strain_at, tangent_stiffness


@dataclass(frozen=True)
class LineResponse:
    """Answer to boom-tip motion at each frequency; the last axis is the boom tip's x, y, z."""

    omegas: Array  # [rad/s]
    unit: ComplexArray  # unit motion over boom-tip motion, shape (k, 3, 3) [-]
    top_tension: ComplexArray  # top tension over boom-tip motion, shape (k, 3) [N/m]


@dataclass(frozen=True)
class LinearLine:
    """M x'' + C x' + K x = force, x the displacements of all nodes, x y z of node 0 first, the boom tip's last."""

    mass: Array  # shape (3N + 3, 3N + 3) [kg]
    damping: Array  # the same shape [N s/m]; drag makes it unsymmetric
    stiffness: Array  # the same shape [N/m]; drag makes it unsymmetric
    elastic: Array  # the stiffness without drag, symmetric
    labels: Array  # unstretched length from the unit to each node [m]
    positions: Array  # of the equilibrium, shape (N + 1, 3) [m]

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
        """Return unit motion and top tension for harmonic boom-tip motion at `omegas` [rad/s], shape (k,)."""
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
    """Make the line linear about the equilibrium in which it hangs.

    Parameters
    ----------
    parameters : of the plant
    boom_tip : position [m], shape (3,)
    payout : cable let out beyond the parameters' length [m]
    speed_amplitude : amplitude of the oscillating flow past cable and unit for which their quadratic drag is made
        linear at equal energy [m/s]; it adds to the drag of the steady current as the root of the sum of squares

    Raises
    ------
    NoEquilibriumError
        where the line does not hang.
    LinearisationError
        where it lies on the seabed.
    """
    dynamics = CableDynamics(parameters)
    dynamics.start_at_equilibrium(boom_tip, payout)
    if dynamics.is_on_seabed:
        raise LinearisationError(
            f"unit or cable lie on the seabed at {parameters.seabed.depth:g} m: there is no linear model of contact; "
            "shorten `length` or make the seabed deeper"
        )
    positions, tensions = dynamics.node_positions, dynamics.segment_tensions
    labels = dynamics.material_coordinates
    matrices = _Matrices(len(positions), current_of(parameters), HARMONIC_DRAG * speed_amplitude)
    sections = cable_sections(parameters)
    starts = [section.start for section in sections]
    for index, tension in enumerate(tensions):
        low, high = float(labels[index]), float(labels[index + 1])
        cable = sections[bisect.bisect_right(starts, 0.5 * (low + high)) - 1].cable
        matrices.add_segment(index, cable, high - low, positions[index : index + 2], float(tension))
    matrices.add_unit(unit_properties(parameters, -float(positions[0, 2])), positions[0])
    for body in body_properties(parameters):
        if body.label <= labels[-1]:
            node = int(np.argmin(np.abs(labels - body.label)))
            matrices.add_body(node, body, positions[node])
    return LinearLine(
        matrices.mass, matrices.damping, matrices.elastic + matrices.drag_stiffness, matrices.elastic, labels, positions
    )


class _Matrices:
    """The matrices of a line of `nodes` nodes in `current`, to which its parts are added one by one.

    `drag_speed` [m/s] is the amplitude of the oscillating flow, times HARMONIC_DRAG.
    """

    def __init__(self, nodes: int, current: Current, drag_speed: float) -> None:
        self.mass, self.damping, self.elastic, self.drag_stiffness = np.zeros((4, 3 * nodes, 3 * nodes))
        self._profile = current.profile
        self._drag_speed = drag_speed

    def _flow(self, height: float) -> tuple[Array, Array]:
        """Return the current at z = `height` and its derivative by depth."""
        flow, gradient = current_at(-height, self._profile, 1.0)
        return np.array(flow), np.array(gradient)

    def add_segment(self, index: int, cable: CableProperties, length: float, ends: Array, tension: float) -> None:
        """Add segment `index` of `length` [m] between positions `ends`, shape (2, 3), under `tension` [N]."""
        chord = ends[1] - ends[0]
        stretched = float(np.linalg.norm(chord))
        along = chord / stretched
        across = np.eye(3) - np.outer(along, along)
        law = (cable.axial_stiffness, cable.quadratic, cable.cubic)
        slope = tangent_stiffness(*law, strain_at(*law, tension))
        spring = slope / length * np.outer(along, along) + tension / stretched * across
        damper = cable.internal_damping / length * np.outer(along, along)
        half_mass = 0.5 * length * (cable.mass * np.eye(3) + cable.added_mass * across)
        nodes = (slice(3 * index, 3 * index + 3), slice(3 * index + 3, 3 * index + 6))
        for node, other in (nodes, nodes[::-1]):
            self.elastic[node, node] += spring
            self.elastic[node, other] -= spring
            self.damping[node, node] += damper
            self.damping[node, other] -= damper
            self.mass[node, node] += half_mass
        self._add_drag(nodes, cable, length, chord, 0.5 * float(ends[0, 2] + ends[1, 2]))

    def _add_drag(
        self, nodes: tuple[slice, slice], cable: CableProperties, length: float, chord: Array, height: float
    ) -> None:
        flow, gradient = current_at(-height, self._profile, 1.0)
        by_chord, by_flow, damper = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
        drag = (cable.normal_drag, cable.tangential_drag)
        segment_drag(chord, flow, 0.0, *drag, by_chord, by_flow)
        linear_drag(chord, flow, self._drag_speed, *drag, damper)
        by_depth = by_flow @ gradient
        lower, upper = nodes
        for node in nodes:
            for other, sign in ((lower, -1.0), (upper, 1.0)):
                self.damping[node, other] += 0.25 * length * damper
                self.drag_stiffness[node, other] -= 0.5 * sign * length * by_chord
                self.drag_stiffness[node, other.start + 2] += 0.25 * length * by_depth  # depth = -z

    def add_unit(self, unit: UnitProperties, position: Array) -> None:
        """Add the unit at node 0, which is at `position` [m]."""
        flow, gradient = self._flow(float(position[2]))
        for axis in range(3):
            drag = unit.drag[axis]
            self.mass[axis, axis] += unit.inertia[axis]
            self.damping[axis, axis] += drag * math.hypot(2.0 * flow[axis], self._drag_speed)
            self.drag_stiffness[axis, 2] += 2.0 * drag * abs(flow[axis]) * gradient[axis]
        self._add_round_drag(slice(0, 3), unit.body_drag, flow, gradient)

    def add_body(self, node: int, body: BodyProperties, position: Array) -> None:
        """Add a body that is clamped on the cable at `node`, which is at `position` [m]."""
        flow, gradient = self._flow(float(position[2]))
        block = slice(3 * node, 3 * node + 3)
        self.mass[block, block] += (body.mass + body.added_mass) * np.eye(3)
        self._add_round_drag(block, body.drag, flow, gradient)

    def _add_round_drag(self, block: slice, drag: float, flow: Array, gradient: Array) -> None:
        """Add isotropic drag, (1/2) rho C_D S = `drag`, at the node of rows `block`."""
        speed = math.hypot(float(np.linalg.norm(flow)), self._drag_speed)
        by_flow = drag * speed * np.eye(3)
        if speed > 0.0:
            by_flow += drag * np.outer(flow, flow) / speed
        self.damping[block, block] += by_flow
        self.drag_stiffness[block, block.start + 2] += by_flow @ gradient
