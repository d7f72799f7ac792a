"""Scenario files: read as ROS 2 reads them, matched to nodes, and written."""

import string
from pathlib import Path

import pytest
from heave_node.parameters import ParameterError
from heave_node.scenario import (
    flatten_names,
    holds_for,
    nest_names,
    read_sections,
    sections_of_node,
    values_of_node,
    write_sections,
)
from hypothesis import given
from hypothesis import strategies as st

NAME = st.text(string.ascii_lowercase, min_size=1, max_size=4)
VALUE = st.one_of(
    st.booleans(),
    st.integers(-(2**31), 2**31),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs")), max_size=8),
    st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=3),
)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "s.yaml"


def test_sections_survive_writing_and_reading(path):
    sections = {
        "/**": {"seed": 3, "wanted.unit_sigma_m": "<= 0.005"},
        "/**/cable_sim": {"length": 300.0, "unit.mass": 10.0, "current": (0.5, 0.0)},
    }
    write_sections(sections, path, title="One line\nand another")
    assert path.read_text().startswith("# One line\n# and another\n")
    assert read_sections(path) == {**sections, "/**/cable_sim": {**sections["/**/cable_sim"], "current": [0.5, 0.0]}}


@given(st.dictionaries(NAME, VALUE, min_size=1, max_size=5))
def test_every_value_survives_writing_and_reading(tmp_path_factory, values):
    path = tmp_path_factory.mktemp("any") / "s.yaml"
    write_sections({"/**": values}, path)
    read = read_sections(path)["/**"]
    assert read == values
    assert [type(value) for value in read.values()] == [type(value) for value in values.values()]


@pytest.mark.parametrize("names", [("a", "a.b", "a.b.c", "d.e"), ("d.e", "a.b.c", "a.b", "a")])
def test_a_name_may_have_a_value_and_names_below_it(path, names):
    values = {f"system.{name}": number for number, name in enumerate(names)}
    write_sections({"/**": values}, path)
    assert read_sections(path) == {"/**": values}


def test_an_empty_list_is_left_out_since_ros_cannot_read_one(path):
    write_sections({"/**": {"seed": 1, "external": (), "start": []}}, path)
    assert read_sections(path) == {"/**": {"seed": 1}}


@given(st.dictionaries(NAME.map(lambda name: f"group.{name}"), st.integers(), min_size=1))
def test_nesting_is_the_inverse_of_flattening(values):
    assert flatten_names(nest_names(values), "") == values


def test_sections_are_named_as_ros_names_them(path):
    path.write_text(
        "/**: {ros__parameters: {seed: 1}}\nsea: {ros__parameters: {mru: {rate: 20.0}}}\n"
        "ship: {sea: {ros__parameters: {seed: 2}}}\n"
    )
    assert read_sections(path) == {"/**": {"seed": 1}, "/sea": {"mru.rate": 20.0}, "/ship/sea": {"seed": 2}}


@pytest.mark.parametrize(
    ("section", "node", "holds"),
    [
        ("/**", "/a/cable_sim", True),
        ("/**/cable_sim", "/cable_sim", True),
        ("/**/cable_sim", "/a/b/cable_sim", True),
        ("/**/cable_sim", "/a/cable_sim2", False),
        ("/cable_sim", "/cable_sim", True),
        ("/cable_sim", "/a/cable_sim", False),
        ("/*/cable_sim", "/a/cable_sim", True),
        ("/*/cable_sim", "/cable_sim", False),
        ("/*/cable_sim", "/a/b/cable_sim", False),
        ("/a/**", "/a/b/cable_sim", True),
        ("/a/**", "/b/cable_sim", False),
    ],
)
def test_a_section_holds_for_the_nodes_that_ros_finds_it_to_hold_for(section, node, holds):
    assert holds_for(section, node) is holds


def test_the_later_section_that_holds_for_a_node_wins():
    sections = {"/**/sea": {"a": 1, "b": 1}, "/**": {"a": 0}, "/other": {"b": 2}}
    assert sections_of_node(sections, "/sea") == {"a": "/**", "b": "/**/sea"}


def test_what_a_file_says_of_a_node_is_by_the_node_s_own_names_whatever_the_form(path):
    path.write_text(
        "/**: {ros__parameters: {seed: 1, system: {winch: {speed_limit: 2.0, law: x}, vessel: {gain: 0.5}}}}\n"
        "/**/winch_controller: {ros__parameters: {winch: {law: y}}}\n"
        "virtual_winch: {ros__parameters: {encoder: {resolution: 0.0}}}\n"
    )
    sections = read_sections(path)
    assert values_of_node(sections, "/virtual_winch") == {
        "seed": 1,
        "speed_limit": 2.0,
        "law": "x",
        "encoder.resolution": 0.0,
    }
    assert values_of_node(sections, "/winch_controller") == {
        "seed": 1,
        "winch.speed_limit": 2.0,
        "winch.law": "y",
        "vessel.gain": 0.5,
    }
    assert values_of_node(sections, "/recorder") == {"seed": 1}


def test_ros_finds_the_same_sections_and_lets_the_later_one_win(path, monkeypatch):
    rclpy = pytest.importorskip("rclpy")
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    names = ["/**/cable_sim", "/**", "cable_sim", "/ship/cable_sim", "/*/cable_sim", "/other"]
    sections = {name: {"last": number, f"p{number}": number} for number, name in enumerate(names)}
    write_sections(sections, path)
    context = rclpy.Context()
    rclpy.init(args=["--ros-args", "--params-file", str(path)], context=context)
    try:
        for namespace in ("", "/ship", "/a/b"):
            node = rclpy.create_node(
                "cable_sim", namespace=namespace, context=context, automatically_declare_parameters_from_overrides=True
            )
            found = {
                name: node.get_parameter(name).value
                for name in ("last", *(f"p{n}" for n in range(len(names))))
                if node.has_parameter(name)
            }
            origins = sections_of_node(read_sections(path), node.get_fully_qualified_name())
            node.destroy_node()
            assert found.keys() == origins.keys()
            assert read_sections(path)[origins["last"]]["last"] == found["last"]
    finally:
        rclpy.shutdown(context=context)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a: [1", "line 1 is not valid YAML"),
        ("a: [1,2\n x", "line 2 is not valid YAML"),
        ("just words", "must be a mapping of node names"),
        ("length: 3", "length: must contain only ros__parameters; `heave new` writes a file of this form"),
        (
            "cable_sim: {ros__parameters: {length: 3}, length: 4}",
            "cable_sim: must contain only ros__parameters; indent length below it",
        ),
        ("a:\n  b:\n    c: 1\n   d: 2\n", "line 4 is not valid YAML: check its indentation"),
        ("a:\n\tb: 1\n", "line 2 is not valid YAML: indent with spaces, not tabs"),
        ("title: mine\nphases: []\n", "this is a lift plan; use heave study"),
        ("scenario: b2\ndraw: {}\n", "this is a study; use heave study"),
        ("steps: []\n", "this is a test procedure; use heave study"),
        ("source: {udp: 10111}\n", "this is the map of a device; use heave adapt"),
        ("cable_sim: {ros__parameters: 3}", "must be a mapping"),
        ("cable_sim: {ros__parameters: {}}", "cable_sim: has no parameters"),
        ("cable_sim: {ros__parameters: }", "cable_sim: has no parameters"),
        ("{}", "has no parameters"),
        ("a: {ros__parameters: {b: 1, b: 2}}", "b appears twice, again on line 1"),
        ("a: {ros__parameters: {b: 1}}\n/a: {ros__parameters: {b: 2}}", "b appears twice, in two sections"),
        ("\xff\xfe", "it is not text in UTF-8 (byte 0xff at 0); save it as UTF-8"),
        ("\n".join(f"n{n}: {{ros__parameters: {{a: 1}}}}" for n in range(501)), "has 501 sections, 500 are allowed"),
    ],
)
def test_a_file_of_another_form_is_refused_in_one_line(path, text, words):
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(ParameterError) as refusal:
        read_sections(path)
    assert str(path) in str(refusal.value)
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ParameterError, match=r"nowhere\.yaml: cannot be read: No such file"):
        read_sections(tmp_path / "nowhere.yaml")
