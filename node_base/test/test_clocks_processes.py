"""Hardware in the loop that stamps by simulated time, by a clock of its own, or not at all: each closes the loop."""

import signal
import subprocess
import sys

import pytest
from heave_node.interface.alarm import alarms_in

EXTERNAL_WINCH = """
import sys, time
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from heave_msgs.msg import WinchCommand, WinchState
from heave_node.interface import topics
from heave_node.ros.transport.environment import prepare_environment
from heave_node.ros.transport.qos import qos_of
prepare_environment()
rclpy.init()
node = rclpy.create_node("hardware")
state = node.create_publisher(WinchState, "winch/state", 10)
said = {}
def on_command(message):
    answer = WinchState(payout=1.0)
    if sys.argv[1] == "simulated":
        answer.header.stamp = message.header.stamp
    elif sys.argv[1] == "own":
        answer.header.stamp.sec, answer.header.stamp.nanosec = divmod(time.time_ns(), 1_000_000_000)
    state.publish(answer)
def on_diagnostics(message):
    said.update({part.name: part.message for part in message.status})
node.create_subscription(WinchCommand, "winch/command", on_command, 10)
node.create_subscription(DiagnosticArray, "/diagnostics", on_diagnostics, qos_of(topics.DIAGNOSTICS.role))
try:
    rclpy.spin(node)
except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    pass
print(said.get("cable_sim: clock of winch/state"))
"""


def run_with_winch(loop, stamps: str, **parameters: object) -> tuple[str, str]:
    """Run the loop with a winch of somebody else; return what the plant printed, and what it said of the clock."""
    hardware = subprocess.Popen(
        [sys.executable, "-c", EXTERNAL_WINCH, stamps], env=loop.environment, stdout=subprocess.PIPE, text=True
    )
    start = {"pacing": "realtime", "external": "[virtual_winch]", "strict": False, "start_timeout": 20.0}
    try:
        for name in ("cable_sim", "wave_vessel", "winch_controller"):
            loop.start(name, **start, duration=3.0, **parameters)
        status, out, err = loop.end("cable_sim")
    finally:
        hardware.send_signal(signal.SIGINT)
        said, _ = hardware.communicate(timeout=10.0)
    assert status == 0, err
    return out, said.strip()


@pytest.mark.parametrize(
    ("stamps", "words"),
    [("simulated", "simulated time; jitter "), ("own", "own clock: offset -"), ("none", "no stamp: time of arrival")],
)
def test_whatever_its_clock_every_reading_of_hardware_is_used(loop, stamps, words):
    out, said = run_with_winch(loop, stamps)
    assert float(out.split("sum=")[1].split()[0]) > 40.0, "one meter for each of 60 readings, but for a few"
    assert said.startswith(words)


def test_stamps_that_do_not_fit_the_declared_clock_are_an_error_in_words(loop):
    _, said = run_with_winch(loop, "own", external_clocks="['virtual_winch=simulated']")
    (alarm,) = alarms_in(said)
    assert alarm.code == "CLOCK_VIOLATION"
    assert " s ahead of simulated time" in alarm.text
