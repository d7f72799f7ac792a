"""The node as a process in a whole run, and an operator who asks things of it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy")
pytest.importorskip("heave_msgs")
domain_coordinator = pytest.importorskip("domain_coordinator")

OPERATOR = Path(__file__).with_name("operator_program.py")


@pytest.mark.slow
def test_an_operator_changes_modes_redesigns_moves_and_stops(tmp_path):
    """B2: 300 m of cable, the boom tip at still water and a little stretch: depths asked for lie a few metres below."""
    run_command = [sys.executable, "-m", "heave_bringup.cli", "run", "b2_calm_300", "--duration", "1200", "--no-report"]
    with domain_coordinator.domain_id() as domain:
        environment = {**os.environ, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        with (tmp_path / "run.txt").open("w") as log:
            run = subprocess.Popen(
                [*run_command, "--bag", str(tmp_path / "run")], env=environment, stdout=log, stderr=log
            )
        try:
            operator = subprocess.run(
                [sys.executable, str(OPERATOR), "303.0"],
                env=environment,
                capture_output=True,
                text=True,
                timeout=150.0,
                check=False,
            )
        finally:
            run.send_signal(signal.SIGINT)
            run.wait(timeout=60.0)
    assert operator.returncode == 0, operator.stderr + (tmp_path / "run.txt").read_text()
    answers = json.loads(operator.stdout.strip().splitlines()[-1])
    assert answers["refused"][0] is False
    assert "'dance' cannot be requested" in answers["refused"][1]
    assert answers["redesigned"][0] is True
    assert 0.0 < answers["redesigned"][2] < 0.1
    assert answers["as_assumed"][0] is True
    assert answers["moved"][:2] == [True, "arrived"]
    assert answers["moved"][2] == pytest.approx(304.0, abs=0.05)
    assert len(answers["feedback"]) > 10
    assert max(abs(rate) for _, rate, _ in answers["feedback"]) <= 0.5
    assert answers["arrived"][2] == 0.0, "the last word of a move says that nothing is left to go"
    assert answers["too_deep"][0] is False
    assert "the winch reaches -49 to 49 m" in answers["too_deep"][1]
    assert answers["cancelled"][:2] == [False, "stopped smoothly"]
    assert answers["stopped"][0] is True
