"""Equal messages have equal bytes, whatever middleware left between their values."""

import random

import pytest
from heave_bags.cdr.canonical import Canonical
from heave_msgs.msg import ControllerState, SeaState, SensorHealth
from heave_node.cdr.definitions import schema_text
from heave_node.cdr.layout import MessageLayouts
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message

TYPE = "heave_msgs/msg/ControllerState"
texts = st.text(st.characters(min_codepoint=32, max_codepoint=255), max_size=12)
numbers = st.lists(st.floats(allow_nan=False), max_size=5)


@st.composite
def controller_states(draw):
    """Return a message with texts and sequences of any length, which move all that follows them."""
    return ControllerState(
        mode=draw(texts),
        reason=draw(texts),
        state_names=draw(st.lists(texts, max_size=3)),
        estimate=draw(numbers),
        innovation=draw(numbers),
        predicted_unit_heave=draw(st.floats(-1e6, 1e6)),
        sensors=[SensorHealth(sensor=draw(texts), age=draw(st.floats(0, 1e3))) for _ in range(draw(st.integers(0, 3)))],
    )


def spoil(data: bytes, seed: int) -> bytes:
    """Put noise where middleware may leave some: in the gaps, and behind the end."""
    layout = MessageLayouts(TYPE, schema_text(TYPE)).of(data)
    chance, spoilt = random.Random(seed), bytearray(data[: layout.end])
    for first, after in layout.gaps:
        spoilt[first:after] = chance.randbytes(after - first)
    return bytes(spoilt) + chance.randbytes(len(data) - layout.end)


@given(controller_states(), st.integers(0, 2**32))
def test_noise_between_values_makes_no_difference_and_no_value_changes(message, seed):
    clean = Canonical(TYPE, schema_text(TYPE))
    data = bytes(serialize_message(message))
    one, two = clean(spoil(data, seed)), clean(spoil(data, seed + 1))
    assert one == two
    assert clean(one) == one
    assert deserialize_message(one, ControllerState) == message


def test_what_middleware_appends_to_empty_sequences_is_cut_off():
    clean = Canonical("heave_msgs/msg/SeaState", schema_text("heave_msgs/msg/SeaState"))
    data = bytes(serialize_message(SeaState(spectrum="regular")))
    assert len(clean(data)) == 4 + 88 + 8  # encapsulation, values up to the seed, two lengths of zero


@pytest.mark.parametrize("data", [b"", b"\x00\x01\x00\x00", b"\x00\x00\x00\x00" + bytes(200)])
def test_what_is_no_such_message_is_left_as_it_is(data):
    assert Canonical(TYPE, schema_text(TYPE))(data) == data
