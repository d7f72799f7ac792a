"""A static network of cables, thesis 2.7: named there as further work, without an equation or a number.

No command solves one. What is shown: the cables of a network are the thesis's submerged cables, so that a junction is
where the forces of the ends that meet there, and its load, balance.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
from heave_statics.problems import submerged_cable
from heave_statics.system import StaticSection, static_cable
from scipy.optimize import brentq, fsolve

from tests.validation.test_statics_exact import irvine


class Leg(NamedTuple):
    """A cable from one point of the network to another, by number: fixed points first, then junctions."""

    start: int
    end: int
    length: float
    stiffness: float
    weight: float


def junctions_of(fixed, legs, loads, guess):
    """Return where the junctions come to rest under vertical `loads` [N], positive up, and the tensions there.

    The tensions are those of each leg at its end [N].
    """
    cables = [static_cable([StaticSection(leg.length, leg.stiffness, leg.weight)], segments=1) for leg in legs]

    def solved(unknowns):
        points = [*np.asarray(fixed, dtype=float), *np.reshape(unknowns, (-1, 3))]
        shapes = [submerged_cable(c, points[leg.start], points[leg.end]) for c, leg in zip(cables, legs, strict=True)]
        return points, shapes

    def out_of_balance(unknowns):
        points, shapes = solved(unknowns)
        forces = np.zeros((len(points), 3))
        for leg, shape in zip(legs, shapes, strict=True):
            forces[leg.start] -= shape.start_force
            forces[leg.end] -= shape.end_force
        forces[len(fixed) :, 2] += loads
        return forces[len(fixed) :].ravel()

    found, _, status, message = fsolve(out_of_balance, np.ravel(guess), xtol=1e-13, full_output=True)
    assert status == 1 or np.abs(out_of_balance(found)).max() < 1e-6, message
    _, shapes = solved(found)
    return np.reshape(found, (-1, 3)), [float(np.linalg.norm(shape.end_force)) for shape in shapes]


@pytest.mark.parametrize("legs", [2, 3, 5])
def test_equal_legs_hold_their_load_as_one_catenary_each(legs):
    """By symmetry each leg carries 1/n of the load at its end: Irvine's catenary of known vertical pull."""
    radius, length, stiffness, weight, load = 80.0, 100.0, 2e6, 15.0, 9000.0
    angles = 2.0 * math.pi * np.arange(legs) / legs
    fixed = np.column_stack((radius * np.cos(angles), radius * np.sin(angles), np.zeros(legs)))
    spokes = [Leg(k, legs, length, stiffness, weight) for k in range(legs)]
    found, tensions = junctions_of(fixed, spokes, [-load], [[1.0, 2.0, -50.0]])
    vertical = weight * length + load / legs
    pull = brentq(lambda h: irvine(h, vertical, length, weight, stiffness, length)[0] - radius, 10.0, 1e6, xtol=1e-10)
    depth = irvine(pull, vertical, length, weight, stiffness, length)[1]
    assert found[0] == pytest.approx([0.0, 0.0, depth], abs=1e-6)
    assert tensions == pytest.approx([math.hypot(pull, load / legs)] * legs, rel=1e-8)


def test_two_joined_junctions_come_to_rest_where_moorpy_puts_them():
    """Four unlike legs to anchors, a cable between their junctions, a buoy on one and a weight on the other."""
    moorpy = pytest.importorskip("moorpy")
    fixed = [(-120.0, -60.0, -150.0), (-100.0, 90.0, -140.0), (150.0, -70.0, -30.0), (130.0, 80.0, -10.0)]
    legs = [
        Leg(0, 4, 150.0, 5e6, 40.0),
        Leg(1, 4, 145.0, 2e6, 25.0),
        Leg(2, 5, 130.0, 1e7, 60.0),
        Leg(3, 5, 120.0, 5e6, 10.0),
        Leg(4, 5, 95.0, 1e6, 8.0),
    ]
    loads, guess = [30e3, -12e3], [[-40.0, 0.0, -40.0], [45.0, 0.0, -90.0]]
    found, tensions = junctions_of(fixed, legs, loads, guess)
    peer = moorpy.System(depth=5000.0, rho=1025.0, g=9.80665)
    for place in fixed:
        peer.addPoint(1, place)
    for place, load in zip(guess, loads, strict=True):
        peer.addPoint(0, place, fExt=[0.0, 0.0, load])
    for number, leg in enumerate(legs):
        name, mass = f"cable {number}", abs(leg.weight) / 9.80665
        peer.setLineType(1.0, name=name, mass=mass, d_vol=1e-6, w=leg.weight, EA=leg.stiffness)
        peer.addLine(leg.length, name, pointA=leg.start + 1, pointB=leg.end + 1)
    peer.initialize()
    peer.solveEquilibrium(tol=1e-8, maxIter=2000)
    assert found == pytest.approx(np.array([point.r for point in peer.pointList[4:]]), abs=1e-6)
    assert tensions == pytest.approx([float(np.linalg.norm(line.fB)) for line in peer.lineList], rel=1e-8)
