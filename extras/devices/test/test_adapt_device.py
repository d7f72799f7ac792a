"""A device in a run, with a node that only keeps what is published: ros2_control, both ways."""

import math
import os
import pty
import tty
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from builtin_interfaces.msg import Time
from heave_bringup.errors import CommandError
from heave_devices.adapt import device as device_module
from heave_devices.adapt import orders as orders_module
from heave_devices.adapt.device import LiveDevice
from heave_devices.adapt.plc import polled as polled_module
from heave_devices.adapt.report import figures_of, health_of, stale_words
from heave_devices.adapt.shipped import find_map
from heave_devices.formats.sample import Sample
from heave_devices.maps.device_map import device_map_of
from heave_msgs.msg import LoadCell, MruSample, WinchCommand
from heave_node.interface.codes import WinchFault
from heave_node.parameters import ParameterError
from heave_node.ros.diagnostics import Level
from rclpy.serialization import deserialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from extras.devices.test.test_adapt_links import wait_until
from tests.adapt_fakes import Node
from tests.plc import free_port


def joints(position, velocity=0.0, second=1):
    message = JointState(name=["slew", "drum"], position=[0.0, position], velocity=[0.0, velocity])
    message.header.stamp.sec = int(second)
    message.header.stamp.nanosec = round(second % 1.0 * 1e9)
    return message


def test_a_velocity_controller_gets_the_rate_in_turns_of_its_drum():
    node = Node()
    device = LiveDevice(find_map("ros2_control_velocity"), node)
    node.callbacks["/joint_states"](joints(690.0))
    node.callbacks["winch/command"](WinchCommand(sequence=1, payout_rate=0.3))
    (message,) = node.sent["/velocity_controller/commands"]
    assert list(message.data) == [pytest.approx(0.6)]
    node.callbacks["/joint_states"](joints(690.5, 0.6, second=2))
    state = node.sent["winch/state"][-1]
    assert (state.encoder_payout, state.encoder_payout_rate, state.command_sequence) == (0.25, pytest.approx(0.3), 1)
    assert not state.brake
    assert state.fault == 0
    device.close()
    assert list(node.sent["/velocity_controller/commands"][-1].data) == [0.0], "at the end it is told to stop"


EVERY_ORDER = """
payout: {topic: /joint_states, type: sensor_msgs/msg/JointState, field: 'position[name=drum]', unit: m}
command:
  topic: /orders
  type: std_msgs/msg/Float64MultiArray
  set:
    data[0]: payout
    data[1]: {quantity: payout_rate, unit: m/s, positive: in}
    data[2]: {quantity: mean_payout, unit: mm, positive: in}
    data[3]: brake
    data[4]: enable
    data[5]: sequence
"""
COMMAND = {"sequence": 2, "payout": 0.5, "payout_rate": 0.3, "brake": False, "mean_payout": 0.2}


@pytest.mark.parametrize(
    ("field", "value", "entries"),
    [
        ("sequence", 3, {5: 3.0}),
        ("payout", 0.6, {0: 0.6}),
        ("payout_rate", 0.4, {1: -0.4}),
        ("brake", True, {0: 0.0, 1: 0.0, 3: 1.0, 4: 0.0}),
        ("mean_payout", 0.1, {2: -100.0}),
    ],
)
def test_every_field_of_a_command_reaches_a_device_that_maps_it(field, value, entries):
    """Whatever the interface says of an order can be had: one changed field changes what belongs to it, and no more."""
    assert set(COMMAND) | {"header"} == set(WinchCommand.get_fields_and_field_types())

    def sent_for(command):
        node = Node()
        LiveDevice(device_map_of("every", yaml.safe_load(EVERY_ORDER)), node)
        node.callbacks["/joint_states"](joints(0.0))
        node.callbacks["winch/command"](WinchCommand(sequence=1, brake=True))
        node.callbacks["winch/command"](WinchCommand(**command))
        return list(node.sent["/orders"][-1].data)

    expected = dict(enumerate([0.5, -0.3, -200.0, 0.0, 1.0, 2.0]))
    assert dict(enumerate(sent_for(COMMAND))) == pytest.approx(expected)
    assert dict(enumerate(sent_for(COMMAND | {field: value}))) == pytest.approx(expected | entries)


def test_a_position_controller_is_told_where_in_its_own_count_and_stays_there_to_stop():
    node = Node()
    LiveDevice(find_map("ros2_control_position"), node)
    sent = node.sent["/position_controller/commands"]
    node.callbacks["winch/command"](WinchCommand(sequence=1, payout=0.0, brake=True))
    assert not sent, "before the drum has said where it is nothing is sent: 0 would be a jump"
    node.callbacks["/joint_states"](joints(690.0))
    node.callbacks["winch/command"](WinchCommand(sequence=2, payout=0.0, brake=True))
    assert list(sent[-1].data) == [690.0]
    node.callbacks["winch/command"](WinchCommand(sequence=3, payout=0.5))
    assert list(sent[-1].data) == [691.0]
    node.callbacks["/joint_states"](joints(690.8))
    node.callbacks["winch/command"](WinchCommand(sequence=4, payout=9.0, brake=True))
    assert list(sent[-1].data) == [pytest.approx(690.8)], "it stays where it is"


@pytest.fixture
def clock(monkeypatch):
    """Return the wall clock of a device, which the test sets [s]."""
    wall = SimpleNamespace(now=100.0, monotonic=lambda: wall.now)
    wall.time_ns = wall.monotonic_ns = lambda: round(wall.now * 1e9)
    for module in (device_module, orders_module):
        monkeypatch.setattr(module, "time", wall)
    return wall


class Controller:
    """Twenty commands a second to a device behind topics, or in the place of its link, by a `clock` of the test."""

    def __init__(self, device, node, clock):
        self.device, self.node, self.clock, self.number = device, node, clock, 0

    def command(self, rate=0.0, brake=False, seconds=0.05):
        for _ in range(round(20 * seconds)):
            self.number += 1
            self.node.callbacks["winch/command"](WinchCommand(sequence=self.number, payout_rate=rate, brake=brake))
            self.wait(0.05)

    def wait(self, seconds):
        for _ in range(round(20 * seconds)):
            self.clock.now += 0.05
            self.device.guard()

    @property
    def fault(self):
        return self.device.orders.handshake.fault


def moved_drum(clock):
    """Return a controller and the place of a drum [rad] that turns at 0.2 rad/s, as commanded."""
    node = Node()
    controller = Controller(LiveDevice(find_map("ros2_control_velocity"), node), node, clock)
    place = 690.0
    for _ in range(10):
        place += 0.01
        node.callbacks["/joint_states"](joints(place, 0.2, second=clock.now))
        controller.command(rate=0.1)
    assert not controller.fault
    return controller, place


def test_a_controller_that_restarts_counts_from_one_and_releases_the_winch_by_the_contract(clock):
    controller, place = moved_drum(clock)
    node = controller.node
    controller.number = 1800
    controller.command(rate=0.1)
    controller.wait(0.6)
    controller.number = 0
    node.callbacks["/joint_states"](joints(place, 0.0, second=clock.now))
    assert node.sent["winch/state"][-1].brake
    controller.command(brake=True)
    controller.command(rate=0.1)
    assert list(node.sent["/velocity_controller/commands"][-1].data) == [pytest.approx(0.2)]


def test_a_message_on_the_clock_releases_no_fault_that_is_latched(clock):
    """The clock moves the simulated boom tip alone; what a stranger sends on it is not a new run."""
    topic = {"topic": "/joint_states", "type": "sensor_msgs/msg/JointState"}
    drum = {"payout": {**topic, "field": "position[name=drum]"}, "heave": {**topic, "field": "position[name=slew]"}}
    command = {"topic": "/c", "type": "std_msgs/msg/Float64", "set": {"data": "payout_rate"}}
    node = Node()
    controller = Controller(LiveDevice(device_map_of("m", {**drum, "command": command}), node), node, clock)
    node.callbacks["/joint_states"](joints(1.0, second=clock.now))
    controller.command(rate=0.1, seconds=0.3)
    controller.device.orders.handshake.latch.trip(WinchFault.DRIVE, "the drive reports a trip")
    for second in (90, 0, 91):
        node.callbacks["clock"](Clock(clock=Time(sec=second)))
        controller.number += 1
        node.callbacks["winch/command"](WinchCommand(sequence=controller.number, payout_rate=0.1))
        assert node.sent["/c"][-1].data == 0.0
    assert controller.fault == WinchFault.DRIVE
    assert controller.device.problem == "stopped: the drive reports a trip"


@pytest.mark.parametrize("stamps", ["receipt", "own"])
def test_a_latency_of_the_map_is_taken_off_the_stamps(clock, stamps):
    """A load cell whose filter is 40 ms late; the run is at 8 s when the wall clock shows 100 s."""
    node = Node()
    entry = {"topic": "/force", "type": "sensor_msgs/msg/JointState", "field": "position[0]"}
    device = LiveDevice(device_map_of("m", {"tension": entry, "clock": stamps, "latency": 0.04}), node)
    node.callbacks["/force"](joints(1.0, second=1_700_000_000.0))
    assert not node.sent["winch/load_cell"], "no run has a time yet"
    for _ in range(40):
        clock.now += 0.05
        seconds, nanoseconds = divmod(round((clock.now - 92.0) * 1e9), 10**9)
        node.callbacks["clock"](Clock(clock=Time(sec=seconds, nanosec=nanoseconds)))
        node.callbacks["/force"](joints(1.0, second=1_700_000_000.0 + clock.now))
    cell = deserialize_message(node.sent["winch/load_cell"][-1], LoadCell)
    assert cell.header.stamp.sec + 1e-9 * cell.header.stamp.nanosec == pytest.approx(clock.now - 92.0 - 0.04, abs=1e-3)
    assert device.problem == ""


def test_a_plc_that_was_away_and_counts_from_nought_is_a_fault_of_the_drive_and_stays_it(clock):
    """The timeout of its silence, which a controller releases by itself, does not hide the count that was lost."""
    controller, _ = moved_drum(clock)
    controller.command(rate=0.1, seconds=3.0)
    assert controller.fault == WinchFault.COMMAND_TIMEOUT
    controller.node.callbacks["/joint_states"](joints(0.0, second=clock.now))
    controller.command(rate=0.1)
    assert controller.fault == WinchFault.DRIVE
    controller.command(brake=True)
    assert "the drum's count jumped by -34" in controller.device.problem, "its words stay until it is released"
    assert controller.node.sent["winch/state"][-1].encoder_payout == pytest.approx(9 * 0.005)


def test_a_winch_that_is_silent_is_not_released_before_it_speaks_again(clock):
    controller, place = moved_drum(clock)
    controller.command(rate=0.1, seconds=2.0)
    controller.command(brake=True, seconds=0.2)
    controller.command(rate=0.1, seconds=0.2)
    assert controller.fault == WinchFault.COMMAND_TIMEOUT
    controller.node.callbacks["/joint_states"](joints(place, 0.0, second=clock.now))
    controller.command(brake=True)
    controller.command(rate=0.1)
    assert not controller.fault


def test_the_winch_is_told_nothing_before_the_first_command_nor_between_two_until_they_have_ended(clock):
    node = Node()
    device = LiveDevice(find_map("ros2_control_velocity"), node)
    controller, sent = Controller(device, node, clock), "/velocity_controller/commands"
    node.callbacks["/joint_states"](joints(690.0, second=clock.now))
    controller.wait(2.0)
    assert not node.sent.get(sent)
    node.callbacks["/joint_states"](joints(690.0, second=clock.now))
    given = clock.now
    controller.command(rate=0.1)
    controller.wait(0.2)
    assert len(node.sent[sent]) == 1
    clock.now = given + 0.5  # the timeout of a map that says none, to the last bit
    device.guard()
    assert len(node.sent[sent]) == 2


def test_a_drum_that_somebody_else_moves_before_the_first_command_is_no_fault(clock):
    node = Node()
    controller, place = Controller(LiveDevice(find_map("ros2_control_velocity"), node), node, clock), 690.0
    for speed in (*[0.0] * 40, *[0.2] * 60):
        place += 0.05 * speed
        node.callbacks["/joint_states"](joints(place, speed, second=clock.now))
        controller.wait(0.05)
    assert not controller.fault


def test_a_drum_of_which_only_the_speed_is_known_is_not_supervised_by_its_way(clock):
    node = Node()
    controller = Controller(LiveDevice(find_map("ros2_control_velocity"), node), node, clock)
    for _ in range(4):
        node.callbacks["/joint_states"](joints(math.nan, 0.2, second=clock.now))
        controller.command(rate=0.1)
    assert controller.fault != WinchFault.DRIVE


def test_registers_of_a_drum_that_stand_still_while_it_moves_hold_it_and_are_no_good_health(clock):
    """Position and speed as at one moment at sea, the counter going on."""
    controller, place = moved_drum(clock)
    while not controller.fault:
        controller.node.callbacks["/joint_states"](joints(place, 0.2, second=clock.now))
        controller.command(rate=0.1)
        assert clock.now < 102.0
    assert "payout and payout_rate contradict each other: +0." in health_of(controller.device, {}).message
    assert controller.fault == WinchFault.DRIVE


class StandingExchange:
    """A PLC that takes no order."""

    def open(self):
        """See Exchange."""

    def close(self):
        """See Exchange."""


@pytest.mark.parametrize("timeout", [0.3, 0.5])
def test_orders_that_do_not_reach_the_plc_hold_the_winch(clock, monkeypatch, timeout):
    """What it says still comes, so that the age of a reading shows nothing; its thread hangs in an order."""
    monkeypatch.setattr(device_module, "exchange_of", lambda _: StandingExchange())
    monkeypatch.setattr(polled_module, "time", clock)
    node = Node()
    content = {
        "source": {"modbus": "127.0.0.1:502"},
        "payout": "input:0",
        "command": {"timeout": timeout, "set": {"holding:0:int16": "payout_rate"}},
    }
    device = LiveDevice(device_map_of("m", content), node)
    controller = Controller(device, node, clock)
    began = clock.now
    while not controller.fault:
        device._on_sample(Sample("MODBUS", {"input:0": 5.0}))
        controller.command(rate=0.04)
        assert clock.now - began < 2.0
    assert controller.fault == WinchFault.COMMAND_TIMEOUT
    assert clock.now - began == pytest.approx(timeout + 0.05, abs=0.051)
    device._on_sample(Sample("MODBUS", {"input:0": 5.0}))
    controller.command(brake=True)
    controller.command(rate=0.04)
    assert controller.fault, "an order that is still on its way releases nothing"


def test_an_order_that_fits_no_datagram_holds_the_winch(clock):
    node = Node()
    content = {
        "payout": {"topic": "/joint_states", "type": "sensor_msgs/msg/JointState", "field": "position[name=drum]"},
        "command": {
            "to": {"udp": "127.0.0.1:9"},
            "layout": {"speed": "int16"},
            "set": {"speed": {"quantity": "payout_rate", "scale": 1e6}},
        },
    }
    controller = Controller(LiveDevice(device_map_of("m", content), node), node, clock)
    for _ in range(20):
        node.callbacks["/joint_states"](joints(1.0, second=clock.now))
        controller.command(rate=0.04)
    assert controller.fault == WinchFault.COMMAND_TIMEOUT
    assert "speed: 40000 does not fit int16" in controller.device.problem


def test_a_serial_line_of_sentences_becomes_mru(tmp_path):
    terminal, name = pty.openpty()
    tty.setraw(name)
    content = {
        "source": {"serial": os.ttyname(name), "baud": 19200},
        "format": "nmea",
        "heave": {"field": "PASHR.heave", "positive": "down"},
        "clock": "own",
    }
    node = Node()
    device = LiveDevice(device_map_of("m", content), node)
    device.start()
    line = b"$PASHR,123816.80,312.95,T,-000.83,-000.42,-000.01,0.234,0.224,0.298,1,0*09\r\n"  # SBG Systems' example
    for piece in (line[:20], line[20:], line.replace(b"-000.01", b"-000.02")):
        os.write(terminal, piece)
    wait_until(lambda: device.counters.checksum_errors == 1)
    (message,) = [deserialize_message(data, MruSample) for data in node.sent["mru"]]
    assert (message.heave, message.status, message.sequence) == (0.01, MruSample.STATUS_OK, 1)
    assert math.isnan(message.heave_rate), "PASHR has none"
    assert message.header.stamp.sec == 12 * 3600 + 38 * 60 + 16
    os.close(terminal)
    wait_until(lambda: device.problem)
    assert "serial" in health_of(device, {}).message
    device.close()
    os.close(name)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "nothing received. Check power, cable"),
        (b"$PASHR,123816.80,312.95,T,-000.83,-000.42,-000.01,0.234,0.224,0.298,1,0*00\r\n", "1 wrong checksums"),
        (b"$PASHR,123816.70,312.95,T,-000.83,-000.42,-000.01,0.234,0.224,0.298,1,0*06\r\n", "its own time goes back"),
        (b"$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n", "lacks the map's fields"),
    ],
)
def test_a_silence_is_put_down_to_what_comes_now_and_not_to_what_came_once(data, words, clock):
    node, line = Node(), b"$PASHR,123816.80,312.95,T,-000.83,-000.42,-000.01,0.234,0.224,0.298,1,0*09\r\n"
    source, heave = {"udp": free_port("udp")}, {"field": "PASHR.heave", "positive": "down"}
    device = LiveDevice(device_map_of("m", {"source": source, "format": "nmea", "heave": heave}), node)
    device._on_bytes(line, True)
    assert node.sent["mru"]
    before = figures_of(device)
    clock.now += 5.0
    if data:
        device._on_bytes(data, True)
    assert words in stale_words(device, clock.now, before)


@pytest.mark.parametrize(
    ("sent", "entry", "words"),
    [
        (math.floor, {"unit": "s"}, "times too coarse +19"),
        (lambda t: round(1e3 * t), {"unit": "s"}, "runs 1e+03 times as fast as time passes: check unit and scale"),
        (lambda t: 17, {"unit": "s"}, "its own time stands still: check unit and scale of the map's device_time"),
        (lambda t: round(1e3 * t), {"unit": "ms"}, ""),
    ],
)
def test_a_time_that_is_none_or_too_coarse_is_named_and_no_sample_is_refused_for_it(
    sent, entry, words, clock, monkeypatch
):
    monkeypatch.setattr("heave_devices.adapt.report.time", clock)
    node, content = Node(), {"source": {"udp": free_port("udp")}, "format": "line", "pattern": "(?P<t>.+) (?P<z>.+)"}
    device = LiveDevice(device_map_of("m", content | {"device_time": {"field": "t"} | entry, "heave": "z"}), node)
    before = {}
    for k in range(300):
        before = figures_of(device) if k == 280 else before
        device._on_bytes(f"{sent(clock.now)} {math.sin(0.05 * k):.3f}\r\n".encode(), True)
        clock.now += 0.05
    stamps = [deserialize_message(data, MruSample).header.stamp for data in node.sent["mru"]]
    times = [stamp.sec + 1e-9 * stamp.nanosec for stamp in stamps]
    assert len(times) == 300
    assert min(np.diff(times)) > 0.0
    health = health_of(device, before)
    assert words in health.message if words else health.level is Level.OK
    device.close()


def test_a_field_that_the_command_does_not_have_is_refused_at_the_start():
    command = {"topic": "/c", "type": "std_msgs/msg/Float64", "set": {"datum": "payout_rate"}}
    payout = {"topic": "/j", "type": "sensor_msgs/msg/JointState", "field": "position[0]"}
    with pytest.raises(ParameterError, match="there is no field datum"):
        LiveDevice(device_map_of("m", {"payout": payout, "command": command}), Node())


def test_health_says_what_is_wrong_and_where_to_look():
    node = Node()
    device = LiveDevice(find_map("odometry"), node)
    assert health_of(device, {}).level is Level.STALE
    assert "nothing received. Check power, cable" in health_of(device, {}).message
    before = figures_of(device)
    node.callbacks["/odometry"](joints(1.0))
    health = health_of(device, before)
    assert health.level is Level.ERROR
    assert "there is no field pose.pose.position.z" in health.message


def test_a_type_that_is_not_installed_is_refused_with_what_to_do():
    with pytest.raises(CommandError, match="novatel_oem7_msgs/msg/INSPVA is not installed: build its package, source"):
        LiveDevice(find_map("novatel_inspva"), Node())


def test_an_mru_leaves_the_boom_tip_to_a_vessel_in_the_run():
    """As with `heave run --replace mru=external`, where a topic has one publisher."""
    node = Node()
    device = LiveDevice(
        device_map_of("mru", {"heave": {"topic": "/z", "type": "std_msgs/msg/Float64", "field": "data"}}), node
    )
    device.guard()
    node.others["boom_tip"] = "adapter_mru"  # that was killed
    device.guard()
    assert "boom_tip" in node.sent
    node.others["boom_tip"] = "wave_vessel"
    for _ in range(2):
        device.guard()
    assert "boom_tip" not in node.sent
    assert node.said == ["mru: another node moves the boom tip, this device does not"]
