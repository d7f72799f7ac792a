"""Scenario files."""

import pytest
from heave_node.parameters import ParameterError
from heave_node.scenario import parse_yaml, read_scenario, values_of_node, write_scenario


def test_a_scenario_survives_writing_and_reading(tmp_path):
    values = {"/**": {"seed": 3}, "cable_sim": {"length": 300.0, "unit.mass": 10.0, "current": (0.5, 0.0)}}
    path = tmp_path / "s.yaml"
    write_scenario(values, path)
    assert read_scenario(path) == {**values, "cable_sim": {**values["cable_sim"], "current": [0.5, 0.0]}}


def test_nested_names_are_flattened_and_a_node_overrides_the_common_values(tmp_path):
    path = tmp_path / "s.yaml"
    path.write_text("/**: {ros__parameters: {seed: 1}}\n/sea: {ros__parameters: {seed: 2, mru: {rate: 20.0}}}\n")
    assert values_of_node(read_scenario(path), "sea") == {"seed": 2, "mru.rate": 20.0}
    assert values_of_node(read_scenario(path), "other") == {"seed": 1}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a: [1", "is not YAML"),
        ("just words", "must be a mapping of node names"),
        ("cable_sim: {length: 3}", "cable_sim: must hold ros__parameters and nothing else"),
        ("cable_sim: {ros__parameters: 3}", "must be a mapping"),
        ("\xff\xfe", "is not YAML"),
    ],
)
def test_a_file_of_another_form_is_refused_in_one_line(tmp_path, text, words):
    path = tmp_path / "s.yaml"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(ParameterError) as refusal:
        read_scenario(path)
    assert str(path) in str(refusal.value)
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ParameterError, match=r"nowhere\.yaml: cannot be read: No such file"):
        read_scenario(tmp_path / "nowhere.yaml")


@pytest.mark.parametrize(("text", "value"), [("1e-5", 1e-5), ("-2E3", -2e3), ("1.5e+2", 150.0), ("1e", "1e"), ("7", 7)])
def test_numbers_with_an_exponent_are_numbers_as_for_ros(text: str, value: object) -> None:
    assert parse_yaml(text) == value
    assert type(parse_yaml(text)) is type(value)
