"""Quality of service at the start barrier: what matches is used, what cannot match is refused with topic and policy."""

import subprocess
import sys
import time

import pytest

EXTERNAL = """
import sys
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from heave_msgs.msg import WinchCommand, WinchState
from heave_node.ros.transport.environment import prepare_environment
from rclpy.qos import qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
prepare_environment()
rclpy.init()
node = rclpy.create_node("hardware")
kind, topic = {"winch": (WinchState, "winch/state"), "controller": (WinchCommand, "winch/command")}[sys.argv[1]]
publisher = node.create_publisher(kind, topic, 10 if sys.argv[2:] == ["reliable"] else qos_profile_sensor_data)
sequence = 0
def on_clock(message):
    global sequence
    sequence += 1
    answer = kind(payout=1.0)
    answer.header.stamp = message.clock
    publisher.publish(answer)
    if sequence == 10:
        print("the run has begun", flush=True)
def on_diagnostics(message):
    for part in message.status:
        if part.name == "cable_sim: external nodes":
            print(part.message, flush=True)
            sys.exit()
node.create_subscription(Clock, "/clock", on_clock, 10)
node.create_subscription(DiagnosticArray, "/diagnostics", on_diagnostics, 10)
node.create_timer(60.0, sys.exit)
try:
    rclpy.spin(node)
except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    pass
"""


@pytest.fixture
def external(loop):
    """Start a node of somebody else that publishes as sensors usually do: best effort, depth 5."""
    started = []

    def start(*kind: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-c", EXTERNAL, *kind]
        started.append(subprocess.Popen(command, env=loop.environment, stdout=subprocess.PIPE, text=True))
        return started[-1]

    yield start
    for process in started:
        process.kill()
        process.communicate()


def start_around(loop, node: str, **parameters: object) -> None:
    """Start all nodes but one, which is external."""
    start = {"pacing": "realtime", "external": f"[{node}]", "strict": False, "start_timeout": 20.0, **parameters}
    for name in {"cable_sim", "wave_vessel", "winch_controller", "virtual_winch"} - {node}:
        loop.start(name, **start)


def test_an_external_node_is_waited_for_and_its_readings_published_best_effort_are_taken(loop, external):
    start_around(loop, "virtual_winch")
    time.sleep(2.0)
    assert loop.processes["cable_sim"].poll() is None
    external("winch")
    status, out, err = loop.end("cable_sim")
    assert status == 0, err
    assert float(out.split("sum=")[1].split()[0]) > 20.0, "one meter per reading"


def test_commands_published_best_effort_are_refused_with_topic_and_policy(loop, external):
    external("controller")
    start_around(loop, "winch_controller")
    status, _, err = loop.end("cable_sim")
    assert status == 1
    assert (
        "/hardware and /virtual_winch do not match on /winch/command: Best effort publisher and reliable subscription"
    ) in err.splitlines()[-1]


def test_commands_that_become_best_effort_during_the_run_are_an_alarm_with_topic_and_policy(loop, external):
    first = external("controller", "reliable")
    start_around(loop, "winch_controller", duration=1e4)
    assert first.stdout.readline() == "the run has begun\n"
    first.kill()
    heard, _ = external("controller").communicate(timeout=40.0)
    assert "/hardware and /virtual_winch do not match on /winch/command: Best effort publisher" in heard


@pytest.mark.parametrize(
    ("override", "refusal"),
    [
        ({"qos_overrides./winch/state.publisher.reliability": "best_effort"}, "lockstep needs reliability: reliable"),
        (
            {"qos_overrides./winch/stat.publisher.depth": 7},
            "qos_overrides./winch/stat.publisher.depth: virtual_winch has no such publisher",
        ),
    ],
    ids=["in force", "of no topic"],
)
def test_a_quality_of_service_that_the_user_chose_is_in_force_or_refused(loop, override, refusal):
    loop.start("virtual_winch", **override)
    status, _, err = loop.end("virtual_winch")
    assert status == 1
    assert refusal in err.splitlines()[-1]
