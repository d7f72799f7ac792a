import dataclasses
import math

import pytest
from cable_sim_node.parameters import CableSimParameters, ClumpsParameters, SectionsParameters, UnitParameters
from cable_sim_node.physics.properties import body_properties, cable_sections, unit_properties
from cable_sim_node.physics.tension_law import strain_at, tangent_stiffness
from heave_node.catalogue import find
from hypothesis import given
from hypothesis import strategies as st

RICH = CableSimParameters(
    sections=SectionsParameters((60.0, 40.0), (0.06, 0.05), (0.0, 0.04), (9.0, 8.0), (8e6, 9e6)),
    clumps=ClumpsParameters((150.0,), (800.0,), (0.2,), (100.0,), (0.5,)),
    unit=UnitParameters(thrust=(10.0, -20.0, 30.0)),
)


def test_sections_are_counted_from_the_unit_and_the_main_cable_goes_on():
    sections = cable_sections(RICH)
    assert [(section.start, section.length) for section in sections] == [(0.0, 60.0), (60.0, 40.0), (100.0, math.inf)]
    assert [section.cable.axial_stiffness for section in sections] == [8e6, 9e6, RICH.cable.axial_stiffness]


def test_a_sections_water_is_that_of_its_displaced_diameter_and_its_drag_that_of_the_outer_one():
    cable = cable_sections(RICH)[1].cable
    displaced = 1025.0 * math.pi * 0.02**2
    assert cable.displaced_mass == pytest.approx(displaced)
    assert cable.weight == pytest.approx((8.0 - displaced) * 9.80665)
    assert cable.added_mass == pytest.approx(RICH.cable.added_mass * displaced)
    assert cable.normal_drag == pytest.approx(0.5 * 1025.0 * 1.2 * 0.05)  # thesis Eq. 2.46
    assert cable.tangential_drag == pytest.approx(0.5 * math.pi * 1025.0 * 0.01 * 0.05)  # thesis Eq. 2.47


def test_the_units_force_is_thrust_less_weight_in_water():
    unit = unit_properties(RICH)
    assert unit.force == pytest.approx([10.0, -20.0, 30.0 - (3000.0 - 1025.0 * 0.354) * 9.80665])
    assert unit.inertia == pytest.approx([6000.0] * 3)
    assert unit.fluid == pytest.approx([1025.0 * 0.354 + 3000.0] * 3)
    assert unit.drag == pytest.approx([0.5 * 1025.0 * 1.5 * 0.5] * 3)


def test_a_body_weighs_less_by_the_water_it_displaces():
    (body,) = body_properties(RICH)
    assert (body.label, body.mass, body.added_mass) == (150.0, 800.0, 100.0)
    assert body.weight == pytest.approx((800.0 - 205.0) * 9.80665)
    assert body.drag == pytest.approx(0.5 * 1025.0 * 0.5)


def test_in_a_vacuum_nothing_is_buoyant_dragged_or_has_added_mass():
    dry = dataclasses.replace(RICH, water_density=0.0)
    (body,) = body_properties(dry)
    cable, unit = cable_sections(dry)[-1].cable, unit_properties(dry)
    assert (cable.added_mass, cable.displaced_mass, cable.normal_drag, cable.tangential_drag) == (0.0, 0.0, 0.0, 0.0)
    assert (body.added_mass, body.displaced_mass, body.drag) == (0.0, 0.0, 0.0)
    assert unit.inertia == pytest.approx([3000.0] * 3)
    assert not unit.drag.any()
    assert not unit.fluid.any()


# the law of tension over strain


STIFFNESS = st.floats(1e3, 1e9)
COEFFICIENT = st.floats(0.0, 1e3)
STRAIN = st.floats(1e-6, 0.05)


def tension(stiffness, quadratic, cubic, strain):
    return stiffness * (strain + quadratic * strain**2 + cubic * strain**3)


@given(STIFFNESS, COEFFICIENT, COEFFICIENT, STRAIN)
def test_the_strain_at_a_tension_is_the_one_that_gives_it(stiffness, quadratic, cubic, strain):
    law = (stiffness, quadratic, cubic)
    assert strain_at(*law, tension(*law, strain)) == pytest.approx(strain, rel=1e-12)


@given(STIFFNESS, COEFFICIENT, COEFFICIENT, STRAIN)
def test_the_tangent_stiffness_is_the_laws_slope(stiffness, quadratic, cubic, strain):
    law, step = (stiffness, quadratic, cubic), 1e-4 * strain
    slope = (tension(*law, strain + step) - tension(*law, strain - step)) / (2.0 * step)
    assert tangent_stiffness(*law, strain) == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize("load", [0.05, 0.1, 0.2, 0.3])
def test_the_fibre_rope_of_the_catalogue_is_as_stiff_as_its_source_says_at_every_load(load):
    """NREL's fit: K = (59 + 0.54 x load in %) times the breaking force; its strain is ln(1 + B T/A)/B."""
    rope = find("cable", "hmpe_40mm_by_load")
    law = tuple(rope.values[name] for name in ("axial_stiffness", "stiffness_quadratic", "stiffness_cubic"))
    strain = strain_at(*law, load * rope.breaking_force)
    assert tangent_stiffness(*law, strain) == pytest.approx((59.0 + 54.0 * load) * rope.breaking_force, rel=2e-3)
    assert strain == pytest.approx(math.log(1.0 + 54.0 * load / 59.0) / 54.0, rel=1e-3)


def test_a_tension_that_a_yielding_law_does_not_reach_has_no_strain():
    # T = EA (e - 10 e^2) is EA/40 at most, at e = 0.05
    assert math.isnan(strain_at(1e6, -10.0, 0.0, 1e6 / 39.0))
