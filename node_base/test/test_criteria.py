"""Criteria of a run: what is read, what is refused, when one is met."""

import math

import pytest
from heave_node.criteria import Criterion, parse_criterion
from heave_node.parameters import Given, ParameterError
from hypothesis import given
from hypothesis import strategies as st


def parse(value, kpi="unit_sigma_m"):
    return parse_criterion(Given(value, f"wanted.{kpi}", "own.yaml: /**"))


@pytest.mark.parametrize(
    ("text", "relation", "bound"),
    [
        ("<= 0.005", "<=", 0.005),
        (">=0.95", ">=", 0.95),
        ("< 1e-3", "<", 1e-3),
        (" > -2 ", ">", -2.0),
        ("<= .5", "<=", 0.5),
    ],
)
def test_a_relation_and_a_number_are_read(text, relation, bound):
    assert parse(text) == Criterion("unit_sigma_m", relation, bound)


@pytest.mark.parametrize("value", ["0.005", "=< 1", "== 1", "<= one", "<= nan", "<= 1 cm", "", 0.005, None, ["<= 1"]])
def test_anything_else_is_refused_in_one_line_with_an_example(value):
    with pytest.raises(ParameterError) as refusal:
        parse(value)
    assert str(refusal.value).startswith(f"own.yaml: /**: wanted.unit_sigma_m = {value!r} is not allowed: it must be")
    assert '"<= 0.005"' in str(refusal.value)


@pytest.mark.parametrize("kpi", ["", "Unit", "unit.sigma", "1st"])
def test_a_name_that_no_figure_can_have_is_refused(kpi):
    with pytest.raises(ParameterError):
        parse("<= 1", kpi)


@given(st.sampled_from(["<=", ">=", "<", ">"]), st.floats(allow_nan=False, allow_infinity=False), st.floats())
def test_a_criterion_survives_its_text_and_is_met_as_the_relation_says(relation, bound, value):
    criterion = Criterion("kappa", relation, bound)
    assert parse(criterion.text, "kappa") == criterion
    expected = {"<=": value <= bound, ">=": value >= bound, "<": value < bound, ">": value > bound}[relation]
    assert criterion.is_met(value) is expected


def test_a_figure_that_could_not_be_computed_meets_nothing():
    assert not any(Criterion("kappa", relation, 0.0).is_met(math.nan) for relation in ("<=", ">=", "<", ">"))
