"""A study file says which cases there are; what is wrong with it is one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from heave_bringup.scenarios import load_scenario
from heave_node.parameters import ParameterError
from heave_studies.study.sampling import Draws
from heave_studies.study.study_file import read_study
from scipy.stats import qmc

PLACE = "cable_sim.cable.axial_stiffness"


def study_of(tmp_path: Path, text: str):
    path = tmp_path / "own.yaml"
    path.write_text(f"scenario: b2_calm_300\n{text}")
    return read_study(path)


def test_off_is_a_law_and_not_a_truth_value(tmp_path):
    cases = list(study_of(tmp_path, "vary: {winch_controller.law: [off, mpc]}\n").cases())
    assert [case.settings["winch_controller.law"] for case in cases] == ["off", "mpc"]
    assert cases[0].label == "seed=1 law=off"
    drawn = study_of(tmp_path, "draw: {count: 9, choose: {winch_controller.law: [off, lqg]}}\n")
    assert {case.settings["winch_controller.law"] for case in drawn.cases()} == {"off", "lqg"}
    words = study_of(tmp_path, "set: {cable_sim.sensors.imu.fitted: true}\n")
    assert words.common == {"cable_sim.sensors.imu.fitted": True}


def test_parameters_of_one_entry_move_together_and_entries_are_combined(tmp_path):
    text = """
vary:
  - {system.sea.peak_period: [8, 10], system.sea.significant_wave_height: [1, 2]}
  - {"virtual_winch.command_delay, winch_controller.winch.command_delay": [0.2, 0.3, 0.4]}
"""
    study = study_of(tmp_path, text)
    cases = list(study.cases())
    assert len(cases) == 2 * 3
    seas = {
        (case.settings["system.sea.peak_period"], case.settings["system.sea.significant_wave_height"]) for case in cases
    }
    assert seas == {(8, 1), (10, 2)}
    for case in cases:
        parameters = load_scenario("b2_calm_300", settings=study.settings_of(case)).parameters
        assumed = parameters["winch_controller"].winch.command_delay
        assert parameters["virtual_winch"].command_delay == assumed == case.settings["virtual_winch.command_delay"]


def test_a_mapping_of_parameters_is_a_plain_product_as_ever(tmp_path):
    text = "vary: {system.sea.peak_period: [8, 10], system.sea.significant_wave_height: [1, 2]}\n"
    assert len(list(study_of(tmp_path, text).cases())) == 4


def test_draws_are_linked_too(tmp_path):
    text = "draw: {count: 5, uniform: {'virtual_winch.command_delay, winch_controller.winch.command_delay': [0, 0.4]}}"
    for case in study_of(tmp_path, text).cases():
        assert len(case.settings) == 2
        assert len(set(case.settings.values())) == 1


@pytest.mark.parametrize("method", ["random", "latin", "sobol"])
def test_draws_are_fixed_by_their_seed_and_keep_their_bounds(method):
    draws = Draws(32, 3, method, uniform={"a.x": (2.0, 3.0)}, log_uniform={"a.y": (1e2, 1e4)})
    values = draws.values()
    assert values == Draws(32, 3, method, uniform={"a.x": (2.0, 3.0)}, log_uniform={"a.y": (1e2, 1e4)}).values()
    assert values != Draws(32, 4, method, uniform={"a.x": (2.0, 3.0)}, log_uniform={"a.y": (1e2, 1e4)}).values()
    assert all(2.0 <= one["a.x"] <= 3.0 and 1e2 <= one["a.y"] <= 1e4 for one in values)


def test_a_latin_hypercube_has_one_draw_in_each_slice_and_sobol_is_more_even_than_chance():
    def unit_cube(method):
        draws = Draws(64, 1, method, uniform=dict.fromkeys(("a.x", "a.y", "a.z"), (0.0, 1.0)))
        return np.array([list(one.values()) for one in draws.values()])

    slices = np.sort((unit_cube("latin") * 64).astype(int), axis=0)  # the definition of a Latin hypercube
    np.testing.assert_array_equal(slices, np.arange(64)[:, None] * np.ones((1, 3), dtype=int))
    assert qmc.discrepancy(unit_cube("sobol")) < 0.5 * qmc.discrepancy(unit_cube("random"))


def test_fewer_draws_are_the_first_of_all_of_them(tmp_path):
    for method in ("random", "latin", "sobol"):
        text = f"draw: {{count: 10, method: {method}, uniform: {{{PLACE}: [1e7, 2e7]}}}}\n"
        study = study_of(tmp_path, text)
        everything = list(study.cases())
        assert list(study.shortened(duration=None, draws=3).cases()) == everything[:3]


def test_criteria_are_those_of_every_case(tmp_path):
    study = study_of(tmp_path, 'wanted: {unit_sigma_m: "<= 0.125", snaps: "<= 0"}\nseeds: 2\n')
    for case in study.cases():
        wanted = load_scenario("b2_calm_300", settings=study.settings_of(case)).wanted
        assert {"unit_sigma_m <= 0.125", "snaps <= 0.0", "outlet_efficiency >= 0.95"} <= {
            f"{criterion.kpi} {criterion.text}" for criterion in wanted
        }


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("seeds: 0", "seeds must be a number of at least 1"),
        ("seeds: two", "seeds = 'two': must be a number of seeds or a list"),
        ("vary: 3", "vary: must be a mapping of parameters to lists"),
        ("vary: [3]", "vary: must be a mapping of parameters to lists"),
        ("vary: {system.sea.peak_period: 8}", "vary: system.sea.peak_period = 8: must be a list"),
        ("vary: {system.sea.peak_period: []}", "must be a list of at least one value"),
        ("vary: [{a.x: [1, 2], a.y: [1]}]", "need equally many values: a.x 2, a.y 1"),
        ("draw: {count: 3}", "draw: has nothing to draw"),
        ("draw: {count: 0, uniform: {a.x: [1, 2]}}", "draw.count = 0: must be at least 1"),
        ("draw: {count: 3, method: dice, uniform: {a.x: [1, 2]}}", "draw.method = dice: must be one of random, latin"),
        ("draw: {count: 3, uniform: {a.x: [2, 1]}}", "a.x = [2, 1]: must be a smallest and a largest"),
        ("draw: {count: 3, uniform: {a.x: 2}}", "draw.uniform: a.x = 2: must be [smallest, largest]"),
        ("draw: {count: 3, log_uniform: {a.x: [0, 1]}}", "must be a smallest above 0 and a largest"),
        ("draw: {count: 3, uniform: {a.x: [1, 2]}, choose: {a.x: [1]}}", "a.x is drawn twice"),
        ("draw: {cuont: 3}", "unknown key cuont"),
        ("draw: 4", "draw: must be a mapping, not 4"),
        ("wanted: 0.3", "wanted: must be a mapping"),
        ("search: {runs: 3}", "search: figure is missing"),
        ("search: {figure: silent_minute}", "search: needs a draw"),
        ("ask: {answer: limts}\nx: 1", "unknown key x"),
    ],
)
def test_what_is_wrong_with_a_file_is_one_line_with_its_name(tmp_path, text, words):
    with pytest.raises(ParameterError) as error:
        study_of(tmp_path, text)
    assert str(error.value).startswith(f"{tmp_path / 'own.yaml'}: ")
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_a_scenario_that_is_none_is_named_with_file_and_key(tmp_path):
    (path := tmp_path / "own.yaml").write_text("scenario: my_lift\n")
    with pytest.raises(ParameterError, match=rf"^{path}: scenario: my_lift: no such scenario"):
        read_study(path)
