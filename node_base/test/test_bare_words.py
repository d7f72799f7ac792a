"""Words that are not in quotes: read as ROS 2 reads them, and known again where one of them is meant."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from heave_node.bare_words import read_bare, word_meant
from heave_node.scenario import write_sections
from hypothesis import given, settings
from hypothesis import strategies as st

READ_AS_ANOTHER = ["nan", "NaN", ".inf", "infinity", "y", "N", "on", "off", "yes", "No", "TRUE", "1e3", "0x10", "7"]
WORDS = ["freeze", "mpc", "null", "~", "1e", "speed_servo"]


def read_by_ros(path: Path) -> dict[str, object]:
    """Return what ROS 2 reads from the parameter file at `path`, for any node."""
    rclpy = pytest.importorskip("rclpy")
    context = rclpy.Context()
    rclpy.init(args=["--ros-args", "--params-file", str(path)], context=context)
    try:
        node = rclpy.create_node("any", context=context, automatically_declare_parameters_from_overrides=True)
        values = {name: of.value for name, of in node.get_parameters_by_prefix("a").items()}
        node.destroy_node()
    finally:
        rclpy.shutdown(context=context)
    return values


@pytest.fixture(autouse=True)
def stay_on_this_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")


def test_a_bare_word_is_read_as_ros_reads_it(tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    lines = "".join(f"    a{number}: {word}\n" for number, word in enumerate([*READ_AS_ANOTHER, *WORDS]))
    path.write_text(f"/**:\n  ros__parameters:\n   a:\n{lines}")
    by_ros = read_by_ros(path)
    for number, word in enumerate([*READ_AS_ANOTHER, *WORDS]):
        theirs, ours = by_ros[f"a{number}"], read_bare(word)
        assert type(ours) is type(theirs), word
        assert ours == theirs or (math.isnan(ours) and math.isnan(theirs)), word
        assert (ours == word) is (word in WORDS)


@pytest.mark.parametrize("word", READ_AS_ANOTHER)
def test_the_word_that_is_meant_is_known_from_what_it_was_read_as(word: str) -> None:
    assert word_meant(read_bare(word), ["freeze", word]) == word
    assert word_meant(read_bare(word), ["freeze"]) == ""


@given(st.lists(st.one_of(st.sampled_from(READ_AS_ANOTHER), st.text("yesnof.e+-0123", min_size=1)), min_size=1))
@settings(max_examples=30)
def test_ros_reads_every_text_as_the_text_that_was_written(
    tmp_path_factory: pytest.TempPathFactory, texts: list[str]
) -> None:
    path = tmp_path_factory.mktemp("written") / "own.yaml"
    write_sections({"/**": {"a.list": texts, "a.first": texts[0]}}, path)
    assert read_by_ros(path) == {"list": texts, "first": texts[0]}
