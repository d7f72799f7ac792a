"""Who can reach a run: nobody beyond this machine by default, every host of the subnet with --network.

Each test has two hosts of its own (network namespaces); "this host" runs the suite, "the other" is a stranger with
plain rclpy.
"""

import sys
import threading
import time
from pathlib import Path

import pytest

from tests.hosts import Host, stop, two_hosts, why_not
from tests.loop_runs import command

UNABLE = why_not()
pytestmark = pytest.mark.skipif(bool(UNABLE), reason=UNABLE)

WINCH = (sys.executable, "-m", "cable_sim_node.winch_node")
"""A node without the `heave` command: what `ros2 run` and launch files start."""


@pytest.fixture
def hosts():
    with two_hosts() as pair:
        yield pair


@pytest.fixture
def started():
    """Processes that are killed at the end of the test, whatever comes."""
    processes = []
    yield processes
    stop(*processes)


STRANGER = """
import sys, time
import rclpy
from heave_msgs.msg import WinchState
from lifecycle_msgs.srv import GetState
wanted, seconds = sys.argv[1] == "matched", float(sys.argv[2])
rclpy.init()
node = rclpy.create_node("stranger")
heard = []
life = node.create_client(GetState, "virtual_winch/get_state")
state = node.create_subscription(WinchState, "winch/state", heard.append, 10)
end = time.monotonic() + seconds
def is_matched():
    return life.service_is_ready() and state.get_publisher_count() > 0
while time.monotonic() < end and not (wanted and is_matched()):
    rclpy.spin_once(node, timeout_sec=0.1)
names = sorted(name for name in node.get_node_names() if name != "stranger")
print(int(life.service_is_ready()), state.get_publisher_count(), len(heard), names)
"""


def stranger(host: Host, outcome: str, seconds: float, **environment: str) -> str:
    """Let a stranger look for the winch and return what it matched: the winch's service, publishers of its state,
    states heard, names of nodes. It looks for `seconds`, and no longer where it is to be `matched`.
    """
    process = host.start(sys.executable, "-c", STRANGER, outcome, str(seconds), environment=environment)
    out, err = process.communicate(timeout=seconds + 60.0)
    assert process.returncode == 0, err
    return out.strip()


FOUND = "1 1"
"""How what a stranger matched begins: the winch's service and its state."""


PROBE = """
import socket, sys
def refuses(port):
    probe = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    probe.settimeout(0.2)
    probe.connect((sys.argv[1], port))
    for _ in range(10):  # the kernel says only so many times a second that a port is closed
        try:
            probe.send(b"RTPS")
            probe.recv(1)
            return False
        except ConnectionRefusedError:
            return True
        except TimeoutError:
            pass
    return False
print(next((port for port in range(7400, 7650) if not refuses(port)), "none"))
"""


def port_that_answers(host: Host, address: str) -> str:
    """Ask the ports of ROS domain 0 at an address and return the first that the kernel there does not refuse."""
    process = host.start(sys.executable, "-c", PROBE, address)
    out, err = process.communicate(timeout=90.0)
    assert process.returncode == 0, err
    return out.strip()


def live_run(tmp_path: Path, *options: str) -> list[str]:
    options = ("--pacing", "realtime", "--duration", "10000", "--bag", str(tmp_path / "run"), "--no-report", *options)
    return command("run", "b2_calm_300", *options)


def test_by_default_no_port_of_a_run_answers_another_host_and_nothing_matches(hosts, started, tmp_path):
    this, other = hosts
    started.append(this.start(*live_run(tmp_path), environment={"ROS_STATIC_PEERS": other.address}))
    assert started[0].stderr.readline().startswith("heave: ROS_STATIC_PEERS is ignored: ")
    assert stranger(this, "matched", 60.0).startswith(FOUND), "it runs, and nodes of this host find it"
    assert port_that_answers(other, this.address) == "none"
    subnet = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "ROS_STATIC_PEERS": this.address}
    assert stranger(other, "nothing", 5.0, **subnet) == "0 0 0 []"


def test_opened_by_network_a_run_says_so_and_another_host_matches(hosts, started, tmp_path):
    this, other = hosts
    started.append(this.start(*live_run(tmp_path, "--network")))
    said = started[0].stderr.readline()
    assert said.startswith("heave: open to the network: any host of the subnet can join ROS domain 0")
    assert stranger(other, "matched", 60.0, ROS_AUTOMATIC_DISCOVERY_RANGE="SUBNET").startswith(FOUND)
    assert port_that_answers(other, this.address) == "7400", "the port of multicast discovery"


@pytest.mark.slow
@pytest.mark.long
def test_a_second_publisher_on_another_host_is_told_with_process_and_host(hosts, started, tmp_path):
    this, other = hosts
    subnet = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}
    run = this.start(*live_run(tmp_path, "--network"))
    started.append(run)
    started.append(other.start(sys.executable, "-c", STRANGER, "nothing", "120", environment=subnet))
    numbers = []
    for host in hosts:
        identity = host.start(sys.executable, "-m", "heave_node.ros.transport.identity", environment=subnet)
        numbers.append(identity.communicate(timeout=60.0)[0].split()[-1])
    assert numbers[0] != numbers[1]
    named = f"/stranger (process {started[1].pid & 0xFFFF} on another machine or container, DDS host {numbers[1]})"
    patience = threading.Timer(100.0, run.kill)
    patience.start()
    line = next((line for line in run.stderr if "publishes on /winch/command" in line), "nobody was named")
    patience.cancel()
    assert named in line


def test_a_node_started_without_the_command_is_on_this_machine_alone_too(hosts, started):
    this, other = hosts
    asked = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_STATIC_PEERS": other.address}
    started.append(this.start(*WINCH, environment=asked))
    assert stranger(this, "matched", 30.0).startswith(FOUND), "it runs, and nodes of this host find it"
    assert port_that_answers(other, this.address) == "none"
    peer = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_STATIC_PEERS": this.address}
    assert stranger(other, "nothing", 3.0, **peer) == "0 0 0 []"


def test_a_node_started_without_the_command_is_opened_by_ros_own_variable_and_says_so(hosts, started):
    this, other = hosts
    started.append(this.start(*WINCH, environment={"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}))
    assert "open to the network" in started[0].stderr.readline()
    assert stranger(other, "matched", 30.0).startswith(FOUND)


@pytest.mark.parametrize("first", ["ours", "theirs"])
def test_ordinary_ros_nodes_of_this_host_match_whatever_their_range(hosts, started, first):
    this, _ = hosts
    if first == "ours":
        started.append(this.start(*WINCH))
        time.sleep(1.0)
    for asked in ("LOCALHOST", "SUBNET"):
        environment = {"ROS_AUTOMATIC_DISCOVERY_RANGE": asked}
        started.append(this.start(sys.executable, "-c", STRANGER, "matched", "30", environment=environment))
    theirs = started[-2:]
    if first == "theirs":
        time.sleep(1.0)
        started.append(this.start(*WINCH))
    for process in theirs:
        out, err = process.communicate(timeout=60.0)
        assert out.startswith(FOUND), err


def test_a_node_whose_profile_is_not_taken_does_not_start(hosts, started, tmp_path):
    this, _ = hosts
    # A prefix that looks like Fast DDS 2 makes the node choose what Fast DDS 3 does not read.
    (tmp_path / "share" / "fastrtps").mkdir(parents=True)
    started.append(this.start(*WINCH, environment={"AMENT_PREFIX_PATH": f"{tmp_path}:{sys.prefix}"}))
    _, err = started[0].communicate(timeout=60.0)
    assert started[0].returncode == 1
    assert err.splitlines()[-1].startswith("virtual_winch: other hosts can reach 0.0.0.0:7400, ")
