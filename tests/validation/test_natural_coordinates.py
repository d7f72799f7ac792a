"""The thesis's appendix 12.5: the cable in natural coordinates, against its own characteristics and the plant's solver.

The appendix prints equations and no figure or number. So its matrices are held against its eigenvalues and
characteristic equations; and its seven equations, solved by themselves, against the Cartesian lumped line.
"""

import itertools
import math

import numpy as np
import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableParameters, CableSimParameters, SolverParameters, UnitParameters
from heave_node.numerics.constants import SEAWATER_DENSITY
from heave_node.numerics.kinematics import PointMotion
from hypothesis import given
from hypothesis import strategies as st

from tests.validation.natural_coordinates import NaturalCable, rotation, system_matrices

EA, TENSION = 2e5, 3000.0


@st.composite
def states(draw):
    """Draw strain, phi, theta and velocities of an inclined cable."""
    angles = [draw(st.floats(-1.3, 1.3)), draw(st.floats(-3.0, 3.0))]
    return np.array([draw(st.floats(1e-3, 0.1)), *angles, *(draw(st.floats(-5.0, 5.0)) for _ in range(3))])


def speeds(y, mu):
    """Return the six eigenvalues that the text prints below Eq. 12.44."""
    strain, phi, _, vz, vy, _ = y
    mx, my, mz = mu
    tension = EA * strain
    found = [math.sqrt(EA / mz), -math.sqrt(EA / mz)]
    for m, drift in ((my, vz * (1.0 - mz / my)), (mx, vz * (1.0 - mz / mx) + math.tan(phi) * vy * (1.0 - my / mx))):
        middle = -0.5 * drift / (1.0 + strain)
        half = math.sqrt(middle**2 + tension / ((1.0 + strain) * m))
        found += [middle + half, middle - half]
    return found


@given(y=states(), mu=st.tuples(*[st.floats(1.0, 10.0)] * 3))
def test_the_matrices_have_the_printed_eigenvalues(y, mu):
    a, b = system_matrices(y, mu, EA * y[0], EA)
    system = np.linalg.solve(a, b)
    for speed in speeds(y, mu):
        smallest = np.linalg.svd(system - speed * np.eye(6), compute_uv=False)[-1]
        assert smallest < 1e-9 * np.linalg.norm(system)


@given(y=states())
def test_the_characteristic_equations_are_the_left_eigenvectors(y):
    """Eqs. 12.45 to 12.50, for mu alike in all directions: l (dY - force) = 0 along ds/dt = lambda."""
    strain, phi, _, vz, vy, vx = y
    mu = 5.0
    a, b = system_matrices(y, (mu, mu, mu), EA * strain, EA)
    system = np.linalg.solve(a, b)
    tensile = math.sqrt(EA / mu)
    transverse, c = math.sqrt(EA * strain / ((1.0 + strain) * mu)), math.sqrt(EA * strain * (1.0 + strain) / mu)
    sp, cp = math.sin(phi), math.cos(phi)
    for sign in (1.0, -1.0):
        for speed, row in (
            (sign * tensile, (-sign * tensile, vy, vx * cp, 1.0, 0.0, 0.0)),
            (sign * transverse, (0.0, sign * c - vz, vx * sp, 0.0, 1.0, 0.0)),
            (sign * transverse, (0.0, 0.0, sign * c * cp - vy * sp - vz * cp, 0.0, 0.0, 1.0)),
        ):
            left = np.array(row)
            assert np.abs(left @ system - speed * left).max() < 1e-9 * np.linalg.norm(left) * np.linalg.norm(system)
            # A^-1 C = (0, 0, 0, -F_z, -F_y, -F_x)/mu
            assert left @ np.linalg.solve(a, np.array([1.0, 2.0, 3.0, 0.0, 0.0, 0.0])) == pytest.approx(
                left[3:] @ np.array([1.0, 2.0, 3.0]) / mu, rel=1e-9, abs=1e-12
            )


# --- solved beside the plant

LENGTH, MASS, DIAMETER = 200.0, 5.4, 0.012
INCLINED, HEADING = math.radians(35.0), math.radians(20.0)
ALONG = rotation(INCLINED, HEADING)[2]
DURATION = 16.0


def top(t):
    """Return the top end's motion from its start: 3 m and 5 m across the line, 0.2 m along it, each with its period."""
    s = min(t / 4.0, 1.0)
    grown, growing = s**3 * (10.0 - 15.0 * s + 6.0 * s * s), 7.5 * s * s * (1.0 - s) ** 2
    sizes, omega = np.array([3.0, 5.0, 0.2]), np.array([0.7, 0.45, 0.8])
    wave, slope = np.sin(omega * t), omega * np.cos(omega * t)
    own = rotation(INCLINED, HEADING).T
    return PointMotion(t, own @ (sizes * grown * wave), own @ (sizes * (growing * wave + grown * slope)))


def natural(cells, density):
    drag = (0.5 * density * 1.2 * DIAMETER, 0.5 * math.pi * density * 0.01 * DIAMETER)
    cable = NaturalCable(
        cells, length=LENGTH, stiffness=EA, mass=MASS, drag=drag, tension=TENSION, direction=(INCLINED, HEADING)
    )
    steps = math.ceil(DURATION * math.sqrt(EA / MASS) * cells / LENGTH)  # a tensile wave passes one cell in a step
    cable.advance(0.0, DURATION, steps, lambda t: top(t).velocity)
    return cable.positions(), cable.tensions()


def cartesian(segments, density):
    plant = CableDynamics(
        CableSimParameters(
            length=LENGTH,
            segments=segments,
            water_density=density,
            surface=False,
            gravity=0.0,
            cable=CableParameters(
                diameter=DIAMETER, mass_per_length=MASS, axial_stiffness=EA, added_mass=0.0, normal_drag=1.2
            ),
            unit=UnitParameters(
                mass=1e9,
                volume=0.0,
                added_mass=(0.0,) * 3,
                drag_coefficient=(0.0,) * 3,
                thrust=tuple((-TENSION * ALONG).tolist()),
            ),
            solver=SolverParameters(time_step=0.2 / segments, spectral_radius=1.0, tolerance=1e-8),
        )
    )
    start = LENGTH * (1.0 + TENSION / EA) * ALONG
    plant.start_at_equilibrium(start)
    tips = [PointMotion(m.time, m.position + start, m.velocity) for m in map(top, np.linspace(0.0, DURATION, 161))]
    for before, after in itertools.pairwise(tips):
        plant.advance(0.1, before, after, 0.0, 0.0, 0.0, 0.0)
    return plant.node_positions - plant.unit_position, plant.segment_tensions


def limit(solver, cells, density):
    """Return the positions of 21 points and the mean tension of each tenth, of a second-order solver at its limit."""
    found = []
    for count in (cells, 2 * cells):
        positions, tensions = solver(count, density)
        found.append((positions[:: count // 20], tensions.reshape(10, -1).mean(axis=1)))
    return tuple((4.0 * fine - coarse) / 3.0 for coarse, fine in zip(*found, strict=True))


@pytest.mark.parametrize("density", [0.0, SEAWATER_DENSITY])
def test_the_equations_in_natural_coordinates_move_the_cable_as_the_lumped_line_does(density):
    """In vacuum and in water: a line of 200 m that is bent by metres and drawn by a sixth more than at rest, or more.

    In water 6 mm and 7 N are what the staggered grid leaves at 40 and 80 cells; at 80 and 160 it is a sixth of that.
    """
    shape, pull = limit(natural, 40, density)
    other_shape, other_pull = limit(cartesian, 40, density)
    bend = shape - np.linspace(0.0, 1.0, 21)[:, None] * shape[-1]
    assert np.abs(bend).max() > 3.0
    assert abs(pull.mean() - TENSION) > 400.0
    assert shape == pytest.approx(other_shape, abs=0.008)
    assert pull == pytest.approx(other_pull, abs=9.0)
