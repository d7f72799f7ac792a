"""Misprints of the sources that no run shows: each printed form beside the exact one.

The others are named where they are used: 4.10 in `test_dynamics_waves.py`, 4.5.5 in `test_chapter4_lowering.py`, 5.18
to 5.20 in `test_dynamics_chain.py`, 12.4.5 in `test_drag.py` of the plant, chapter 6 in `test_thesis_gains.py`, Pinto's
Eq. 15 in `test_dynamics_examples.py`, his Eq. 16 in `test_hanging_report.py`, figure 1 in `test_laying_on_slopes.py`.
"""

import math

import numpy as np
import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableSimParameters
from heave_node.numerics.constants import SEAWATER_DENSITY, STANDARD_GRAVITY
from heave_node.numerics.kinematics import PointMotion
from heave_statics.problems import submerged_cable
from heave_statics.system import StaticSection, static_cable

from tests.validation.peers.driven_run import smooth_start

EA, MU = 1.6e6, 5.4
"""A soft wire [N], [kg/m]."""


def test_the_second_tension_of_5_4_needs_the_length_of_its_own_segment():
    """(T/EA + 1)^2 l^2 is the squared distance of the nodes: l_{i-1/2} below node i, where l_{i+1/2} is printed."""
    plant = CableDynamics(CableSimParameters(length=300.0, segments=20))
    plant.start_at_equilibrium(np.zeros(3))
    rest = PointMotion(0.0, np.zeros(3), np.zeros(3))
    for k in range(20):  # 2.5 m are paid out: the uppermost segment grows
        (out, rate), (after, rate_after) = (smooth_start(0.25 * tick, 5.0) for tick in (k, k + 1))
        plant.advance(0.25, rest, rest, out, rate, after, rate_after)
    own = np.diff(plant.material_coordinates)[-2:]
    strain = plant.segment_tensions[-2] / CableSimParameters().cable.axial_stiffness
    distance = np.linalg.norm(np.diff(plant.node_positions, axis=0)[-2])
    assert (1.0 + strain) * own[0] == pytest.approx(distance, rel=1e-9)
    assert abs((1.0 + strain) * own[1] / distance - 1.0) > 0.1


def test_the_first_terms_of_j_in_12_11_need_one_over_mu():
    """J is minus the slope of the tension vector by r_s over mu: along the wire T_eps/mu, across T/((1 + e) mu).

    The slope is taken by differences. As printed its first terms are mu times too large.
    """
    tangent, strain = np.array([2.0, -1.0, 2.0]) / 3.0, 0.05

    def pull(slope):
        size = np.linalg.norm(slope)
        return EA * (size - 1.0) * slope / size

    at, step = (1.0 + strain) * tangent, 1e-6
    stiffness = np.column_stack([(pull(at + step * one) - pull(at - step * one)) / (2.0 * step) for one in np.eye(3)])
    tension = EA * strain
    first = ((1.0 + strain) * EA - tension) / (1.0 + strain) ** 3 * np.outer(at, at)
    second = tension / (1.0 + strain) * np.eye(3)
    assert (first + second) / MU == pytest.approx(stiffness / MU, rel=1e-6, abs=1e-6 * EA)
    speeds = np.sqrt(np.linalg.eigvalsh((first + second) / MU))
    assert speeds == pytest.approx([math.sqrt(tension / (1.0 + strain) / MU)] * 2 + [math.sqrt(EA / MU)])
    assert math.sqrt(np.linalg.eigvalsh(first + second / MU)[-1]) > 2.0 * speeds[-1]


def test_the_root_of_12_4_2_has_an_eighth_of_the_square():
    strain = 0.1
    assert math.sqrt(1.0 + strain) == pytest.approx(1.0 + strain / 2.0 - strain**2 / 8.0, abs=strain**3 / 16.0)
    assert abs(math.sqrt(1.0 + strain) - (1.0 + strain / 2.0 - strain**2 / 4.0)) > strain**2 / 10.0


def test_pintos_equation_2_is_the_curvature_vector():
    """d2r/dp2 at the lowest point of a stiff catenary is w/H, here 1/a = 1/80 m, not 1."""
    a, half = 80.0, 60.0
    section = StaticSection(2.0 * a * math.sinh(half / a), 1e12, 20.0)
    shape = submerged_cable(static_cable([section], segments=400), (-half, 0.0, 0.0), (half, 0.0, 0.0))
    middle, step = 200, section.length / 400
    second = shape.positions[middle + 1] - 2.0 * shape.positions[middle] + shape.positions[middle - 1]
    assert np.linalg.norm(second) / step**2 == pytest.approx(1.0 / a, rel=1e-4)


@pytest.mark.parametrize(
    ("diameter", "mass", "drag", "weight", "printed_weight", "constant", "printed_constant"),
    [(0.0332, 2.70, 1.64, 17.78, 17.80, 0.7987, 0.7974), (0.0264, 1.64, 2.12, 10.58, 10.96, 0.6181, 0.6173)],
    ids=["heavy", "light"],
)
def test_pintos_table_1_against_its_own_mass_and_equation_21(
    diameter, mass, drag, weight, printed_weight, constant, printed_constant
):
    """Weight is (m - rho pi d^2/4) g: of the light cable it is printed 3.6 % too high. H = sqrt(2 w/(C_D rho d))."""
    by_mass = (mass - SEAWATER_DENSITY * 0.25 * math.pi * diameter**2) * STANDARD_GRAVITY
    assert by_mass == pytest.approx(weight, abs=0.01)
    assert printed_weight / by_mass - 1.0 == pytest.approx(0.036 if diameter < 0.03 else 0.001, abs=1e-3)
    by_weight = math.sqrt(2.0 * printed_weight / (drag * SEAWATER_DENSITY * diameter))
    assert by_weight == pytest.approx(constant, abs=1e-4)
    assert by_weight - printed_constant == pytest.approx(0.001, abs=4e-4)
