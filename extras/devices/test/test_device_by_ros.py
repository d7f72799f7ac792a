"""A motion sensor that is a topic of a type of others, and a winch that is a program on UDP, beside `heave adapt`."""

import json
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from domain_coordinator import domain_id

from tests.loop_runs import adapting, environment, give
from tests.plc import free_port

ODOMETRY_MAP = """
heave: {topic: /boat/odometry, type: nav_msgs/msg/Odometry, field: pose.pose.position.z, positive: down}
heave_rate: {topic: /boat/odometry, type: nav_msgs/msg/Odometry, field: twist.twist.linear.z, positive: down}
roll: {topic: /boat/odometry, type: nav_msgs/msg/Odometry, field: pose.pose.orientation, part: roll}
boom_tip_height: 12.0
"""
WINCH_MAP = """
source: {{udp: {state}}}
format: line
pattern: 'P(?P<payout>[-0-9.]+) V(?P<rate>[-0-9.]+)'
payout: {{field: payout, unit: cm, zero_at_start: true}}
payout_rate: {{field: rate, unit: cm/s}}
command:
  to: {{udp: 127.0.0.1:{orders}}}
  line: "S{{payout_rate:.3f}} B{{brake}} N{{sequence}}"
  timeout: 0.4
"""
FELLOW = """
import json, sys, time
import rclpy
from heave_msgs.msg import MruSample, PointMotion, WinchCommand, WinchState
from heave_node.ros.transport.environment import prepare_environment
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock

prepare_environment()
rclpy.init()
node = rclpy.create_node("fellow")
found = {"mru": [], "tip": [], "state": []}
node.create_subscription(MruSample, "mru", lambda m: found["mru"].append([m.heave, m.heave_rate, m.status]), 50)
node.create_subscription(PointMotion, "boom_tip", lambda m: found["tip"].append([m.position.z, m.velocity.z]), 50)
node.create_subscription(
    WinchState, "winch/state",
    lambda m: found["state"].append([m.encoder_payout, m.brake, m.fault, m.command_sequence, m.release]), 50
)
odometry = node.create_publisher(Odometry, "/boat/odometry", 10)
commands = node.create_publisher(WinchCommand, "winch/command", 10)
clock = node.create_publisher(Clock, "clock", 10)
while not (commands.get_subscription_count() and odometry.get_subscription_count()):
    rclpy.spin_once(node, timeout_sec=0.1)
began = time.monotonic()
sequence, has_moved, found["sent"] = 0, False, []
while not has_moved or found["state"][-1][1:3] != [True, 1]:  # it moves by 0.5 m, then there is silence
    t = time.monotonic() - began
    assert t < 60.0, found["state"][-1:]
    message = Odometry()
    message.pose.pose.position.z, message.twist.twist.linear.z = -t / 16.0, -1.0 / 16.0
    message.pose.pose.orientation.w = 1.0
    odometry.publish(message)
    found["sent"].append(t / 16.0)
    tick = Clock()
    tick.clock.sec = int(t)
    tick.clock.nanosec = int(t % 1.0 * 1e9)
    clock.publish(tick)
    state = found["state"][-1] if found["state"] else [0.0] * 5
    has_moved = has_moved or state[0] > 0.5
    if not has_moved:
        sequence += 1
        commands.publish(WinchCommand(sequence=sequence, payout_rate=0.2, brake=state[4] == 1))
    until = began + t + 0.05
    while time.monotonic() < until:
        rclpy.spin_once(node, timeout_sec=0.005)
found["commands"] = sequence
print(json.dumps(found))
"""


class Drive(threading.Thread):
    """A winch in centimetres on UDP: it follows its speed order, and reports where it is."""

    def __init__(self, orders: int, state: int) -> None:
        super().__init__(daemon=True)
        self.heard: list[str] = []
        self.ended = threading.Event()
        self._state = ("127.0.0.1", state)
        self._line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._line.bind(("127.0.0.1", orders))
        self._line.settimeout(0.05)

    def run(self) -> None:
        payout, speed, last = 34_500.0, 0.0, time.monotonic()
        while not self.ended.is_set():
            try:
                text = self._line.recv(200).decode()
                self.heard.append(text.strip())
                speed = 0.0 if " B1 " in text else 100.0 * float(text[1:].split()[0])
            except TimeoutError:
                pass
            now = time.monotonic()
            payout, last = payout + speed * (now - last), now
            self._line.sendto(f"P{payout:.2f} V{speed:.2f}\r\n".encode(), self._state)
        self._line.close()


@contextmanager
def running(drive: Drive) -> Iterator[None]:
    drive.start()
    try:
        yield
    finally:
        drive.ended.set()
        drive.join()


@pytest.mark.slow
def test_a_topic_of_another_type_and_a_drive_on_udp_take_part(tmp_path):
    orders, state = free_port("udp"), free_port("udp")
    drive = Drive(orders, state)
    (tmp_path / "boat.yaml").write_text(ODOMETRY_MAP)
    (tmp_path / "drive.yaml").write_text(WINCH_MAP.format(orders=orders, state=state))
    maps = [str(tmp_path / name) for name in ("boat.yaml", "drive.yaml")]
    with (
        domain_id() as domain,
        running(drive),
        adapting(domain, *maps, "--json", str(tmp_path / "adapter.json")) as ended,
    ):
        fellow = subprocess.run(
            [sys.executable, "-c", FELLOW],
            env=environment(domain),
            capture_output=True,
            text=True,
            timeout=90.0,
            check=False,
        )
    (adapter,) = ended
    assert fellow.returncode == 0, fellow.stderr + adapter.err
    assert adapter.returncode == 0, adapter.err
    found = json.loads(fellow.stdout)
    heave, rate, status = found["mru"][-1]
    assert (rate, status) == (1.0 / 16.0, 0)
    assert heave in found["sent"], "positive down there is positive up here"
    height, velocity = found["tip"][-1]
    assert height == pytest.approx(12.0 + found["sent"][-1], abs=0.1)
    assert velocity == pytest.approx(1.0 / 16.0, abs=0.01)
    payouts = [entry[0] for entry in found["state"]]
    assert 0.0 <= payouts[0] < 0.2, (
        "the first reading, 345 m of the drive's own, counts as zero; a second may go unheard"
    )
    assert 0.5 < max(payouts) < 1.3, "from centimetres to metres"
    assert any(text.startswith("S0.200 B0") for text in drive.heard)
    assert any(text.startswith("S0.000 B1") for text in drive.heard), "without commands it is told to stop and brake"
    assert found["state"][-1][1:3] == [True, 1], "brake, and FAULT_COMMAND_TIMEOUT"
    assert found["state"][-1][4] == 1, "RELEASE_BRAKE_REQUEST"
    figures = json.loads((tmp_path / "adapter.json").read_text())
    assert figures["drive"]["commands_sent"] >= 0.8 * found["commands"]


@pytest.mark.slow
def test_a_drive_without_brake_or_watchdog_keeps_the_contract_behind_its_map(tmp_path):
    orders, state = free_port("udp"), free_port("udp")
    drive = Drive(orders, state)
    (tmp_path / "drive.yaml").write_text(WINCH_MAP.format(orders=orders, state=state))
    with domain_id() as domain, running(drive), adapting(domain, str(tmp_path / "drive.yaml")) as ended:
        check = give(domain, "check", "--replace", "virtual_winch=external", timeout=90.0)
    assert check.returncode == 0, check.stdout + check.stderr + ended[0].err
    assert "the contract is kept" in check.stdout
