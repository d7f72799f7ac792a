"""The tick protocol with real processes over real DDS: the good case, and every way in which a participant can fail
it."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from domain_coordinator import domain_id

PROGRAM = Path(__file__).with_name("loop_program.py")
PEERS = ("wave_vessel", "winch_controller", "virtual_winch")
SUM_OF_40_TICKS = sum(range(1, 41))
"""The plant sums the sequence numbers of the sea, one per tick."""


class Loop:
    """Four processes in a domain of their own."""

    def __init__(self, domain: int) -> None:
        self.environment = {**os.environ, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        self.processes: dict[str, subprocess.Popen[str]] = {}

    def start(self, *names: str, **parameters: object) -> None:
        given = {"duration": 2.0, "participants": f"[{', '.join(PEERS)}]", **parameters}
        arguments = [part for name, value in given.items() for part in ("-p", f"{name}:={value}")]
        for name in names:
            self.processes[name] = subprocess.Popen(
                [sys.executable, str(PROGRAM), name, "--ros-args", *arguments],
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                env=self.environment,
            )

    def end(self, name: str, timeout: float = 40.0) -> tuple[int, str, str]:
        out, err = self.processes[name].communicate(timeout=timeout)
        return self.processes[name].returncode, out, err

    def stop(self) -> None:
        for process in self.processes.values():
            if process.poll() is None:
                process.kill()
                process.communicate()


@pytest.fixture
def loop():
    with domain_id() as domain:
        loop = Loop(domain)
        yield loop
        loop.stop()


def start_all(loop: Loop, fault_of: str = "", **parameters: object) -> None:
    """Start the four processes; the fault parameters go to one of them only."""
    faults = {name: parameters.pop(name) for name in ("fault", "fault_tick") if name in parameters}
    for name in (*PEERS, "cable_sim"):
        loop.start(name, **parameters, **(faults if name == fault_of else {}))


def test_every_node_has_exactly_the_messages_of_its_tick(loop):
    start_all(loop)
    status, out, _ = loop.end("cable_sim")
    assert status == 0
    assert f"ended=True ticks=41 epoch=1 sum={SUM_OF_40_TICKS}" in out
    assert [loop.end(name)[0] for name in PEERS] == [0, 0, 0]


def test_a_missing_participant_is_named_and_ends_the_start(loop):
    loop.start("cable_sim", "wave_vessel", "virtual_winch", start_timeout=3.0)
    status, _, err = loop.end("cable_sim")
    assert status == 1
    assert "winch_controller (not seen)" in err.splitlines()[-1]
    assert "has waited 1 s" in err, "a missing participant is named each second"


def test_a_participant_that_dies_is_named_and_ends_the_run(loop):
    start_all(loop, "winch_controller", fault="die", participant_timeout=2.0)
    status, _, err = loop.end("cable_sim")
    assert status == 1
    last = err.splitlines()[-1]
    assert "winch_controller has not finished tick 20" in last
    assert loop.end("wave_vessel")[0] == 0, "the others hear that the run is over"


def test_a_participant_that_raises_says_why_in_one_line(loop):
    start_all(loop, "virtual_winch", fault="raise", participant_timeout=2.0)
    status, _, err = loop.end("virtual_winch")
    assert status == 1
    assert err.splitlines()[-1] == "virtual_winch: the solver gave up at t = 1.000 s"


def test_a_participant_that_hangs_is_named(loop):
    start_all(loop, "wave_vessel", fault="hang", participant_timeout=2.0)
    status, _, err = loop.end("cable_sim")
    assert status == 1
    assert "wave_vessel has not finished tick 20" in err.splitlines()[-1]


def test_participants_leave_when_the_master_dies(loop):
    start_all(loop, "cable_sim", fault="die", participant_timeout=2.0)
    for name in PEERS:
        status, _, err = loop.end(name)
        assert status == 1
        assert "no message from the clock master for" in err


def test_lockstep_waits_for_a_late_participant_and_asks_again(loop):
    start_all(loop, "winch_controller", fault="late")
    status, out, _ = loop.end("cable_sim")
    assert status == 0
    assert f"sum={SUM_OF_40_TICKS}" in out
    assert "resends=0" not in out


def test_a_duplicated_message_is_dropped(loop):
    start_all(loop, "wave_vessel", fault="duplicate")
    status, out, _ = loop.end("cable_sim")
    assert status == 0
    assert f"sum={SUM_OF_40_TICKS}" in out


def test_a_lost_message_is_sent_again(loop):
    start_all(loop, "wave_vessel", fault="lose")
    status, out, _ = loop.end("cable_sim")
    assert status == 0
    assert f"sum={SUM_OF_40_TICKS}" in out
    assert "resends=0" not in out


def test_a_message_lost_for_ever_is_named_with_its_publisher(loop):
    start_all(loop, "wave_vessel", fault="lose_for_ever", participant_timeout=2.0)
    status, _, err = loop.end("cable_sim")
    assert status == 1
    assert "winch_controller has not finished tick 20 (waiting for /mru from wave_vessel (19 of 20 messages)" in err


@pytest.mark.parametrize("fault", ["future_stamp", "old_stamp"])
def test_a_wrong_stamp_is_refused(loop, fault):
    start_all(loop, "wave_vessel", fault=fault, strict=False)
    status, out, _ = loop.end("cable_sim")
    assert status == 0
    assert f"sum={SUM_OF_40_TICKS - 20 - 1}" in out, "the controller saw no sample of tick 20, and said so by -1"


def test_different_tick_periods_are_refused(loop):
    loop.start("wave_vessel", tick_period=0.1, participant_timeout=2.0)
    loop.start("winch_controller", "virtual_winch", "cable_sim", participant_timeout=2.0)
    status, _, err = loop.end("wave_vessel")
    assert status == 1
    assert "tick_period is 0.1 s here, but 0.05 s at the clock master" in err


def test_real_time_follows_the_wall_clock(loop):
    start_all(loop, pacing="realtime", duration=3.0, strict=False)
    began = time.monotonic()
    status, out, _ = loop.end("cable_sim")
    assert status == 0
    assert "ended=True ticks=61" in out
    assert time.monotonic() - began > 3.0, "sixty ticks of 0.05 s cannot be faster than the wall clock"


def test_real_time_does_not_wait_for_a_late_participant(loop):
    start_all(loop, "winch_controller", fault="late", pacing="realtime", strict=False)
    status, out, _ = loop.end("cable_sim")
    assert status == 0
    missed = int(out.split("missed=")[1].split()[0])
    assert missed >= 10, "0.8 s late at 20 Hz"


def test_an_external_node_is_waited_for_and_used_as_it_comes(loop):
    start = {"pacing": "realtime", "external": "[virtual_winch]", "strict": False, "start_timeout": 20.0}
    loop.start("cable_sim", "wave_vessel", "winch_controller", **start)
    time.sleep(2.0)
    assert loop.processes["cable_sim"].poll() is None
    winch = subprocess.Popen(
        [sys.executable, "-c", EXTERNAL_WINCH],
        env=loop.environment,
    )
    try:
        status, out, _ = loop.end("cable_sim")
    finally:
        winch.send_signal(signal.SIGINT)
        winch.wait(10.0)
    assert status == 0
    assert "ended=True" in out
    assert float(out.split("sum=")[1].split()[0]) > 0.0, "what the external winch said has reached the plant"


EXTERNAL_WINCH = """
import rclpy
from heave_msgs.msg import WinchCommand, WinchState
from heave_node.ros.environment import prepare_environment
prepare_environment()
rclpy.init()
node = rclpy.create_node("a_real_winch")
state = node.create_publisher(WinchState, "winch/state", 10)
heard = [0.0]
def on_command(message):
    heard[0] = message.payout
    answer = WinchState(payout=message.payout)
    answer.header.stamp = message.header.stamp
    state.publish(answer)
node.create_subscription(WinchCommand, "winch/command", on_command, 10)
try:
    rclpy.spin(node)
except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    pass
"""


def test_an_external_node_that_never_comes_is_named(loop):
    start = {"pacing": "realtime", "external": "[virtual_winch]", "start_timeout": 3.0}
    loop.start("cable_sim", "wave_vessel", "winch_controller", **start)
    status, _, err = loop.end("cable_sim")
    assert status == 1
    assert "a publisher of winch/state (external)" in err.splitlines()[-1]


def test_pause_step_reset_by_service(loop):
    start_all(loop, duration=1e4)
    client = subprocess.run(
        [sys.executable, "-c", PAUSE_STEP_RESET],
        env=loop.environment,
        capture_output=True,
        text=True,
        timeout=40,
        check=False,
    )
    assert client.returncode == 0, client.stderr
    paused, stepped, epoch, after_reset = (int(word) for word in client.stdout.split())
    assert stepped == paused + 5
    assert epoch == 2
    assert after_reset > 0
    loop.processes["cable_sim"].send_signal(signal.SIGINT)
    status, _, err = loop.end("cable_sim")
    assert status == 1
    assert "ended by SIGINT" in err
    assert loop.end("virtual_winch")[0] == 0, "the others hear that the run is over"


PAUSE_STEP_RESET = """
import time
import rclpy
from heave_msgs.msg import TickStatus
from heave_msgs.srv import StepSimulation
from heave_node import topics
from heave_node.ros.environment import prepare_environment
from heave_node.ros.qos import qos_of
from std_srvs.srv import SetBool, Trigger
prepare_environment()
rclpy.init()
node = rclpy.create_node("client")
seen = []
node.create_subscription(TickStatus, topics.TICK_STATUS.name, seen.append, qos_of(topics.TICK_STATUS.role))
def until(condition):
    end = time.monotonic() + 20
    while not (seen and condition(seen[-1])):
        rclpy.spin_once(node, timeout_sec=0.1)
        assert time.monotonic() < end, seen[-1:]
    return seen[-1]
def call(kind, name, request):
    client = node.create_client(kind, name)
    assert client.wait_for_service(10.0)
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future, timeout_sec=10.0)
    assert future.result().success, future.result()
until(lambda s: s.state == TickStatus.RUNNING and s.tick > 20)
call(SetBool, "simulation/pause", SetBool.Request(data=True))
paused = until(lambda s: s.state == TickStatus.PAUSED).tick
call(StepSimulation, "simulation/step", StepSimulation.Request(ticks=5))
stepped = until(lambda s: s.state == TickStatus.PAUSED and s.tick > paused).tick
call(Trigger, "simulation/reset", Trigger.Request())
again = until(lambda s: s.epoch == 2 and s.tick > 1)
print(paused, stepped, again.epoch, again.tick)
"""


def test_a_node_that_comes_into_a_run_under_way_says_so(loop):
    start_all(loop, duration=1e5)
    time.sleep(6.0)
    late = Loop(int(loop.environment["ROS_DOMAIN_ID"]))
    late.start("virtual_winch", duration=1e5)
    try:
        status, _, err = late.end("virtual_winch")
    finally:
        late.stop()
    assert status == 1
    assert "started too late: a run is already at tick" in err
