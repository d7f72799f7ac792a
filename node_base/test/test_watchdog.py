"""A start or an end that never comes back ends with a line that names it; a start without memory is refused."""

from __future__ import annotations

import resource
import signal
import subprocess
import sys

import pytest
from heave_node.ros.transport.watchdog import LEAST_ADDRESS_SPACE, watched_start

NAMED = "heave: ROS failed to start: the middleware did not come back within 1 s"

STUCK = """
import ctypes
from heave_node.ros.transport.watchdog import watched_start
with watched_start(1.0):
    ctypes.PyDLL(None).sleep(600)  # holds the interpreter, as the middleware does: no handler has a turn
"""

STUCK_NODE = """
import ctypes
from heave_node.ros import process
from heave_node.ros.transport.watchdog import watched_start

process.watched_start = lambda: watched_start(1.0)

class Stuck:
    name = "cable_sim"
    def __init__(self):
        ctypes.PyDLL(None).sleep(600)

process.run_node(Stuck, [])
"""

STUCK_AFTER_CTRL_C = """
import ctypes, os, signal
from heave_node.ros.transport.watchdog import watched_start
os.setsid()  # a terminal of its own
signal.signal(signal.SIGINT, lambda *_: None)
with watched_start(1.0):
    os.killpg(0, signal.SIGINT)  # before the watchdog can ignore it
    ctypes.PyDLL(None).sleep(600)
"""

STUCK_AFTER_A_WHILE = """
import ctypes, subprocess, sys, time
from heave_node.ros.transport.watchdog import Watchdog
watchdog = Watchdog(2.0)
watchdog.end_too(subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"], stdout=1).pid)
for _ in range(8):
    time.sleep(0.5)
    watchdog.beat()
print("alive", flush=True)
ctypes.PyDLL(None).sleep(600)
"""

STUCK_AT_ITS_END = """
import ctypes, subprocess, sys
from heave_node.ros.transport.watchdog import Watchdog
watchdog = Watchdog(1.0)
node = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(4)"], stdout=1)
watchdog.end_too(node.pid)
watchdog.has_started()
watchdog.will_say("recorder was killed by SIGKILL")
ctypes.PyDLL(None).sleep(3)
print("lives while a node does", flush=True)
ctypes.PyDLL(None).sleep(600)
"""


def run(program: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=False)


@pytest.mark.parametrize("program", [STUCK, STUCK_NODE, STUCK_AFTER_CTRL_C], ids=["command", "node", "Ctrl-C"])
def test_a_start_that_hangs_is_ended_and_named(program):
    done = run(program)
    assert done.returncode == -signal.SIGKILL
    assert NAMED in done.stderr
    assert "Traceback" not in done.stderr


def test_a_start_of_several_steps_is_watched_to_its_end_and_the_processes_that_it_has_started_end_with_it():
    """Signs of life for twice the time; the child holds standard output open: the call returns once both have ended."""
    done = run(STUCK_AFTER_A_WHILE)
    assert done.returncode == -signal.SIGKILL
    assert done.stdout == "alive\n"
    assert "did not come back within 2 s" in done.stderr


def test_a_command_that_never_leaves_ros_ends_once_its_nodes_have_and_says_what_it_was_to_say():
    """By shared memory, Fast DDS waits for a lock that a killed process holds, where a publisher is removed."""
    done = run(STUCK_AT_ITS_END)
    assert done.returncode == -signal.SIGKILL
    assert done.stdout == "lives while a node does\n"
    assert done.stderr.strip() == "heave: recorder was killed by SIGKILL"


def test_a_start_that_succeeds_or_fails_leaves_no_watchdog_behind():
    with watched_start(0.5):
        pass
    with pytest.raises(RuntimeError, match="as rclpy has it"), watched_start(0.5):
        raise RuntimeError("as rclpy has it")


@pytest.mark.parametrize(("limit", "is_refused"), [(LEAST_ADDRESS_SPACE - 1024, True), (LEAST_ADDRESS_SPACE, False)])
def test_ros_is_not_started_where_the_shell_leaves_it_too_little_memory(limit, is_refused):
    program = """
from heave_node.ros.transport.environment import prepare_environment
try:
    prepare_environment()
except MemoryError as error:
    print(error)
"""
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, hard)),
    )
    assert done.stdout.startswith("this shell allows 2.7 GB of address space (ulimit -v)") is is_refused
