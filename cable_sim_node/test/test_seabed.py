"""The shape of the seabed: the same for kernels and for Python, and what rests on a hill stays."""

import dataclasses
import math

import numpy as np
import pytest
from cable_sim_node.line.dynamics import CableDynamics
from cable_sim_node.parameters import CableSimParameters, SeabedParameters, SeabedProfileParameters, UnitParameters
from cable_sim_node.physics.seabed import Seabed, height_and_slope
from heave_node.numerics.kinematics import PointMotion
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

HILLS = SeabedProfileParameters(distance=(-40.0, -10.0, 5.0, 60.0), height=(2.0, -3.0, 4.0, 4.0), direction=0.7)
BED = SeabedParameters(depth=100.0, slope=(0.05, -0.02), profile=HILLS)


def table_of(seabed):
    return np.append([7.0, 8.0], seabed.profile)  # something goes before it, as in the settings of the kernels


@given(x=st.floats(-100.0, 100.0), y=st.floats(-100.0, 100.0))
def test_kernels_and_python_see_the_same_bottom(x, y):
    """Plane plus monotone cubic; scipy's own interpolation inside, the last points' height beyond."""
    bottom = Seabed(BED)
    s = math.cos(0.7) * x + math.sin(0.7) * y
    plane = -100.0 + 0.05 * x - 0.02 * y
    height, slope = height_and_slope.py_func(s, table_of(bottom), 2, 4)
    assert bottom.height((x, y)) == pytest.approx(plane + height, abs=1e-9)
    assert bottom.clearance((x, y, 3.0)) == pytest.approx(3.0 - plane - height, abs=1e-9)
    if -10.0 < s < 5.0:
        assert height == pytest.approx(float(PchipInterpolator(HILLS.distance, HILLS.height)(s)), abs=1e-9)
    if not -40.0 < s < 60.0:
        assert (height, slope) == (2.0 if s < 0.0 else 4.0, 0.0)


@given(s=st.floats(-50.0, 70.0))
def test_the_slope_is_the_derivative_of_the_height_and_never_jumps(s):
    table = table_of(Seabed(BED))
    h = 1e-5
    low, middle, high = (height_and_slope.py_func(at, table, 2, 4) for at in (s - h, s, s + h))
    assert middle[1] == pytest.approx((high[0] - low[0]) / (2.0 * h), abs=1e-4)


def test_a_bottom_without_a_profile_is_a_plane():
    bottom = Seabed(dataclasses.replace(BED, profile=SeabedProfileParameters()))
    assert bottom.height((10.0, 20.0)) == pytest.approx(-100.0 + 0.5 - 0.4)
    assert height_and_slope.py_func(3.0, np.zeros(2), 2, 0) == (0.0, 0.0)


def test_a_profile_that_makes_no_sense_is_refused():
    for distance, height, message in (
        ((0.0, 1.0), (0.0,), "same number"),
        ((0.0,), (0.0,), "two points"),
        ((1.0, 0.0), (0.0, 0.0), "increasing"),
        ((0.0, math.nan), (0.0, 0.0), "not allowed"),
    ):
        with pytest.raises(ValueError, match=message):
            SeabedProfileParameters(distance=distance, height=height)


def started(height, friction):
    """Return the 100 m line with more cable than the way down to a bottom that rises by `height` over 60 m."""
    profile = SeabedProfileParameters(
        distance=(-30.0, -10.0, 10.0, 30.0), height=(0.0, height / 4, height * 0.75, height)
    )
    seabed = SeabedParameters(depth=100.0, friction=friction, profile=profile)
    plant = CableDynamics(CableSimParameters(length=100.0, segments=20, seabed=seabed, unit=UnitParameters()))
    plant.start_at_equilibrium(np.zeros(3))
    return plant


def test_a_unit_on_the_side_of_a_hill_rests_with_its_weight_on_the_bottom():
    """It stands below the boom tip, where the bottom is at half the height and its slope is that of the cubic."""
    plant = started(6.0, 0.5)
    before, still = plant.node_positions, PointMotion()
    assert plant.touchdown
    assert plant.unit_position[2] == pytest.approx(
        Seabed(plant.parameters.seabed).height(plant.unit_position), abs=0.05
    )
    assert plant.touchdown_force == pytest.approx(UnitParameters().weight_in_fluid(1025.0), rel=0.02)
    for _ in range(120):
        plant.advance(0.5, still, still, 0.0, 0.0, 0.0, 0.0)
    assert plant.node_positions == pytest.approx(before, abs=1e-7)  # 1e-9 of the weight is left unbalanced


def test_what_stands_on_a_deck_goes_with_the_boom_tip_and_is_lifted_off_it_by_a_taut_rope_alone():
    """A deck pushes only: a unit on it, a(t) the ship's acceleration, presses on it with m (g + a) - B by Newton."""
    plant = CableDynamics(
        CableSimParameters(
            length=20.2,
            segments=5,
            unit=UnitParameters(drag_area=(0.0, 0.0, 0.0), added_mass=(0.0, 0.0, 0.0)),
            seabed=SeabedParameters(depth=20.0, deck=True, unit_stiffness=1e8, unit_damping=1e6),
        )
    )
    tip, omega, tick = np.array([0.0, 0.0, -30.0]), 1.0, 0.05
    plant.start_at_equilibrium(tip)
    weight = plant.touchdown_force

    def at(time):
        heave = np.array([0.0, 0.0, 1.0])
        rise = 1.0 - math.cos(omega * time)
        return PointMotion(time, tip + rise * heave, math.sin(omega * time) * omega * heave)

    # at the crest the tip is held, and the winch hauls in the slack and 0.3 m
    for k in range(round(math.pi / tick)):
        plant.advance(tick, at(k * tick), at((k + 1) * tick), 0.0, 0.0, 0.0, 0.0)
        down = at((k + 1) * tick).position[2] - 20.0
        assert plant.unit_position[2] == pytest.approx(down, abs=1e-3)
        if k > 5:
            inertia = plant.parameters.unit.mass * omega**2 * math.cos(omega * (k + 1) * tick)
            assert plant.touchdown_force == pytest.approx(weight + inertia, rel=0.05)
    assert plant.touchdown
    crest = at(math.pi)
    still = PointMotion(0.0, crest.position, np.zeros(3))
    for k in range(200):
        hauled = -0.0025 * np.array([k, k + 1])
        plant.advance(tick, still, still, hauled[0], -0.05, hauled[1], -0.05)
    assert not plant.touchdown
    assert plant.height_above_seabed(plant.unit_position) == pytest.approx(0.3, abs=0.05)


def test_a_deck_that_is_not_level_is_refused():
    with pytest.raises(ValueError, match="level"):
        SeabedParameters(depth=20.0, deck=True, slope=(0.1, 0.0))
