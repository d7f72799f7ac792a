"""Quantities taken by a map: units, signs, validity, sizes."""

import math
import struct
from types import SimpleNamespace

import pytest
from heave_devices.formats.number_kinds import with_words_swapped
from heave_devices.formats.sample import Sample
from heave_devices.live.taker import Taker
from heave_devices.maps.device_map import device_map_of
from heave_node.numerics.kinematics import euler_part
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

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


@pytest.mark.parametrize(
    ("kind", "content", "field"),
    [
        ("MODBUS", {"source": {"modbus": "1"}}, "input:4"),
        ("DATAGRAM", {"format": "datagram", "layout": {"place": "int32", "status": "uint16"}}, "status"),
    ],
)
def test_one_bit_of_a_status_calls_a_sample_valid(kind, content, field):
    """Bit 2 of 0b0110 and of 0b1011."""
    place = "input:0:int32" if kind == "MODBUS" else "place"
    taker = Taker(device_map_of("m", {**content, "payout": {"field": place, "valid": f"{field}.2"}}))
    taken = [taker.of_sample(Sample(kind, {place: 7.0, field: status}), 0.0) for status in (0b0110, 0b1011)]
    assert (taken[0].values, taken[1].invalid) == ({"payout": 7.0}, {"payout"})


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


NOT_AVAILABLE = [
    ("int16", -32768.0),
    ("int16", 32767.0),
    ("uint16", 65535.0),
    ("int32", -(2.0**31)),
    ("uint32", 2.0**32 - 1.0),
    ("float32", math.nan),
    ("float32", -math.inf),
]


@pytest.mark.parametrize("is_zero", [True, False])
@pytest.mark.parametrize(("kind", "sent"), NOT_AVAILABLE)
def test_what_stands_for_not_available_is_no_value_and_no_zero(kind, sent, is_zero):
    """A drive that is not referenced yet, and then is at 300 as it counts."""
    entry = {"field": f"input:0:{kind}", "unit": "mm", "scale": 0.1, "zero_at_start": is_zero}
    taker = Taker(device_map_of("m", {"source": {"modbus": "1"}, "payout": entry}))
    for _ in range(3):
        taken = taker.of_sample(Sample("MODBUS", {f"input:0:{kind}": sent}), 0.0)
        assert (taken.values, taken.invalid) == ({}, {"payout"})
    assert taker.counters.unavailable.keys() == {"payout"}
    taken = taker.of_sample(Sample("MODBUS", {f"input:0:{kind}": 300.0}), 0.0)
    assert taken.values == {"payout": 0.0 if is_zero else pytest.approx(0.03)}
    assert not taker.counters.unavailable


PHTRO = "(?P<covered>PHTRO,(?P<pitch>[0-9.]+),(?P<ps>[MP]),(?P<roll>[0-9.]+),(?P<rs>[BT]))"
"""Pitch with M for bow up and P for bow down, roll with B for port down and T for port up, by iXblue's manual."""


@pytest.mark.parametrize(
    ("line", "pitch", "roll"),
    [("PHTRO,1.50,M,2.00,B", -1.5, -2.0), ("PHTRO,1.50,P,2.00,T", 1.5, 2.0), ("PHTRO,0.00,P,0.00,B", 0.0, 0.0)],
)
def test_a_letter_may_be_the_sign(line, pitch, roll):
    signs = {
        "pitch": {"field": "pitch", "unit": "deg", "sign": {"field": "ps", "negative": ["M"]}},
        "roll": {"field": "roll", "unit": "deg", "sign": {"field": "rs", "negative": "B"}},
    }
    device = device_map_of("m", {"format": "line", "pattern": PHTRO + "(?P<heave>)?", "heave": "heave", **signs})
    (sample,) = device.decoder().feed(f"${line}\r\n".encode())
    values = Taker(device).of_sample(sample, 0.0).values
    assert values == {"pitch": pytest.approx(math.radians(pitch)), "roll": pytest.approx(math.radians(roll))}


def test_a_value_whose_sign_is_missing_is_none():
    entry = {"field": "x", "sign": {"field": "s", "negative": ["P"]}}
    taker = Taker(device_map_of("m", {"format": "line", "pattern": "(?P<s>[A-Z]?)(?P<x>.+)", "tension": entry}))
    assert not taker.of_sample(Sample("LINE", {"x": 2.0}), 0.0).values


def test_a_map_names_what_stands_for_not_available_of_its_drive():
    entry = {"field": "p", "zero_at_start": True, "invalid_values": [-999.9, 88888]}
    content = {"format": "line", "pattern": "(?P<p>[-0-9.]+)", "payout": entry}
    taker = Taker(device_map_of("m", content))
    sent = [taker.of_sample(Sample("LINE", {"p": p}), 0.0).values for p in (88888.0, -999.9, 5.0, 5.5)]
    assert sent == [{}, {}, {"payout": 0.0}, {"payout": 0.5}]


def test_a_count_and_a_status_use_all_of_their_range():
    content = {"source": {"modbus": "1"}, "payout": "input:0", "watchdog": "input:1:int16", "fault": "input:2:int16"}
    values = {"input:0": 1.0, "input:1:int16": 32767.0, "input:2:int16": -32768.0}
    taken = Taker(device_map_of("m", content)).of_sample(Sample("MODBUS", values), 0.0)
    assert (taken.values["watchdog"], taken.values["fault"]) == (32767.0, -32768.0)


def test_a_value_beyond_the_plausible_is_no_zero():
    entry = {"field": "input:0:int32", "unit": "mm", "zero_at_start": True}
    taker = Taker(device_map_of("m", {"source": {"modbus": "1"}, "payout": entry}))
    sent = [taker.of_sample(Sample("MODBUS", {"input:0:int32": p}), 0.0).values for p in (1e9, 1e4, 1.2e4)]
    assert sent == [{}, {"payout": 0.0}, {"payout": 2.0}]


@pytest.mark.parametrize("turn", [2.14e9, -1.9e9])
def test_a_counter_that_has_run_for_years_begins_anywhere_and_its_zero_is_the_first_that_another_confirms(turn):
    """Some 2000 km of rope by a count of millimetres in 32 bits: it was refused for ever."""
    entry = {"field": "input:0:int32", "unit": "mm", "zero_at_start": True}
    taker = Taker(device_map_of("m", {"source": {"modbus": "1"}, "payout": entry}))
    counts = [turn + k for k in (0, 0, 2e3, 5e5, -4e7, 5e5)]
    sent = [taker.of_sample(Sample("MODBUS", {"input:0:int32": one}), 0.0).values for one in counts]
    assert sent[:4] == [{}, {"payout": 0.0}, {"payout": 2.0}, {"payout": 500.0}]
    assert sent[4:] == [{}, {"payout": 500.0}], "40 km from the zero is none"
    assert taker.counters.implausible == {"payout": 1}


@pytest.mark.parametrize(("order", "hint"), [("big", ""), ("little", "with word_order: big it moved by +0.0001 m")])
def test_a_fine_count_in_the_other_order_is_known_by_how_far_it_went_since_it_was_asked(order, hint):
    """One of micrometres: swapped, each is 65.5 mm, which a drum may do; its last reading has not moved."""
    entry = {"field": "input:0:int32", "unit": "mm", "scale": 0.001}
    taker = Taker(device_map_of("m", {"source": {"modbus": "1", "word_order": order}, "payout": entry}))
    counts = [count if order == "big" else with_words_swapped("int32", count) for count in (2_000, 2_100, 2_100)]
    payouts = [taker.of_sample(Sample("MODBUS", {"input:0:int32": n}), 0.0).values["payout"] for n in counts]
    assert taker.jump_in_other_order("payout", payouts[-1] - payouts[0], counts[0]) == hint


@pytest.mark.parametrize(
    ("kind", "sent", "order", "hint"),
    [
        ("int32", 123_100, "big", "with word_order: little it reads 12.31"),
        ("float32", 123_100.0, "big", "with word_order: little it reads 12.31"),
        ("float32", 123_100.0, "little", "with word_order: big it reads 12.31"),
    ],
)
def test_words_in_the_other_order_are_named(kind, sent, order, hint):
    """12.31 m in 0.1 mm, as a PLC of the other order sends it."""
    swapped = with_words_swapped(kind, sent)
    entry = {"field": f"input:0:{kind}", "unit": "mm", "scale": 0.1}
    taker = Taker(device_map_of("m", {"source": {"modbus": "1", "word_order": order}, "payout": entry}))
    assert not taker.of_sample(Sample("MODBUS", {f"input:0:{kind}": swapped}), 0.0).values
    assert hint in taker.counters.worst


def test_a_datagram_has_no_word_order_to_set():
    """A whole number read as a float: word_order, which only Modbus has, was proposed, and refused when entered."""
    entry = {"source": {"udp": "1"}, "format": "datagram", "layout": {"force": "float32"}, "tension": "force"}
    taker = Taker(device_map_of("m", entry))
    number = struct.unpack(">f", struct.pack(">i", 16_000))[0]
    assert not taker.of_sample(Sample("DATAGRAM", {"force": number}), 0.0).values
    assert taker.counters.worst.endswith("no instrument reads it: check unit, scale and column of the map")


@pytest.mark.parametrize("status", [math.inf, math.nan, 1e300])
def test_a_bit_of_what_is_no_status_is_invalid(status):
    layout = {"format": "datagram", "layout": {"status": "float64", "position": "float64"}}
    taker = Taker(device_map_of("m", {**layout, "payout": "position", "fault": "status.1"}))
    taken = taker.of_sample(Sample("DATAGRAM", {"status": status, "position": 1.0}), 0.0)
    assert taken.values.get("fault", 0.0) in (0.0, 1.0)
    assert ("fault" in taken.invalid) == (not math.isfinite(status))


@pytest.mark.parametrize("bits", [0, 4])
def test_a_validity_that_is_no_number_calls_nothing_valid(bits):
    entry = {"topic": "/m", "type": "t", "field": "z", "valid": "s", "invalid_bits": bits}
    taker = Taker(device_map_of("m", {"heave": entry}))
    for status in (math.nan, math.inf):
        assert not taker.of_message("/m", SimpleNamespace(z=0.1, s=status), 0.0).values


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
    turn = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_quat()
    found = [float(euler_part(part, *turn)) for part in ("roll", "pitch", "yaw")]
    assert found == pytest.approx([roll, pitch, yaw], abs=1e-6)


ODOMETRY = {"topic": "/o", "type": "nav_msgs/msg/Odometry"}


def odometry(velocity, turn):
    """A message whose twist is the `velocity` of the world [m/s] in the body's axes, as the type's definition says."""
    x, y, z, w = turn.as_quat()
    linear = SimpleNamespace(**dict(zip("xyz", turn.inv().apply(velocity), strict=True)))
    pose = SimpleNamespace(position=SimpleNamespace(z=0.5), orientation=SimpleNamespace(x=x, y=y, z=z, w=w))
    return SimpleNamespace(pose=SimpleNamespace(pose=pose), twist=SimpleNamespace(twist=SimpleNamespace(linear=linear)))


@given(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5), st.floats(-3.0, 3.0), st.floats(-5.0, 5.0))
def test_the_twist_of_an_odometry_is_turned_into_the_world_by_its_pose(roll, pitch, yaw, speed):
    """The turn by scipy; with a degree of trim at 2 m/s the body's own z is 0.035 m/s off."""
    entry = {**ODOMETRY, "field": "twist.twist.linear.z"}
    taker = Taker(device_map_of("m", {"heave": {**ODOMETRY, "field": "pose.pose.position.z"}, "heave_rate": entry}))
    message = odometry([speed, 0.3, -0.4], Rotation.from_euler("ZYX", [yaw, pitch, roll]))
    assert taker.of_message("/o", message, 0.0).values == {"heave": 0.5, "heave_rate": pytest.approx(-0.4, abs=1e-9)}


def test_a_vector_of_any_message_is_turned_where_the_map_says_so_and_none_where_it_says_none():
    turn = Rotation.from_euler("ZYX", [0.7, 0.1, 0.05])
    message = odometry([2.0, 0.0, 0.25], turn)
    body = message.twist.twist.linear.z
    field = {"topic": "/o", "field": "twist.twist.linear.z"}
    for more, expected in (
        ({"turned_by": "pose.pose.orientation"}, 0.25),
        ({}, body),
        ({"type": "nav_msgs/msg/Odometry", "turned_by": "none"}, body),
    ):
        content = {"heave": {**ODOMETRY, "field": "pose.pose.position.z"}, "heave_rate": {**field, **more}}
        taken = Taker(device_map_of("m", content)).of_message("/o", message, 0.0)
        assert taken.values["heave_rate"] == pytest.approx(expected)


def test_a_turn_that_is_none_is_told():
    taker = Taker(device_map_of("m", {"heave": {**ODOMETRY, "field": "twist.twist.linear.z", "high_pass": 300.0}}))
    message = odometry([2.0, 0.0, 0.25], Rotation.identity())
    message.pose.pose.orientation.w = 0.0
    assert not taker.of_message("/o", message, 0.0).values
    assert taker.counters.missing == {"pose.pose.orientation is a quaternion of length 0": 1}


@pytest.mark.parametrize(("raw", "is_used"), [(0.0, True), (-1e-25, True), (0.9e-25, False), (-1e-30, False)])
def test_a_float_that_is_next_to_nothing_is_the_words_of_another_one(raw, is_used):
    taker = Taker(device_map_of("m", {"source": {"modbus": "1"}, "payout": "input:0:float32"}))
    assert bool(taker.of_sample(Sample("MODBUS", {"input:0:float32": raw}), 0.0).values) is is_used
    assert bool(taker.counters.worst) is not is_used


@pytest.mark.parametrize("is_velocity", [False, True])
def test_a_heave_is_what_is_left_of_a_height_or_of_the_integral_of_a_velocity(is_velocity):
    """A height that heaves by 2 m in 10 s about 40 m, and how fast it does; to 3 % after 20 minutes of filter."""
    how = {"velocity": True} if is_velocity else {"high_pass": 300.0}
    entry = {"topic": "/m", "type": "t", "field": "z", **how}
    taker, omega = Taker(device_map_of("m", {"heave": entry})), 0.2 * math.pi
    heaves = []
    for k in range(12000):
        time = 0.1 * k
        sent = 2.0 * omega * math.cos(omega * time) if is_velocity else 40.0 + 2.0 * math.sin(omega * time)
        heaves.append(taker.of_message("/m", SimpleNamespace(z=sent), time).values["heave"])
    assert (min(heaves[-100:]), max(heaves[-100:])) == (pytest.approx(-2.0, rel=0.03), pytest.approx(2.0, rel=0.03))
