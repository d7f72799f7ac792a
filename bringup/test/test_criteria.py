"""Criteria of the command line and of a scenario are checked before a run begins."""

import pytest
from heave_bags.analyse.kpi_set import DEFINITION_OF
from heave_bringup.cli import main
from heave_bringup.run.criteria import parse_requirement
from heave_node.criteria import UNITS_OF_KEYS, end_of
from heave_node.parameters import ParameterError


@pytest.mark.parametrize("text", ["unit_sigma_m<0.01", "unit_sigma_m <= 0.01", " kappa>1e-3"])
def test_a_requirement_is_a_figure_a_relation_and_a_number(text):
    assert f"{parse_requirement(text).kpi}" in text


def test_a_requirement_in_another_unit_is_that_in_the_unit_of_the_key():
    assert parse_requirement("significant_residual<5cm") == parse_requirement("significant_residual_m<0.05")


def test_a_ratio_takes_no_unit_but_percent():
    assert parse_requirement("unit_efficiency>90%") == parse_requirement("unit_efficiency>0.9")
    with pytest.raises(ParameterError, match="kappa is a ratio or a count, its bound takes no unit but %"):
        parse_requirement("kappa<2m")


def test_every_figure_of_merit_ends_in_a_unit_that_its_bounds_take():
    for key, definition in DEFINITION_OF.items():
        unit = definition.unit.replace("²", "^2")
        assert unit in ("", *UNITS_OF_KEYS[end_of(key)])
        if unit:  # one of the shown unit is 1/scale of the key's
            assert UNITS_OF_KEYS[end_of(key)][unit] * definition.scale == pytest.approx(1.0)


@pytest.mark.parametrize("text", ["unit_sigma_m", "unit_sigma_m=3", "unit_sigma_m<big", "no_such_figure<1", "<1"])
def test_another_requirement_is_refused_with_the_option(text):
    with pytest.raises(ParameterError, match="--require"):
        parse_requirement(text)


@pytest.mark.parametrize(
    "text", ["significant_residual<-5cm", "snaps<0", "slack_percent>100", "unit_efficiency>=101%", "kappa<=-1e-9"]
)
def test_a_bound_that_no_run_meets_is_refused(text):
    with pytest.raises(ParameterError, match="cannot be met: the best possible"):
        parse_requirement(text)


@pytest.mark.parametrize(
    "text",
    ["snaps<=0", "time_at_limit_percent<=0", "unit_efficiency>=100%", "tension_min<-1kN", "unit_heave_phase<0deg"],
)
def test_a_bound_that_some_run_meets_is_taken(text):
    parse_requirement(text)


def test_a_wrong_requirement_is_refused_before_anything_starts(capsys):
    assert main(["run", "b2_calm_300", "--require", "no_such_figure<1"]) == 2
    assert "no_such_figure is not a figure of merit; known: unit_sigma_m" in capsys.readouterr().err


def test_a_bound_in_the_unit_of_another_quantity_is_answered_with_those_that_fit():
    with pytest.raises(ParameterError, match=r"significant_residual: the bound has .*; it takes m, dm, cm, mm, ft"):
        parse_requirement("significant_residual<5kN")


def test_a_figure_that_is_nearly_one_is_answered_with_those_that_are_meant():
    with pytest.raises(ParameterError, match="not a figure of merit; did you mean unit_sigma_m"):
        parse_requirement("unit_sigma<0.01")


def test_a_scenario_that_wants_no_figure_of_merit_is_refused_before_anything_starts(tmp_path, capsys):
    scenario = tmp_path / "own.yaml"
    scenario.write_text("/**: {ros__parameters: {wanted: {no_such_figure: '< 1'}}}\n")
    assert main(["run", str(scenario)]) == 2
    assert f"{scenario}: wanted: no_such_figure is not a figure of merit" in capsys.readouterr().err
