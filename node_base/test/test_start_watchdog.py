"""A start that never comes back ends with a line that names it."""

from __future__ import annotations

import signal
import subprocess
import sys

from heave_node.ros.transport.start_watchdog import watched_start

STUCK = """
import ctypes
from heave_node.ros.transport.start_watchdog import watched_start
with watched_start(1.0):
    ctypes.PyDLL(None).sleep(600)  # holds the interpreter, as the middleware does: no handler has a turn
"""


def test_a_start_that_hangs_is_ended_and_named():
    done = subprocess.run([sys.executable, "-c", STUCK], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == -signal.SIGKILL
    assert "heave: ROS failed to start: the middleware did not come back within 1 s" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_start_that_succeeds_or_fails_leaves_no_watchdog_behind():
    with watched_start(0.5):
        pass
    try:
        with watched_start(0.5):
            raise RuntimeError("as rclpy has it")
    except RuntimeError:
        pass
