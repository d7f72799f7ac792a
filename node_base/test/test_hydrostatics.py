import math

import pytest
from heave_node.numerics.hydrostatics import displaced_area, weight_in_fluid
from hypothesis import given
from hypothesis import strategies as st


def test_a_body_of_waters_own_density_weighs_nothing_in_water():
    assert weight_in_fluid(1025.0, 1.0) == 0.0


def test_the_300_m_cable_weighs_what_the_peer_says():
    # MoorDyn's figure for 5.4 kg/m and 47 mm in sea water of 1025 kg/m3
    assert weight_in_fluid(5.4, displaced_area(0.047)) == pytest.approx(35.517, abs=5e-4)


def test_the_900_m_cable_weighs_what_the_thesis_says():
    # thesis 6.2.6: 54 N/m with 7.2 kg/m; the displaced diameter is the one that gives it
    assert weight_in_fluid(7.2, displaced_area(0.047, 0.045868)) == pytest.approx(54.0, abs=5e-3)


@given(st.floats(0.0, 1e6), st.floats(0.0, 1e3), st.floats(0.0, 2000.0), st.floats(0.0, 100.0))
def test_weight_is_the_difference_of_the_two_forces(mass, volume, density, gravity):
    # Archimedes: the buoyancy is the weight of the displaced fluid
    forces = mass * gravity - density * volume * gravity
    scale = mass * gravity + density * volume * gravity
    assert weight_in_fluid(mass, volume, density, gravity) == pytest.approx(forces, abs=1e-12 * (1.0 + scale))


@given(st.floats(1e-4, 2.0))
def test_without_a_displaced_diameter_the_outer_one_counts(diameter):
    assert displaced_area(diameter) == displaced_area(diameter, diameter) == pytest.approx(math.pi * diameter**2 / 4.0)
