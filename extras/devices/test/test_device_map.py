"""What a map may say, and the one line with which it is refused."""

import math

import pytest
from heave_devices.maps.channel import MapError
from heave_devices.maps.device_map import device_map_of, read_device_map
from heave_node.files.bounded_yaml import parse_yaml
from hypothesis import given
from hypothesis import strategies as st

PSXN = {"format": "nmea", "source": {"udp": 7001}, "heave": "PSXN23.heave"}


def test_a_port_alone_is_of_this_machine_and_a_host_is_asked_for():
    assert device_map_of("m", PSXN).link.place == "127.0.0.1"
    assert device_map_of("m", {**PSXN, "source": {"udp": "0.0.0.0:7001"}}).link.place == "0.0.0.0"
    assert str(device_map_of("m", {**PSXN, "source": {"serial": "/dev/ttyUSB0"}}).link) == "serial /dev/ttyUSB0 at 9600"


def test_the_quantities_say_what_is_published():
    line = {"format": "line", "pattern": "(?P<a>.+),(?P<b>.+)", "source": {"tcp": "h:1"}}
    assert device_map_of("m", PSXN).outputs == ("mru",)
    assert device_map_of("m", {**line, "tension": "a", "payout": "b"}).outputs == ("winch/load_cell", "winch/state")
    assert device_map_of("m", {**line, "pressure": "a"}).outputs == ("unit/pressure",)


def test_units_signs_and_the_frame_make_one_factor():
    entry = {"topic": "/t", "type": "a/msg/B", "field": "z"}
    device = device_map_of("m", {"frame": "NED", "heave": {**entry, "unit": "cm"}, "pitch": {**entry, "unit": "deg"}})
    assert device.channels["heave"].factor("heave") == -0.01
    assert device.channels["pitch"].factor("pitch") == pytest.approx(-math.pi / 180.0), "NED: positive bow up"
    own = device_map_of("m", {"frame": "NED", "heave": {**entry, "positive": "up"}})
    assert own.channels["heave"].factor("heave") == 1.0, "what an entry says goes before the frame"
    load = device_map_of("m", {"tension": {**entry, "unit": "tf"}})
    assert load.channels["tension"].factor("tension") == pytest.approx(9806.65)


LINE = {"format": "line", "source": {"udp": 1}, "pattern": "(?P<x>.)"}
SIDED = {"format": "line", "pattern": "(?P<s>.)(?P<x>.)"}
TOPIC = {"topic": "/t", "type": "a/msg/B", "field": "x"}
REFUSED = [
    ([], "is no map"),
    ({}, "heave is missing"),
    ({"heav": "PSXN23.heave"}, "unknown entry heav; did you mean heave?"),
    ({**PSXN, "heave": "PSXN23.heve"}, "heave: unknown entry PSXN23.heve; did you mean PSXN23.heave?"),
    ({**PSXN, "format": "nmea2"}, "format = 'nmea2' must be one of nmea, tss1"),
    ({**PSXN, "heave": {"field": "PASHR.heave"}}, "say positive: up or positive: down"),
    ({"format": "nmea", "slew": "PENCR.angle_1"}, "say positive: anticlockwise or positive: clockwise"),
    ({**PSXN, "heave": {"field": "PSXN23.heave", "positive": "down"}}, "of known sign already"),
    ({**PSXN, "heave": {"field": "PSXN23.heave", "topic": "/t"}}, "has a topic, but the map has a format"),
    ({**PSXN, "lever_arm": [1, 2]}, "lever_arm = .1, 2. must have three numbers"),
    ({**PSXN, "lever_arm": [12000.0, 0, 0]}, "must be in metres"),
    ({**PSXN, "timeout": 0}, "timeout = 0 must be from 0.05 to 60 s"),
    ({**PSXN, "clock": "utc"}, "clock = 'utc' must be one of receipt, own"),
    ({**PSXN, "boom_tip": "maybe"}, "boom_tip = 'maybe' must be true or false"),
    ({**PSXN, "source": {"udp": 70000}}, "udp = 70000 must be PORT"),
    ({**PSXN, "source": {"udp": 1, "tcp": 2}}, "source must be one of"),
    ({**PSXN, "source": {"serial": "/dev/ttyS0", "baud": 1}}, "baud = 1 must be from 50"),
    ({**LINE, "tension": {"field": "x", "unit": "bar"}}, "bar is no unit of force; known: N, daN, kN"),
    ({**LINE, "payout": {"field": "x", "positive": "up"}}, "positive: 'up' is unknown; known: out, in"),
    ({**LINE, "tension": {"field": "x", "scale": 0}}, "scale 0, offset 0 cannot be"),
    ({**LINE, "tension": {"field": "x", "scale": "big"}}, "tension: scale = 'big' must be a number"),
    ({**LINE, "tension": {"field": "x", "offset": 1e12}}, "the largest tension is 1e.08"),
    ({**LINE, "pattern": "(", "tension": "x"}, "no regular expression"),
    ({"format": "line", "tension": "x"}, "pattern belongs to format: line"),
    ({"frame": "XYZ", "heave": TOPIC}, "frame = 'XYZ' must be one of ENU, NED"),
    ({"heave": {**TOPIC, "field": "a..b"}}, "heave: 'a..b' is no path"),
    ({"heave": {**TOPIC, "column": "c"}}, "needs either a topic or a column"),
    ({"heave": {**TOPIC, "valid_values": [1]}}, "valid_values needs valid"),
    ({"heave": {"column": "heave", "invalid_bits": 4}}, "invalid_bits needs valid"),
    ({"heave": {"column": "heave", "valid": "s", "invalid_bits": "four"}}, "must be a whole number"),
    ({"heave": {"topic": "/a", "part": "rool"}}, "part must be one of roll, pitch, yaw"),
    ({"heave": {"topik": "/a"}}, "unknown entry topik; did you mean topic?"),
    ("just a text", "is no map"),
    ({"heave": {"column": "z"}, "time_column": [1]}, "must be a heading, or a list of headings"),
    ({"heave": {"column": "z"}, "rate": 0.0}, "rate must be above 0"),
    ({"heave": {**TOPIC, "acceleration": True}}, "of an acceleration alone no live heave"),
    ({"heave": {**TOPIC, "high_pass": 5}}, "high_pass = 5 must be from 20"),
    ({"heave": {"topic": "/o", "field": "height", "turned_by": "q"}}, "turned_by needs the field of a message that"),
    ({**SIDED, "heave": {"field": "x", "sign": "s"}}, "sign must give a field and its negative words"),
    ({**SIDED, "heave": {"field": "x", "sign": {"field": "s", "negative": []}}}, "negative must list the words"),
    ({**SIDED, "heave": {"field": "x", "sign": {"field": "y", "negative": ["P"]}}}, "unknown entry y; known: s, x"),
    ({"payout": TOPIC, "command": {}}, "either a line, a layout, or a topic"),
    ({"payout": TOPIC, "command": {"line": "{speed}"}}, "{speed} is unknown; known: payout, payout_rate"),
    ({"payout": TOPIC, "command": {"line": "{payout:s}"}}, "command: line: "),
    ({"payout": TOPIC, "command": {"topic": "/c"}}, "topic needs its type"),
    ({"payout": TOPIC, "command": {"topic": "/c", "type": "t", "set": {"x": "speed"}}}, "quantity = 'speed'"),
    ({"payout": TOPIC, "command": {"line": "x", "timeout": 9}}, "timeout = 9 must be"),
]


@pytest.mark.parametrize(("content", "words"), REFUSED, ids=[words for _, words in REFUSED])
def test_what_cannot_be_is_refused_in_one_line(content, words):
    with pytest.raises(MapError, match=words) as caught:
        device_map_of("m", content)
    assert "\n" not in str(caught.value)


def test_a_file_is_named_with_what_is_wrong_in_it(tmp_path):
    path = tmp_path / "map.yaml"
    path.write_text("heave: {topic: /t}\nheave: {topic: /t}\n")
    with pytest.raises(MapError, match=r"map\.yaml: cannot be read as a mapping: heave appears twice"):
        read_device_map(path)
    with pytest.raises(MapError, match=r"none\.yaml"):
        read_device_map(tmp_path / "none.yaml")


def test_a_command_becomes_a_line_with_its_checksum():
    line = '{line: "$W,{sequence},{payout_rate:.2f},{brake}", checksum: xor}'
    text = f"payout: {{topic: /t, type: t, field: x}}\ncommand: {line}"
    command = device_map_of("m", parse_yaml(text)).command
    values = {"sequence": 7, "payout": 0.0, "payout_rate": 0.5, "brake": 1}
    expected = 0
    for letter in b"W,7,0.50,1":
        expected ^= letter
    assert command.line_of(values) == f"$W,7,0.50,1*{expected:02X}\r\n".encode()


def test_what_is_set_in_a_message_is_in_the_unit_and_sign_of_its_taker():
    entry = {"data[0]": {"quantity": "payout_rate", "unit": "m/min", "positive": "in"}}
    content = {"payout": TOPIC, "command": {"topic": "/c", "type": "t", "set": entry}}
    assert device_map_of("m", content).command.orders[0].factor == pytest.approx(-60.0)


NAMES = [
    *("heave", "payout", "tension", "source", "format", "pattern", "command", "lever_arm", "clock", "udp", "serial"),
    *("baud", "line", "set", "to", "topic", "type", "field", "valid", "valid_values", "quantity", "rate"),
    *("time_column", "frame", "checksum", "boom_tip", "timeout", "unit", "positive", "invalid_bits"),
]
VALUES = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8), st.just("PSXN23.heave")),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.sampled_from(NAMES), inner, max_size=4)),
    max_leaves=8,
)


@given(st.dictionaries(st.sampled_from(NAMES), VALUES, max_size=6), st.booleans())
def test_whatever_a_map_holds_it_is_read_or_refused_in_one_line(content, is_psxn):
    try:
        device_map_of("m", {**content, "format": "nmea", "heave": "PSXN23.heave"} if is_psxn else content)
    except MapError as error:
        assert "\n" not in str(error)
