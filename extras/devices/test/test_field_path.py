"""Fields of messages by their path."""

from types import SimpleNamespace

import pytest
from heave_devices.maps.field_path import FieldPath
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray


def test_a_path_finds_fields_entries_and_entries_by_name():
    joints = JointState(name=["crane.slew", "drum"], position=[0.1, 7.5])
    assert FieldPath("position[name=drum]").number_of(joints) == 7.5
    assert FieldPath("position[name=crane.slew]").number_of(joints) == 0.1
    assert FieldPath("position[1]").number_of(joints) == 7.5
    assert FieldPath("a.b").number_of(SimpleNamespace(a=SimpleNamespace(b=True))) == 1.0


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("velocity[0]", "0 entries"),
        ("speed", "no field speed"),
        ("position[name=hook]", "it has drum"),
        ("name", "no number"),
    ],
)
def test_what_is_not_there_is_said(path, words):
    with pytest.raises(LookupError, match=words):
        FieldPath(path).number_of(JointState(name=["drum"], position=[1.0]))


def test_a_number_that_is_not_finite_is_none():
    with pytest.raises(LookupError, match="nan"):
        FieldPath("data[0]").number_of(Float64MultiArray(data=[float("nan")]))


@pytest.mark.parametrize("path", ["", "a..b", "a[", "a[x]", "1a", "__import__('os')"])
def test_a_text_that_is_no_path_is_refused(path):
    with pytest.raises(ValueError, match="is no path"):
        FieldPath(path)


def test_a_value_is_written_where_the_path_says():
    message = Float64MultiArray()
    FieldPath("data[1]").put(message, 2.5)
    assert list(message.data) == [0.0, 2.5]
