import math

import pytest
from cable_sim_node.physics.tension_law import strain_at, tangent_stiffness
from heave_node.catalogue import find
from hypothesis import given
from hypothesis import strategies as st

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
