"""YAML of anybody's is plain values of bounded size and depth, read as ROS 2 reads parameters."""

from __future__ import annotations

import math

import pytest
from heave_node.files.bounded_yaml import DEEPEST_YAML, LARGEST_YAML, MOST_VALUES, YamlError, parse_yaml
from heave_node.parameters import ParameterError
from heave_node.scenario import parse_sections

LAUGHS = "a: &a [x, x]\n" + "".join(f"{b}: &{b} [*{a}, *{a}]\n" for a, b in zip("abcdefgh", "bcdefghi", strict=True))
HOSTILE = [
    ("[" * 40 + "]" * 40, "levels deep"),
    ("[" * 100_000, "depth|deep"),
    ("a: &a 1\nb: *a", "aliases"),
    (LAUGHS, "aliases"),
    ("a: &a [*a]", "aliases"),
    ("a: [", "not valid YAML"),
    ("!!python/object/apply:os.getcwd []", "tag"),
    ("!!binary aGVhdmU=", "tag"),
    ("!!timestamp 2001-01-01", "tag"),
    ("!own {a: 1}", "tag"),
    ("%TAG ! tag:own.org,2000:\n--- !x 1", "tag"),
    ("!!map [1]", "tagged as a mapping"),
    ("!!int many", "not valid YAML"),
    ("!!bool maybe", "not valid YAML"),
    ("9" * 5000, "too long"),
    ("9" * 399, "too large"),
    ("1e400", "too large"),
    ("-" + "9" * 500 + ".5", "too long"),
    ("0x" + "f" * 300, "too large"),
    ("{[a]: 1}", "no text"),
    ("{" + "k" * 300 + ": 1}", "name"),
    ('{"a\\nb": 1}', "name"),
    ("{a: 1, a: 2}", "appears twice"),
    ("--- 1\n--- 2", "not valid YAML"),
    ("a: \x00", "not valid YAML"),
    ("a: \x1b[2J", "not valid YAML"),
    ("'\ud800'", "not valid YAML"),
    (b"a: \xff", "not text in UTF-8"),
    ("x" * (LARGEST_YAML + 1), "characters"),
    ("[" + "1," * MOST_VALUES + "]", "values"),
]


@pytest.mark.parametrize(("text", "complaint"), HOSTILE, ids=range(len(HOSTILE)))
def test_what_expands_nests_or_makes_objects_is_refused_in_one_line(text, complaint):
    with pytest.raises(YamlError, match=complaint) as told:
        parse_yaml(text)
    assert "\n" not in str(told.value)
    assert len(str(told.value)) < 700
    if isinstance(text, str) and not any("\ud800" <= letter <= "\udfff" for letter in text):
        with pytest.raises(ParameterError):
            parse_sections(text.encode(), "own.yaml")


def test_yaml_within_the_bounds_is_read():
    deep = "[" * DEEPEST_YAML + "]" * DEEPEST_YAML
    assert str(parse_yaml(deep)) == deep
    assert parse_yaml("a: {b: [1, 2.5, text, ~, true]}\n") == {"a": {"b": [1, 2.5, "text", None, True]}}
    assert parse_yaml("") is None
    assert parse_yaml(b"a: \xc3\xa9") == {"a": "\u00e9"}
    assert parse_yaml("!!str 5") == "5"


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-5", 1e-5),
        ("-2E3", -2e3),
        ("1.5e+2", 150.0),
        ("1e", "1e"),
        ("7", 7),
        ("0", 0),
        ("-12", -12),
        ("010", 8),  # C's strtol with base 0, which ROS 2 reads numbers with
        ("0x1F", 31),
        (".5", 0.5),
        ("5.", 5.0),
        (".inf", math.inf),
        ("-.inf", -math.inf),
        ("9223372036854775807", 2**63 - 1),
        ("9223372036854775808", 2.0**63),  # beyond 64 bits ROS 2 reads a double
        ("1:30:00", "1:30:00"),  # no number to the base 60
        ("190:20:30.15", "190:20:30.15"),
        ("1996-06-14", "1996-06-14"),
        ("1996-06-14T18:00:00", "1996-06-14T18:00:00"),
        ("=", "="),
        ("<<", "<<"),
    ],
)
def test_numbers_are_what_ros_takes_for_numbers(text: str, value: object) -> None:
    assert parse_yaml(text) == value
    assert type(parse_yaml(text)) is type(value)


def test_a_key_is_a_text_as_for_ros() -> None:
    assert parse_yaml("{on: 1, 2: 3, <<: {a: 4}}") == {"on": 1, "2": 3, "<<": {"a": 4}}


def test_words_for_truth_are_words_where_only_true_and_false_are_truth() -> None:
    assert parse_yaml("[on, off, true]") == [True, False, True]
    assert parse_yaml("[on, off, true]", only_true_and_false=True) == ["on", "off", True]
