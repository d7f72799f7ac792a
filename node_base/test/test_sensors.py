"""Readings travel in messages and come out as they went in; units, frames and signs are those of the messages."""

from __future__ import annotations

import math

import numpy as np
import pytest
from heave_node.interface import topics
from heave_node.interface.messages import SensorMessages, message_type
from heave_node.interface.sensors import (
    DEPTH,
    IMU,
    LOAD_CELL,
    MRU,
    SENSORS,
    STANDARD_WATER,
    UNKNOWN_VARIANCE,
    USBL,
    VELOCITY,
    MruReading,
    Reading,
    Sensor,
    Water,
    WireReading,
    mru_reading,
)
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message

NUMBER = st.floats(-1e6, 1e6)
WATER = st.builds(Water, density=st.floats(900.0, 1100.0), gravity=st.floats(9.7, 9.9))
ON_UNIT = [sensor for sensor in SENSORS.values() if sensor is not MRU]


def through_a_message(sensor: Sensor, reading: WireReading) -> WireReading:
    """Return what a subscriber gets: message, bytes, message."""
    messages = SensorMessages(sensor)
    message = deserialize_message(messages.message(reading), message_type(sensor.topic.type))
    return messages.reading(bytes(serialize_message(message)))


def message_of(sensor: Sensor, *values: float, sigma: float = 0.02):
    reading = Reading(12.25, np.array(values), np.full(len(values), sigma))
    data = SensorMessages(sensor).message(sensor.to_wire(reading, Water(1025.0, 9.80665)))
    return deserialize_message(data, message_type(sensor.topic.type))


@pytest.mark.parametrize("sensor", ON_UNIT, ids=lambda sensor: sensor.name)
@given(data=st.data(), truth=WATER, assumed=WATER, time=st.floats(0.0, 1e6))
def test_a_reading_through_a_message_is_the_reading_handed_over_to_the_last_bit(data, sensor, truth, assumed, time):
    values = data.draw(st.lists(st.one_of(NUMBER, st.just(math.nan)), min_size=sensor.width, max_size=sensor.width))
    on_wire = sensor.to_wire(Reading(time, np.array(values), np.abs(np.array(values))), truth)
    heard = through_a_message(sensor, on_wire)
    assert heard.stamp == on_wire.stamp == round(time * 1e9)
    np.testing.assert_array_equal(sensor.from_wire(heard, assumed), sensor.from_wire(on_wire, assumed))


@pytest.mark.parametrize("sensor", ON_UNIT, ids=lambda sensor: sensor.name)
@given(data=st.data(), water=WATER)
def test_who_believes_in_the_water_that_is_reads_what_the_sensor_said(data, sensor, water):
    values = data.draw(st.lists(NUMBER, min_size=sensor.width, max_size=sensor.width))
    on_wire = sensor.to_wire(Reading(1.0, np.array(values), np.zeros(sensor.width)), water)
    types = message_type(sensor.topic.type).get_fields_and_field_types()
    rounding = 6e-8 if "float" in {types.get(field) for field in sensor.values} else 1e-15  # "float" has 24 bits
    # absolute pressure over rho g is 1e6 m at the most here: a rounding of 2e-10 m
    assert sensor.from_wire(on_wire, water) == pytest.approx(tuple(values), rel=rounding, abs=1e-9)


@given(
    values=st.lists(st.one_of(NUMBER, st.just(math.nan)), min_size=7, max_size=7),
    status=st.integers(0, 255),
    sequence=st.integers(0, 2**32 - 1),
)
def test_an_mru_sample_keeps_every_field(values, status, sequence):
    names = [name for name in MruReading._fields if name not in ("status", "sequence")]
    reading = MruReading(**dict(zip(names[1:], values, strict=True)), time=12.25, status=status, sequence=sequence)
    heard = mru_reading(through_a_message(MRU, MRU.to_wire(reading, STANDARD_WATER)))
    for name in (*names, "status", "sequence"):
        np.testing.assert_array_equal(getattr(heard, name), getattr(reading, name), err_msg=name)


def test_pressure_is_absolute_and_its_variance_that_of_the_depth():
    message = message_of(DEPTH, 300.0)
    assert message.fluid_pressure == pytest.approx(101_325.0 + 1025.0 * 9.80665 * 300.0)
    assert message.variance == pytest.approx((1025.0 * 9.80665 * 0.02) ** 2)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (12, 250_000_000)
    assert message.header.frame_id == "unit"


def test_a_depth_is_read_by_the_water_that_is_believed_in():
    """1030 kg/m^3 assumed to be 1025: 300 m read 300 * 1030 / 1025."""
    on_wire = DEPTH.to_wire(Reading(1.0, np.array([300.0]), np.zeros(1)), Water(1030.0, 9.80665))
    assert DEPTH.from_wire(on_wire, Water(1025.0, 9.80665)) == pytest.approx((300.0 * 1030.0 / 1025.0,))


def test_velocity_and_position_state_their_covariances_and_leave_the_rest_unknown():
    twist, pose = message_of(VELOCITY, 0.1, 0.2, 0.3), message_of(USBL, 1.0, 2.0, -3.0, sigma=0.5)
    assert (twist.twist.twist.linear.x, twist.twist.twist.linear.z) == (0.1, 0.3)
    assert pose.pose.pose.position.z == -3.0
    assert pose.pose.pose.orientation.w == 1.0
    assert (twist.header.frame_id, pose.header.frame_id) == ("unit", "world")
    for covariance, variance in ((twist.twist.covariance, 0.02**2), (pose.pose.covariance, 0.25)):
        matrix = np.reshape(covariance, (6, 6))
        np.testing.assert_allclose(np.diag(matrix), [variance] * 3 + [UNKNOWN_VARIANCE] * 3)
        assert np.count_nonzero(matrix) == 6


def test_imu_says_that_it_knows_no_orientation():
    message = message_of(IMU, 0.1, 0.2, 9.8, 0.01, 0.02, 0.03, sigma=0.005)
    # REP-145
    assert message.orientation_covariance[0] == -1.0
    assert message.linear_acceleration.z == 9.8
    assert message.angular_velocity.y == 0.02
    assert message.linear_acceleration_covariance[8] == pytest.approx(0.005**2)


def test_load_cell_reading_and_its_accuracy():
    message = message_of(LOAD_CELL, 36_500.0, sigma=182.0)
    assert (message.tension, message.tension_sigma) == (36_500.0, 182.0)


def test_every_sensor_has_a_name_and_a_topic_of_its_own():
    assert all(name == sensor.name for name, sensor in SENSORS.items())
    assert len({sensor.topic.name for sensor in SENSORS.values()}) == len(SENSORS)
    assert all(topics.TOPIC_BY_NAME[sensor.topic.name] is sensor.topic for sensor in SENSORS.values())
