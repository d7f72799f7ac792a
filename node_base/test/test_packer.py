"""Packed bytes are those of rclpy, for every type of the suite and any values, and come out again as they went in."""

from __future__ import annotations

import re
import struct
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import Vector3
from heave_node.cdr.definitions import DefinitionError, schema_text
from heave_node.cdr.layout import NUMPY_TYPES, Field, LayoutError, MessageLayouts, parse_schema
from heave_node.cdr.packer import Packer
from heave_node.cdr.unpacker import Unpacker, header_stamp
from heave_node.interface import topics
from heave_node.interface.messages import message_type
from hypothesis import given, settings
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message

PROTOCOL = (topics.TICK_JOIN, topics.TICK_ROSTER, topics.TICK_START, topics.TICK_STATUS, topics.tick_done_topic("node"))
TYPES = sorted({topic.type for topic in (*topics.ALL_TOPICS, *PROTOCOL)})
TIMES = ("builtin_interfaces/Time", "builtin_interfaces/Duration")
SECOND = 1_000_000_000


class Definition:
    """A type: draws values as a packer takes them, and makes messages of rclpy of such values."""

    def __init__(self, name: str) -> None:
        self.types = parse_schema(name, schema_text(name))
        self.fields = self.types[next(iter(self.types))]
        bounds = re.findall(r"\[<=(\d+)\]\s+(\w+)", schema_text(name))
        self.most = {field: int(most) for most, field in bounds}

    def numbers_in(self, kind: str) -> list[str]:
        """Return the types of the numbers in a structure, or "text" for what is none."""
        if kind in NUMPY_TYPES:
            return [NUMPY_TYPES[kind]]
        inside = [
            self.numbers_in(f.type) * (f.count or 1) if f.count != -1 else ["text"] for f in self.types.get(kind, [])
        ]
        return [number for part in inside for number in part] or ["text"]

    def is_row(self, kind: str) -> bool:
        """Return whether a structure holds numbers of one type and nothing else."""
        return len(set(self.numbers_in(kind))) == 1 and self.numbers_in(kind)[0] != "text"

    def values(self, field: Field) -> st.SearchStrategy[Any]:
        if field.count is None and field.type in NUMPY_TYPES:
            return numbers(NUMPY_TYPES[field.type])
        if self.is_row(field.type):
            kinds = self.numbers_in(field.type)
            width = len(kinds) * (1 if field.count is None else field.count)
            if field.count == -1:
                return st.integers(0, self.most.get(field.name, 3)).flatmap(
                    lambda n: st.lists(numbers(kinds[0]), min_size=n * len(kinds), max_size=n * len(kinds))
                )
            return st.lists(numbers(kinds[0]), min_size=width, max_size=width)
        if field.type == "string":
            one: st.SearchStrategy[Any] = st.text(
                st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=9
            )
        elif field.type in TIMES:
            one = st.integers(-(2**31) * SECOND, 2**31 * SECOND - 1)
        else:
            one = st.tuples(*(self.values(member) for member in self.types[field.type]))
        return one if field.count is None else st.lists(one, max_size=self.most.get(field.name, 3))

    def message(self, fields: list[Field], make: Any, given: Any) -> Any:
        """Return a message of the class `make` with the values `given` to its fields."""
        message = make()
        for field, value in zip(fields, given, strict=True):
            setattr(message, field.name, self.of_rclpy(field, value))
        return message

    def of_rclpy(self, field: Field, value: Any) -> Any:
        if field.type == "byte":
            return bytes([value])
        if field.type in NUMPY_TYPES or field.type == "string":
            return value
        make, members = message_type("/msg/".join(field.type.split("/"))), self.types[field.type]
        if field.type in TIMES:
            split = [divmod(ns, SECOND) for ns in ([value] if field.count is None else value)]
        elif self.is_row(field.type):
            width = len(self.numbers_in(field.type))
            split = [self.unflattened(members, value[i : i + width]) for i in range(0, len(value), width)]
        else:
            split = [value] if field.count is None else value
        made = [self.message(members, make, part) for part in split]
        return made[0] if field.count is None else made

    def unflattened(self, members: list[Field], row: list[Any]) -> list[Any]:
        """Return the values of each field of a structure of which `row` has all numbers."""
        found, position = [], 0
        for member in members:
            width = len(self.numbers_in(member.type)) * (member.count or 1)
            part = row[position : position + width]
            found.append(part[0] if member.type in NUMPY_TYPES and member.count is None else part)
            position += width
        return found


def numbers(dtype: str) -> st.SearchStrategy[Any]:
    kind = np.dtype(dtype)
    if kind.kind == "b":
        return st.booleans()
    if kind.kind == "f":
        return st.floats(width=8 * kind.itemsize)
    return st.integers(int(np.iinfo(kind).min), int(np.iinfo(kind).max))


def cleared(name: str, data: bytes) -> bytes:
    """Return a message without what the middleware leaves between its values and behind them."""
    layout = MessageLayouts(name, schema_text(name)).of(data)
    clean = bytearray(data[: layout.end])
    for first, after in layout.gaps:
        clean[first:after] = bytes(after - first)
    return bytes(clean)


@pytest.mark.parametrize("name", TYPES)
@settings(max_examples=25)
@given(data=st.data())
def test_packed_bytes_are_those_of_rclpy(name, data):
    definition = Definition(name)
    drawn = [data.draw(definition.values(field), label=field.name) for field in definition.fields]
    message = definition.message(definition.fields, message_type(name), drawn)
    packed = Packer(name, [field.name for field in definition.fields]).pack(*drawn)
    assert packed == cleared(name, bytes(serialize_message(message)))


@pytest.mark.parametrize("name", TYPES)
@settings(max_examples=10)
@given(data=st.data())
def test_an_unpacker_takes_out_the_numbers_that_went_in(name, data):
    definition = Definition(name)
    drawn = {field.name: data.draw(definition.values(field), label=field.name) for field in definition.fields}
    rows = [f.name for f in definition.fields if definition.is_row(f.type)]
    packed = Packer(name, list(drawn)).pack(*drawn.values())
    expected = [number for row in rows for number in (drawn[row] if isinstance(drawn[row], list) else [drawn[row]])]
    np.testing.assert_array_equal(Unpacker(name, rows).unpack(packed), expected)
    backwards = [number for row in rows[::-1] for number in Unpacker(name, [row]).unpack(packed)]
    np.testing.assert_array_equal(Unpacker(name, rows[::-1]).unpack(packed), backwards)


def test_fields_deep_inside_are_given_by_their_path_and_all_others_are_zero_or_empty():
    packer = Packer(
        "nav_msgs/msg/Odometry",
        ("pose.covariance[7]", "header.stamp", "twist.twist.linear"),
        {"child_frame_id": "unit", "pose.pose.orientation.w": 1.0},
    )
    message = deserialize_message(packer.pack(0.25, 1_500_000_000, np.array([1.0, 2.0, 3.0])), Odometry)
    expected = Odometry(child_frame_id="unit")
    expected.header.stamp.sec, expected.header.stamp.nanosec = 1, 500_000_000
    expected.pose.covariance[7] = 0.25
    expected.twist.twist.linear = Vector3(x=1.0, y=2.0, z=3.0)
    assert message == expected


def test_positions_may_be_an_array_of_any_layout_in_memory():
    packer = Packer("heave_msgs/msg/CableState", ("nodes",))
    nodes = np.arange(6.0).reshape(3, 2).T
    assert packer.pack(nodes) == packer.pack(nodes.ravel().tolist()) == packer.pack(nodes.astype(np.float32))


def test_what_does_not_fit_is_refused():
    with pytest.raises(ValueError, match="heave_msgs/msg/WaveElevation has no field depth"):
        Packer("heave_msgs/msg/WaveElevation", ("depth",))
    with pytest.raises(DefinitionError):
        Packer("heave_msgs/msg/Nothing", ())
    position = Packer("heave_msgs/msg/PointMotion", ("position",))
    for wrong in (np.zeros(2), np.zeros(6), [0.0]):
        with pytest.raises(ValueError, match="cannot hold"):
            position.pack(wrong)
    with pytest.raises(ValueError, match="2 values for 1 fields"):
        position.pack(np.zeros(3), np.zeros(3))
    with pytest.raises(struct.error):
        Packer("heave_msgs/msg/WinchState", ("limits_hit",)).pack(256)


def test_a_message_is_unpacked_only_where_it_fits_its_definition():
    good = Packer("heave_msgs/msg/WaveElevation", ("header.stamp", "elevation")).pack(2_000_000_003, 0.5)
    unpacker = Unpacker("heave_msgs/msg/WaveElevation", ("elevation",))
    assert (unpacker.unpack(good), header_stamp(good)) == ((0.5,), 2_000_000_003)
    for bad in (b"", good[:-1], b"\0\0" + good[2:], good[:12] + b"\xff" + good[13:]):
        with pytest.raises(LayoutError):
            unpacker.unpack(bad)
    with pytest.raises(ValueError, match="no field depth"):
        Unpacker("heave_msgs/msg/WaveElevation", ("depth",))
    with pytest.raises(LayoutError, match=r"header\.frame_id of .* is no number"):
        Unpacker("heave_msgs/msg/WaveElevation", ("header.frame_id",)).unpack(good)


def test_texts_of_any_number_of_lengths_do_not_fill_the_memory():
    packer, unpacker = (
        kind("heave_msgs/msg/SensorHealth", ("sensor", "age")[n:]) for n, kind in enumerate((Packer, Unpacker))
    )
    for length in range(2000):
        assert unpacker.unpack(packer.pack("x" * length, float(length))) == (length,)
    assert len(packer._structs) <= 256
