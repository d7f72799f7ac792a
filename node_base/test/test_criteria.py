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


@pytest.mark.parametrize("value", ["0.005", "=< 1", "== 1", "<= one", "<= nan", "<= 1 2", "", 0.005, None, ["<= 1"]])
def test_anything_else_is_refused_in_one_line_with_an_example(value):
    with pytest.raises(ParameterError) as refusal:
        parse(value)
    assert str(refusal.value).startswith(f"own.yaml: /**: wanted.unit_sigma_m = {value!r} is not allowed: it must be")
    assert '"<= 0.005"' in str(refusal.value)


@pytest.mark.parametrize(
    ("key", "text", "criterion"),
    [
        ("significant_residual_m", "<= 5 cm", ("significant_residual_m", 0.05)),
        ("significant_residual", "<= 57cm", ("significant_residual_m", 0.57)),
        ("tension_max_n", "<= 400 kN", ("tension_max_n", 400e3)),
        ("tension_max", "<= 10 t", ("tension_max_n", 98066.5)),  # standard gravity, 9.80665 m/s^2
        ("winch_speed_max", "<= 30 m/min", ("winch_speed_max_mps", 0.5)),
        ("winch_acceleration_max", "<= 1.5 m/s²", ("winch_acceleration_max_mps2", 1.5)),
        ("winch_acceleration_max", "<= 1.5 m/s2", ("winch_acceleration_max_mps2", 1.5)),
        ("power_peak", "<= .9 MW", ("power_peak_w", 900e3)),
        ("loop_age_p99_s", "<= 20 ms", ("loop_age_p99_s", 0.02)),
        ("slack_percent", "<= 2 %", ("slack_percent", 2.0)),
        ("unit_efficiency", "<= 90 %", ("unit_efficiency", 0.9)),
        ("unit_heave_phase", "<= 5 deg", ("unit_heave_phase_deg", 5.0)),
        ("energy", "<= 5 kWh/h", ("energy_wh_per_h", 5e3)),
        ("reversals_per_h", "<= 10 1/h", ("reversals_per_h", 10.0)),
    ],
)
def test_a_bound_may_have_a_unit_and_then_the_key_need_not(key, text, criterion):
    assert parse(text, key) == Criterion(criterion[0], "<=", criterion[1])


@pytest.mark.parametrize(
    ("key", "text", "words"),
    [
        ("significant_residual_m", "<= 5 kN", "kN is no unit of significant_residual_m; use m, dm, cm, mm, ft"),
        ("slack_percent", "<= 5 s", "s is no unit of slack_percent; use %"),
        ("significant_residual", "<= 5 furlong", "furlong is no unit of significant_residual; use m, cm"),
    ],
)
def test_a_unit_of_another_dimension_is_refused_with_those_that_the_figure_takes(key, text, words):
    with pytest.raises(ParameterError, match=words) as refusal:
        parse(text, key)
    assert str(refusal.value).startswith(f"own.yaml: /**: wanted.{key} = {text!r}: ")
    assert "\n" not in str(refusal.value)


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
