"""The dynamic solver's own equilibrium against exact solutions and against a continuous cable integrated by itself."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import (
    CableParameters,
    CableSimParameters,
    ClumpsParameters,
    CurrentProfileParameters,
    SectionsParameters,
    UnitParameters,
)
from heave_node.numerics.kinematics import PointMotion
from scipy.integrate import solve_ivp
from scipy.optimize import root

from tests.validation.peers.reference_systems import s300, s900


def at_rest(parameters, payout=0.0):
    plant = CableDynamics(parameters)
    plant.start_at_equilibrium(np.zeros(3), payout)
    return plant


@pytest.mark.parametrize("parameters", [s300(1), s300(20), s900(100), s300(37)])
@pytest.mark.parametrize("payout", [0.0, 12.345, -7.1])
def test_free_hanging_stretch_and_top_tension_are_exact(parameters, payout):
    """Hooke's bar under its own weight: T(L) = W + w L, stretch = (W L + w L^2/2)/EA."""
    plant = at_rest(parameters, payout)
    length = parameters.length + payout
    w = parameters.cable.weight_in_fluid(parameters.water_density)
    unit = parameters.unit.weight_in_fluid(parameters.water_density)
    stretch = (unit * length + 0.5 * w * length**2) / parameters.cable.axial_stiffness
    assert plant.top_tension == pytest.approx(unit + w * length, rel=1e-9)
    assert -plant.unit_position[2] - length == pytest.approx(stretch, rel=1e-6)


def test_a_stiffening_rope_stretches_as_its_integral_says():
    """T = EA e (1 + q e + c e^2): stretch is the integral of e(T(s)); midpoints converge with 1/N^2, extrapolated
    to 1e-6.
    """
    rope = CableParameters(axial_stiffness=4e5, stiffness_quadratic=30.0, stiffness_cubic=200.0)

    def stretch(segments):
        parameters = dataclasses.replace(s300(segments), cable=rope)
        return -at_rest(parameters).unit_position[2] - 300.0

    unit = UnitParameters().weight_in_fluid(1025.0)
    w = rope.weight_in_fluid(1025.0)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    tensions = unit + w * 150.0 * (nodes + 1.0)
    strains = [
        min(r.real for r in np.roots([200.0, 30.0, 1.0, -t / 4e5]) if abs(r.imag) < 1e-12 and r.real > 0)
        for t in tensions
    ]
    exact = 150.0 * float(weights @ np.array(strains))
    coarse, fine = stretch(20), stretch(40)
    assert fine + (fine - coarse) / 3.0 == pytest.approx(exact, rel=1e-6)


def test_sections_and_clumps_add_their_weights():
    """Top tension is the sum of all weights in water."""
    parameters = dataclasses.replace(
        s300(30),
        sections=SectionsParameters(
            length=(50.0, 33.0), diameter=(0.06, 0.03), mass_per_length=(9.0, 3.0), axial_stiffness=(2e7, 8e6)
        ),
        clumps=ClumpsParameters(
            position=(20.0, 130.0),
            mass=(200.0, 300.0),
            volume=(0.02, 0.5),
            added_mass=(10.0, 100.0),
            drag_area=(0.1, 0.4),
        ),
    )
    g, rho = 9.80665, 1025.0
    lengths = np.array([50.0, 33.0, 217.0])
    mass = lengths @ np.array([9.0, 3.0, 5.4]) + 3000.0 + 500.0
    volume = lengths @ (0.25 * math.pi * np.array([0.06, 0.03, 0.047]) ** 2) + 0.354 + 0.52
    assert at_rest(parameters).top_tension == pytest.approx((mass - rho * volume) * g, rel=1e-9)


def test_a_marine_cable_in_sheared_current_converges_to_the_continuous_one():
    """A continuous elastic cable (Runge-Kutta from the unit, independent code); the lumped one approaches with
    1/N^2.
    """
    profile = CurrentProfileParameters(
        depth=(0.0, 150.0, 300.0), velocity_x=(1.5, 0.8, 0.2), velocity_y=(0.0, 0.5, 0.6)
    )
    base = dataclasses.replace(s300(20), current_profile=profile)
    exact = continuous_cable(base)

    def error(segments):
        unit = at_rest(dataclasses.replace(base, segments=segments)).unit_position
        return float(np.linalg.norm(unit - exact))

    errors = [error(n) for n in (20, 40, 80)]
    # the profile has a corner, so the order is judged over two halvings
    assert errors[2] < errors[0] / 10.0
    assert errors[2] == pytest.approx(0.0, abs=2e-3)


def continuous_cable(p: CableSimParameters) -> np.ndarray:
    """Return the unit's position below a top end at the origin, by shooting on the unit's depth."""
    cable, rho = p.cable, p.water_density
    w = cable.weight_in_fluid(rho)
    depths = np.array(p.current_profile.depth)
    ux, uy = np.array(p.current_profile.velocity_x), np.array(p.current_profile.velocity_y)

    def current(z):
        return np.array([np.interp(-z, depths, ux), np.interp(-z, depths, uy), 0.0])

    def slope(_, y):
        force = y[3:]
        tension = np.linalg.norm(force)
        e = force / tension
        u = current(y[2])
        along = u @ e
        across = u - along * e
        drag = 0.5 * rho * cable.normal_drag * cable.diameter * np.linalg.norm(across) * across
        drag += 0.5 * math.pi * rho * cable.tangential_drag * cable.diameter * abs(along) * along * e
        return np.concatenate([(1.0 + tension / cable.axial_stiffness) * e, np.array([0.0, 0.0, w]) - drag])

    def top(z):
        u = current(z)
        drag = 0.5 * rho * 1.5 * 0.5 * np.abs(u) * u
        start = np.concatenate([[0.0, 0.0, z], np.array([0.0, 0.0, p.unit.weight_in_fluid(rho)]) - drag])
        return solve_ivp(slope, (0.0, p.length), start, rtol=1e-10, atol=1e-10, max_step=2.0).y[:3, -1]

    z = root(lambda q: top(q[0])[2], [-300.0], tol=1e-10).x[0]
    end = top(z)
    return np.array([-end[0], -end[1], z])


LIGHT = dataclasses.replace(
    s300(25, (-2.0, 0.5)),
    cable=CableParameters(diameter=0.03, mass_per_length=1.6, normal_drag=2.0),
    unit=UnitParameters(mass=5.0, volume=0.0, added_mass=(0.0,) * 3),
)
"""A light cable that a current blows almost flat: its drag is several times its weight."""


@pytest.mark.parametrize("parameters", [s300(50, (1.2, -0.7)), LIGHT])
def test_a_run_from_equilibrium_has_no_transient(parameters):
    """Exact discrete equilibrium: after 60 s in a strong current nothing has moved by more than roundoff."""
    plant = at_rest(parameters)
    before, still = plant.node_positions, PointMotion()
    for _ in range(60):
        plant.advance(1.0, still, still, 0.0, 0.0, 0.0, 0.0)
    assert plant.node_positions == pytest.approx(before, abs=1e-8)
    assert plant.node_velocities == pytest.approx(0.0, abs=1e-9)
