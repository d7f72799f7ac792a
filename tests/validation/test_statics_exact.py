"""Statics against exact solutions: the elastic catenary, a point load, hard cases integrated independently."""

import itertools
import math

import numpy as np
import pytest
from heave_statics.network import NetworkCable, NetworkPoint, solve_network
from heave_statics.problems import mooring_cable, submerged_cable
from heave_statics.system import PointLoad, StaticSection, static_cable
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

from tests.validation.peers.catenaries import measure_statics

# thesis figs 2.4, 2.5: steel, 100 m, d = 0.02 m, E = 2e11 Pa, in air (steel 7850 kg/m3)
STEEL_AREA = 0.25 * math.pi * 0.02**2
STEEL_STIFFNESS = 2e11 * STEEL_AREA
STEEL_WEIGHT = 7850.0 * STEEL_AREA * 9.80665


def irvine(horizontal, vertical, length, weight, stiffness, s):
    """Elastic catenary from the end s = 0 (Irvine 1981), H and V the pulls of the cable's start on what holds it.

    V is positive where the cable pulls its support down, so the vertical tension is w s - V.
    """
    start = math.hypot(horizontal, vertical)
    along = weight * s - vertical
    here = np.hypot(horizontal, along)
    x = horizontal * s / stiffness
    x = x + horizontal / weight * (np.arcsinh(along / horizontal) + math.asinh(vertical / horizontal))
    z = (0.5 * weight * s**2 - vertical * s) / stiffness + (here - start) / weight
    return x, z


def exact_catenary(span, rise, length, weight, stiffness, guess):
    def miss(unknowns):
        x, z = irvine(unknowns[0], unknowns[1], length, weight, stiffness, length)
        return [x - span, z - rise]

    return fsolve(miss, guess, xtol=1e-13)


def test_elastic_catenary_between_two_levels_is_the_exact_one(gallery):
    # thesis fig. 2.4: ends 92.5 m apart and 8.6 m different in height (the table printed by Dodaran & Park)
    span, rise = 92.5, -8.6
    cable = static_cable([StaticSection(100.0, STEEL_STIFFNESS, STEEL_WEIGHT)], segments=20)
    shape = submerged_cable(cable, (0.0, 0.0, 0.0), (span, 0.0, rise))
    horizontal, vertical = exact_catenary(
        span, rise, 100.0, STEEL_WEIGHT, STEEL_STIFFNESS, [shape.end_force[0] * 1.1, shape.start_force[2] * 0.9]
    )
    x, z = irvine(horizontal, vertical, 100.0, STEEL_WEIGHT, STEEL_STIFFNESS, cable.labels)

    def draw(figure):
        axes = figure.subplots()
        curve = shape.curve()
        axes.plot(curve[:, 0], curve[:, 2], label="three unknowns, 20 segments")
        axes.plot(x, z, "o", fillstyle="none", label="exact (Irvine)")
        axes.set(xlabel="x [m]", ylabel="z [m]", aspect="equal")
        axes.legend()

    gallery(
        "statics_elastic_catenary", "Elastic steel catenary in air against Irvine's formula (thesis fig. 2.4).", draw
    )
    assert shape.end_force == pytest.approx([horizontal, 0.0, STEEL_WEIGHT * 100.0 - vertical], rel=1e-9, abs=1e-9)
    assert shape.positions[:, 0] == pytest.approx(x, abs=1e-8)
    assert shape.positions[:, 2] == pytest.approx(z, abs=1e-8)


def integrated_end(shape, sections, loads):
    """Integrate position and tension from the solver's start force with a Runge-Kutta code of its own."""
    position, tension = np.array(shape.positions[0]), -np.array(shape.start_force)
    marks = sorted({0.0, *np.cumsum([s.length for s in sections]), *(load.label for load in loads)})
    ends = np.cumsum([section.length for section in sections])
    for low, high in itertools.pairwise(marks):
        for load in loads:
            if load.label == low:
                tension = tension - np.array(load.force)
        section = sections[int(np.searchsorted(ends, 0.5 * (low + high)))]

        def slope(s, state, section=section):
            pull = state[3:]
            size = math.sqrt(pull @ pull)
            direction = pull / size * (1.0 + size / section.axial_stiffness)
            return [*direction, 0.0, 0.0, section.weight]

        answer = solve_ivp(slope, (low, high), [*position, *tension], rtol=1e-12, atol=1e-12, method="DOP853")
        position, tension = answer.y[:3, -1], answer.y[3:, -1]
    return position, tension


def test_point_load_on_a_hanging_cable(gallery):
    # thesis fig. 2.5: the steel catenary of fig. 2.4 level, with a load at mid-length; by symmetry half of it hangs at
    # each end
    load = PointLoad(50.0, (0.0, 0.0, -500.0))
    sections = [StaticSection(100.0, STEEL_STIFFNESS, STEEL_WEIGHT)]
    shape = submerged_cable(static_cable(sections, [load], segments=20), (0, 0, 0), (90.0, 0, 0))
    bare = submerged_cable(static_cable(sections, segments=20), (0, 0, 0), (90.0, 0, 0))

    def draw(figure):
        axes = figure.subplots()
        for label, answer in (("no load", bare), ("500 N at mid-length", shape)):
            curve = answer.curve()
            axes.plot(curve[:, 0], curve[:, 2], label=label)
        axes.set(xlabel="x [m]", ylabel="z [m]", aspect="equal")
        axes.legend()

    gallery("statics_point_load", "A hanging cable under a point load (thesis fig. 2.5).", draw)
    half = 0.5 * (500.0 + STEEL_WEIGHT * 100.0)
    assert shape.start_force[2] == pytest.approx(half, rel=1e-10)
    assert shape.end_force[2] == pytest.approx(half, rel=1e-10)
    assert shape.positions[len(shape.positions) // 2, 0] == pytest.approx(45.0, abs=1e-8)
    end, _ = integrated_end(shape, sections, [load])
    assert end == pytest.approx([90.0, 0.0, 0.0], abs=1e-7)
    assert shape.positions[:, 2].min() < bare.positions[:, 2].min() - 0.5


# name, length, EA, weight, end: kinds of the hard cases that MoorPy tests
HARD = [
    ("slack", 120.0, 1e7, 50.0, (60.0, 0.0, 40.0)),
    ("very slack, U-shaped", 300.0, 1e7, 50.0, (20.0, 0.0, 5.0)),
    ("U-shaped, ends almost above one another", 100.0, 1e7, 50.0, (0.01, 0.0, 60.0)),
    ("near-taut, just slack", 100.0, 1e8, 30.0, (99.9999, 0.0, 0.0)),
    ("near-taut, just stretched", 100.0, 1e8, 30.0, (100.0001, 0.0, 0.0)),
    ("taut and steep", 100.0, 1e6, 30.0, (30.0, 0.0, 96.0)),
    ("stretched by a half", 100.0, 1e5, 30.0, (120.0, 40.0, 80.0)),
    ("sloped", 150.0, 1e8, 20.0, (100.0, 30.0, 80.0)),
    ("sloped mirror", 150.0, 1e8, 20.0, (-100.0, -30.0, -80.0)),
    ("buoyant", 150.0, 1e8, -20.0, (100.0, 0.0, 50.0)),
    ("buoyant, near-taut", 150.0, 1e9, -20.0, (149.99, 0.0, 0.0)),
    ("almost neutral", 150.0, 1e8, 1e-4, (100.0, 0.0, 50.0)),
    ("stiff", 150.0, 1e13, 20.0, (149.0, 0.0, 10.0)),
    ("soft", 150.0, 1e3, 20.0, (149.0, 0.0, 10.0)),
    ("light and very long", 5000.0, 1e8, 5.0, (4000.0, 1000.0, 2000.0)),
]


@pytest.mark.parametrize(("name", "length", "stiffness", "weight", "end"), HARD, ids=[row[0] for row in HARD])
def test_hard_catenaries_agree_with_an_independent_integration(name, length, stiffness, weight, end):
    sections = [StaticSection(length, stiffness, weight)]
    shape = submerged_cable(static_cable(sections, segments=1), (0, 0, 0), end)
    assert shape.positions[-1] == pytest.approx(end, abs=1e-7 * length)
    reached, pull = integrated_end(shape, sections, [])
    # a cable folded back on itself turns its tension round within millimetres: the integrator's own error shows there
    assert reached == pytest.approx(end, abs=2e-6 * length)
    assert pull == pytest.approx(shape.end_force, rel=1e-9, abs=1e-9 * abs(weight) * length)
    middle = np.hypot(*shape.end_force[:2])
    assert middle == pytest.approx(np.hypot(*shape.start_force[:2]), rel=1e-9, abs=1e-12)


def test_tensions_agree_with_moorpy():
    """Catenaries of `make bench`; MoorPy's own solver stops at 1e-6 of the span."""
    pytest.importorskip("moorpy")
    assert [row["difference_percent"] for row in measure_statics(solves=1)] == pytest.approx([0.0] * 4, abs=1e-4)


def test_two_cables_to_one_load_agree_with_moorpy():
    """A heavy lift line and a light one from elsewhere; MoorPy's point of 2 t displaces nothing."""
    moorpy = pytest.importorskip("moorpy")
    system = moorpy.System(depth=400.0)
    kinds = {"heavy": (210.0, 1e7, 25.0, (0.0, 0.0, 0.0)), "light": (260.0, 2e6, 5.0, (-40.0, 15.0, 0.0))}
    points, ropes = {"unit": NetworkPoint(None, PointLoad(0.0, (0.0, 0.0, -2e4)))}, []
    system.addPoint(0, [0.0, 0.0, -200.0], m=2e4 / system.g)
    unknown = dict.fromkeys(("cost", "EAd", "EAd_Lm", "Cd", "CdAx", "Ca", "CaAx"), 0.0)
    for number, (name, (length, stiffness, weight, place)) in enumerate(kinds.items()):
        mass = system.rho * 0.25 * np.pi * 0.05**2 + weight / system.g
        sizes = {"name": name, "material": "", "d_vol": 0.05, "input_d": 0.05, "m": mass, "w": weight, "EA": stiffness}
        system.lineTypes[name] = unknown | sizes
        system.addPoint(1, list(place))
        system.addLine(length, name, pointA=1, pointB=number + 2)
        points[name] = NetworkPoint(place)
        ropes.append(NetworkCable("unit", name, static_cable([StaticSection(length, stiffness, weight)], segments=20)))
    system.initialize()
    system.solveEquilibrium(tol=1e-9)
    found = solve_network(points, ropes)
    assert found.places["unit"] == pytest.approx(system.pointList[0].r, abs=1e-6)
    for shape, line in zip(found.shapes, system.lineList, strict=True):
        assert (np.linalg.norm(shape.start_force), shape.top_tension) == pytest.approx((line.TA, line.TB), rel=1e-7)


def test_the_sloped_mirror_has_the_forces_of_the_sloped_cable_exchanged():
    cable = static_cable([StaticSection(150.0, 1e8, 20.0)], segments=1)
    one = submerged_cable(cable, (0, 0, 0), (100.0, 30.0, 80.0))
    other = submerged_cable(cable, (0, 0, 0), (-100.0, -30.0, -80.0))
    assert one.end_force == pytest.approx(other.start_force, rel=1e-9)


def test_one_segment_is_as_good_as_many_without_current():
    # the closed form has no discretisation error under uniform load
    few = submerged_cable(static_cable([StaticSection(150.0, 1e6, 20.0)], segments=1), (0, 0, 0), (100.0, 30.0, 80.0))
    many = submerged_cable(
        static_cable([StaticSection(150.0, 1e6, 20.0)], segments=500), (0, 0, 0), (100.0, 30.0, 80.0)
    )
    assert many.end_force == pytest.approx(few.end_force, rel=1e-9)


def test_sections_of_different_cable_agree_with_an_independent_integration():
    # chain, wire, buoyant rope and a clump between them, in space
    sections = [
        StaticSection(80.0, 5e7, 300.0),
        StaticSection(120.0, 2e7, 40.0),
        StaticSection(60.0, 1e6, -5.0),
        StaticSection(40.0, 2e7, 40.0),
    ]
    loads = [PointLoad(200.0, (0.0, 500.0, 8000.0))]
    end = np.array([180.0, 40.0, 150.0])
    shape = submerged_cable(static_cable(sections, loads, segments=4), (0, 0, 0), end)
    reached, pull = integrated_end(shape, sections, loads)
    assert reached == pytest.approx(end, abs=1e-5)
    assert pull == pytest.approx(shape.end_force, rel=1e-9)


def test_a_moored_body_floats_where_the_catenary_says():
    # exact: with horizontal pull H and the end h above the anchor, H, V from Irvine's z; x follows
    length, stiffness, weight, height, pull = 400.0, 5e7, 60.0, 150.0, 2.0e4
    shape = mooring_cable(
        static_cable([StaticSection(length, stiffness, weight)], segments=1), (0, 0, 0), height, (pull, 0)
    )
    vertical = shape.start_force[2]
    x, z = irvine(pull, vertical, length, weight, stiffness, length)
    assert z == pytest.approx(height, abs=1e-8)
    assert shape.positions[-1] == pytest.approx([x, 0.0, height], abs=1e-7)
    assert shape.end_force[2] == pytest.approx(weight * length - vertical, rel=1e-12)
