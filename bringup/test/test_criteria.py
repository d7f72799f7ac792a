"""Criteria of the command line and of a scenario are checked before a run begins."""

import pytest
from heave_bringup.cli import main
from heave_bringup.run.criteria import parse_requirement
from heave_node.parameters import ParameterError


@pytest.mark.parametrize("text", ["unit_sigma_m<0.01", "unit_sigma_m <= 0.01", " kappa>1e-3"])
def test_a_requirement_is_a_figure_a_relation_and_a_number(text):
    assert f"{parse_requirement(text).kpi}" in text


@pytest.mark.parametrize("text", ["unit_sigma_m", "unit_sigma_m=3", "unit_sigma_m<big", "no_such_figure<1", "<1"])
def test_another_requirement_is_refused_with_the_option(text):
    with pytest.raises(ParameterError, match="--require"):
        parse_requirement(text)


def test_a_wrong_requirement_is_refused_before_anything_starts(capsys):
    assert main(["run", "b2_calm_300", "--require", "no_such_figure<1"]) == 2
    assert "no_such_figure is not a figure of merit; known: unit_sigma_m" in capsys.readouterr().err


def test_a_figure_that_is_nearly_one_is_answered_with_those_that_are_meant():
    with pytest.raises(ParameterError, match="not a figure of merit; did you mean unit_sigma_m"):
        parse_requirement("unit_sigma<0.01")


def test_a_scenario_that_wants_no_figure_of_merit_is_refused_before_anything_starts(tmp_path, capsys):
    scenario = tmp_path / "own.yaml"
    scenario.write_text("/**: {ros__parameters: {wanted: {no_such_figure: '< 1'}}}\n")
    assert main(["run", str(scenario)]) == 2
    assert f"{scenario}: wanted: no_such_figure is not a figure of merit" in capsys.readouterr().err
