"""Observations and beliefs as messages of ROS and back, to the bit; what makes no sense is refused."""

import math
from types import MappingProxyType

import numpy as np
import pytest

pytest.importorskip("heave_msgs")
from heave_msgs.msg import Beliefs as BeliefsMessage
from heave_msgs.msg import Observations as ObservationsMessage
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from winch_controller_node.advice.messages import beliefs_message, beliefs_of, observations_message, observations_of
from winch_controller_node.beliefs.beliefs import Adopted, Belief, Beliefs, EncoderScale, Finding
from winch_controller_node.beliefs.quantities import QUANTITIES, RESTATED
from winch_controller_node.design.design import design_controller
from winch_controller_node.design.wire import WireError, parts_of
from winch_controller_node.interface.observations import READING_COLUMNS, TICK_COLUMNS, Observations
from winch_controller_node.node_parameters import WinchControllerParameters

STAMP = 12_950_000_000
DESIGN = design_controller(WinchControllerParameters(), tick_period=0.05)
ORDER = DESIGN.model.order
ANY = st.floats(allow_nan=True, allow_infinity=True)
TICKS = st.integers(0, 2**62)


def table(columns):
    return st.integers(0, 7).flatmap(
        lambda rows: st.lists(ANY, min_size=rows * columns, max_size=rows * columns).map(
            lambda values: np.array(values, dtype=float).reshape(rows, columns)
        )
    )


observations = st.builds(
    Observations,
    first=TICKS,
    ticks=table(len(TICK_COLUMNS)),
    rows=st.lists(st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]))).map(tuple),
    readings=table(len(READING_COLUMNS)),
    epoch=TICKS,
    beliefs=TICKS,
    excluded=st.sampled_from(["", "mru", "depth"]),
    is_trusted=st.booleans(),
    restated=st.lists(st.tuples(st.sampled_from(RESTATED), st.floats(allow_nan=False)), max_size=5).map(tuple),
)

beliefs = st.builds(
    Beliefs,
    asked=TICKS,
    number=TICKS,
    values=st.lists(
        st.builds(
            Belief,
            quantity=st.sampled_from(sorted(QUANTITIES)),
            value=st.floats(allow_nan=False, allow_infinity=False),
            sigma=ANY,
            nats=ANY,
            since=TICKS,
        ),
        unique_by=lambda belief: belief.quantity,
    ).map(lambda found: MappingProxyType({belief.quantity: belief for belief in found})),
    encoder=st.sampled_from([None, EncoderScale(40, -1.1, 2.0, 1.0 / 3.0)]),
    excluded=st.sampled_from(["", "mru"]),
    authority=st.floats(0.0, 1.0),
    findings=st.lists(
        st.builds(
            Finding,
            code=st.just("limit"),
            quantity=st.just("cable"),
            value=ANY,
            unit=st.just("m"),
            nominal=ANY,
            nats=ANY,
            since=TICKS,
        )
    ).map(tuple),
    design=st.sampled_from([None, DESIGN]),
    adopted=st.sampled_from([None, Adopted(7, np.linspace(0.0, 1.0, ORDER), np.eye(ORDER) / 3.0)]),
)


@given(observations)
def test_observations_come_back_to_the_bit(given_observations):
    data = observations_message(given_observations, "{}", STAMP)
    message = deserialize_message(data, ObservationsMessage)
    again = observations_of(message)
    assert (again.ticks.tobytes(), again.ticks.shape) == (
        given_observations.ticks.tobytes(),
        given_observations.ticks.shape,
    )
    assert again.readings.tobytes() == given_observations.readings.tobytes()
    assert again.last == given_observations.last
    assert again.restated == given_observations.restated
    assert observations_message(again, message.nominal, STAMP) == data
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (12, 950_000_000)


@given(beliefs)
def test_beliefs_come_back_to_the_bit(given_beliefs):
    data = beliefs_message(given_beliefs, STAMP)
    again = beliefs_of(deserialize_message(data, BeliefsMessage))
    assert list(again.values) == list(given_beliefs.values), "in their order"
    assert (again.design is None) == (given_beliefs.design is None)
    if again.design is not None:
        parts = parts_of(DESIGN)
        assert {name: a.tobytes() for name, a in parts_of(again.design).arrays.items()} == {
            name: a.tobytes() for name, a in parts.arrays.items()
        }
    assert beliefs_message(again, STAMP) == data


def test_the_bytes_are_those_of_the_middleware():
    given_beliefs = Beliefs(
        asked=20, findings=(Finding("limit", "winch.speed_out", 0.9, "m/s", 1.0, 9.0, 7),), design=DESIGN
    )
    data = beliefs_message(given_beliefs, STAMP)
    by_middleware = serialize_message(deserialize_message(data, BeliefsMessage))
    assert deserialize_message(by_middleware, BeliefsMessage) == deserialize_message(data, BeliefsMessage)
    assert len(by_middleware) == len(data)


def message_with(change) -> BeliefsMessage:
    belief = Belief("winch.time_constant", 0.4)
    sent = Beliefs(
        asked=20,
        values=MappingProxyType({belief.quantity: belief}),
        encoder=EncoderScale(7, 0.9, 1.0, 1.0),
        design=DESIGN,
        adopted=Adopted(20, np.zeros(ORDER), np.eye(ORDER)),
    )
    message = deserialize_message(beliefs_message(sent, STAMP), BeliefsMessage)
    change(message)
    return message


def set_array(name, values):
    def change(message):
        (one,) = [array for array in message.design[0].arrays if array.name == name]
        one.values = values

    return change


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda m: setattr(m, "authority", 1.5), "authority"),
        (lambda m: setattr(m, "authority", math.nan), "authority"),
        (lambda m: setattr(m, "asked", -1), "asked"),
        (lambda m: setattr(m.values[0], "value", math.inf), "winch.time_constant is inf"),
        (lambda m: setattr(m.values[0], "quantity", "winch.colour"), "no quantity 'winch.colour'"),
        (lambda m: setattr(m, "values", [m.values[0], m.values[0]]), "twice"),
        (lambda m: setattr(m.adopted[0], "estimate", [0.0]), "adopted"),
        (lambda m: setattr(m.adopted[0], "covariance", [0.0]), "adopted covariance"),
        (lambda m: setattr(m.adopted[0], "estimate", [math.nan] * ORDER), "not finite"),
        (lambda m: setattr(m.encoder[0], "scale", 0.0), "encoder scale"),
        (lambda m: setattr(m.encoder[0], "payout", math.nan), "encoder scale"),
        (lambda m: m.design[0].arrays.append(m.design[0].arrays[0]), "a name appears twice"),
        (set_array("gain", [1.0]), "gain has 1 numbers"),
        (set_array("gain", [math.nan] * ORDER), "gain holds a value that is not finite"),
    ],
)
def test_an_answer_that_makes_no_sense_is_refused_with_the_part_that_is_wrong(change, words):
    with pytest.raises(WireError, match=words):
        beliefs_of(message_with(change))


def test_observations_of_other_columns_are_refused():
    sent = Observations(1, np.zeros((1, len(TICK_COLUMNS))), (), np.zeros((0, len(READING_COLUMNS))), 0, 0)
    message = deserialize_message(observations_message(sent, "{}", STAMP), ObservationsMessage)
    message.restated = ["length"]
    with pytest.raises(WireError, match="restated"):
        observations_of(message)
    message.restated_values = [400.0]
    assert observations_of(message).restated == (("length", 400.0),)
    message.ticks = [*message.ticks, 0.0]
    with pytest.raises(WireError, match="no multiple"):
        observations_of(message)
    message.tick_columns = ["time"]
    with pytest.raises(WireError, match="tick_columns must be command"):
        observations_of(message)
