"""Quantities taken by a map: units, signs, validity, sizes."""

import math
from types import SimpleNamespace

import pytest
from heave_devices.formats.sample import Sample
from heave_devices.live.taker import Taker, euler_angle
from heave_devices.maps.device_map import device_map_of
from hypothesis import given
from hypothesis import strategies as st

SBG = {
    "frame": "NED",
    "heave": {"topic": "/m", "type": "t", "field": "ship_motion.z", "valid": "status.heave_valid"},
    "roll": {"topic": "/e", "type": "t", "field": "angle.x"},
}


def motion(z, valid):
    return SimpleNamespace(ship_motion=SimpleNamespace(z=z), status=SimpleNamespace(heave_valid=valid))


def test_a_sample_that_is_called_invalid_is_never_used():
    taker = Taker(device_map_of("m", SBG))
    assert taker.of_message("/m", motion(0.5, True), 0.0).values == {"heave": -0.5}
    bad = taker.of_message("/m", motion(99.0, False), 0.1)
    assert not bad.values
    assert bad.invalid == {"heave"}
    assert taker.counters.invalid == 1


@pytest.mark.parametrize("size", [31.0, 1e300, math.inf, math.nan])
def test_a_size_that_cannot_be_is_never_used(size):
    taker = Taker(device_map_of("m", SBG))
    taken = taker.of_message("/m", motion(size, True), 0.0)
    assert not taken.values
    assert taker.counters.implausible or taker.counters.missing


@pytest.mark.parametrize("size", [31.0, -1e300, math.inf, math.nan])
def test_a_number_of_a_register_that_cannot_be_is_never_used(size):
    """A PLC's float32 may hold NaN, which is neither below nor above a limit."""
    taker = Taker(
        device_map_of("m", {"source": {"modbus": "1"}, "payout_rate": "input:0:float32", "payout": "input:2"})
    )
    taken = taker.of_sample(Sample("MODBUS", {"input:0:float32": size, "input:2": 7.0}), 0.0)
    assert (taken.values, taken.invalid) == ({"payout": 7.0}, {"payout_rate"})
    assert taker.counters.invalid == 1


def test_a_field_that_is_not_there_is_told():
    taker = Taker(device_map_of("m", SBG))
    assert not taker.of_message("/e", SimpleNamespace(angles=1), 0.0).values
    assert taker.counters.missing == {"there is no field angle.x": 1}


@pytest.mark.parametrize(("status", "is_used"), [(3, True), (6, True), (1, False), (7, False)])
def test_a_status_may_be_one_of_several_values(status, is_used):
    entry = {"topic": "/i", "type": "t", "field": "height", "valid": "status.status", "valid_values": [3, 6]}
    taken = Taker(device_map_of("m", {"heave": entry})).of_message(
        "/i", SimpleNamespace(height=1.0, status=SimpleNamespace(status=status)), 0.0
    )
    assert ("heave" in taken.values) == is_used


def test_a_word_of_a_line_may_be_the_status():
    line = {"format": "line", "pattern": "(?P<state>..),(?P<x>.+)"}
    taker = Taker(
        device_map_of("m", {**line, "tension": {"field": "x", "unit": "kN", "valid": "state", "valid_values": "ST"}})
    )
    assert taker.of_sample(Sample("LINE", {"x": 2.0}, words={"state": "ST"}), 0.0).values == {"tension": 2000.0}
    assert not taker.of_sample(Sample("LINE", {"x": 2.0}, words={"state": "US"}), 0.0).values


def test_the_first_value_may_count_as_zero():
    entry = {"topic": "/j", "type": "t", "field": "x", "zero_at_start": True, "scale": 0.5}
    taker = Taker(device_map_of("m", {"payout": entry}))
    values = [taker.of_message("/j", SimpleNamespace(x=x), 0.0).values["payout"] for x in (690.0, 692.0)]
    assert values == [0.0, 1.0]


@given(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5), st.floats(-3.0, 3.0))
def test_the_angles_of_a_quaternion(roll, pitch, yaw):
    """The quaternion is the product of the three turns about z, y, x, each by its half angle."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a / 2), math.sin(a / 2)) for a in (roll, pitch, yaw))
    turn = (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )
    assert euler_angle("roll", *turn) == pytest.approx(roll, abs=1e-6)
    assert euler_angle("pitch", *turn) == pytest.approx(pitch, abs=1e-6)
    assert euler_angle("yaw", *turn) == pytest.approx(yaw, abs=1e-6)
