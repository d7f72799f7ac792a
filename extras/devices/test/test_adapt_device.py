"""A device in a run, with a node that only keeps what is published: ros2_control, both ways."""

import math
import os
import pty
import time
import tty

import pytest
from builtin_interfaces.msg import Time
from heave_bringup.errors import CommandError
from heave_devices.adapt.device import LiveDevice
from heave_devices.adapt.report import figures_of, health_of
from heave_devices.adapt.shipped import find_map
from heave_devices.maps.device_map import device_map_of
from heave_msgs.msg import MruSample, WinchCommand
from heave_node.parameters import ParameterError
from heave_node.ros.diagnostics import Level
from rclpy.serialization import deserialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from tests.adapt_fakes import Node


def joints(position, velocity=0.0, second=1):
    message = JointState(name=["slew", "drum"], position=[0.0, position], velocity=[0.0, velocity])
    message.header.stamp.sec = second
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


def test_another_run_begins_with_its_brake_on_and_counts_from_one():
    node = Node()
    LiveDevice(find_map("ros2_control_velocity"), node)
    sent = node.sent["/velocity_controller/commands"]
    node.callbacks["/joint_states"](joints(0.0))
    node.callbacks["clock"](Clock(clock=Time(sec=90)))
    node.callbacks["winch/command"](WinchCommand(sequence=1800, payout_rate=0.3))
    node.callbacks["clock"](Clock(clock=Time(nanosec=50_000_000)))
    node.callbacks["/joint_states"](joints(0.0))
    assert node.sent["winch/state"][-1].brake
    node.callbacks["winch/command"](WinchCommand(sequence=1, payout_rate=0.1))
    assert list(sent[-1].data) == [pytest.approx(0.2)]


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


def wait_until(condition):
    deadline = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


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
