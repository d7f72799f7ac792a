"""What parts of a lift can carry: factors by their definition, and which strengths are stated."""

import math

import pytest
from heave_node.loads.strength import ATTACHMENT, ROPE, SAFETY_FACTOR, WINCH_PULL, safety_factor, strengths


def test_the_default_factor_is_the_product_of_its_source_and_above_the_least_of_it():
    """GL Noble Denton 0027/ND rev. 11.2: 1.3 x 1.3 x 1.5, and 2.3 at least."""
    assert pytest.approx(1.3 * 1.3 * 1.5) == SAFETY_FACTOR
    assert SAFETY_FACTOR > 2.3


def test_only_what_is_stated_has_a_factor():
    assert strengths({}, {}) == ()
    assert (
        strengths({"cable.breaking_force": 0.0, "unit.attachment_breaking_force": math.nan}, {"rated_pull": "x"}) == ()
    )
    plant = {"cable.breaking_force": 494e3, "cable.safety_factor": 3.0, "unit.attachment_breaking_force": 6e5}
    found = {one.key: (one.capacity, one.required) for one in strengths(plant, {"rated_pull": 2e5})}
    assert found == {ROPE: (494e3, 3.0), WINCH_PULL: (2e5, 1.0), ATTACHMENT: (6e5, SAFETY_FACTOR)}


@pytest.mark.parametrize(
    ("load", "state"), [(530e3, "FAILED"), (494e3, "FAILED"), (200e3, "FAILED"), (190e3, "met"), (0.0, "met")]
)
def test_a_part_fails_below_what_is_required(load, state):
    (rope,) = strengths({"cable.breaking_force": 494e3}, {})
    check = rope.under(load)
    assert check.state == state
    assert check.to_json()["factor"] == check.factor
    assert check.factor == (pytest.approx(494e3 / load) if load else math.inf)


def test_an_unknown_load_leaves_an_unknown_factor():
    assert math.isnan(safety_factor(494e3, math.nan))
    (rope,) = strengths({"cable.breaking_force": 494e3}, {})
    assert (rope.under(math.nan).is_overloaded, rope.under(math.nan).is_short) == (False, False)
