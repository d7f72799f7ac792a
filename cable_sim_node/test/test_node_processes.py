"""The nodes cable_sim and virtual_winch alone, as processes: what cannot start is said in one line."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

pytest.importorskip("rclpy")
domain_coordinator = pytest.importorskip("domain_coordinator")


@pytest.mark.parametrize(
    ("module", "parameter", "status", "words"),
    [
        ("node", "unit.volume:=30.0", 1, "cable_sim: the line does not hang: the unit's buoyancy lifts"),
        (
            "winch_node",
            "speed_limit:=-2.0",
            2,
            "virtual_winch: command line: speed_limit = -2.0 is not allowed: it must be a number",
        ),
    ],
)
def test_a_node_that_cannot_start_ends_with_one_line(module: str, parameter: str, status: int, words: str) -> None:
    with domain_coordinator.domain_id() as domain:
        environment = {**os.environ, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        command = [sys.executable, "-m", f"cable_sim_node.{module}", "--ros-args", "-p", parameter]
        ended = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=60.0, check=False)
    assert ended.returncode == status
    assert ended.stderr.strip().splitlines()[-1].startswith(words)
    assert "Traceback" not in ended.stderr
