"""A shell whose limits leave ROS no memory: each command that takes part in a run says so, and does not hang."""

from __future__ import annotations

import resource
import subprocess
import sys

import pytest
from heave_bringup.errors import ExitStatus

LIMIT = 700_000 << 10
"""`ulimit -v 700000`."""

COMMANDS = (
    ["run", "b2_calm_300", "--duration", "1"],
    ["record", "bag"],
    ["operate", "status"],
    ["view"],
    ["check", "--replace", "winch_controller=external"],
    ["adapt", "em3000"],
)


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_a_command_that_gets_too_little_memory_says_so_in_one_line(command, tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "heave_bringup.cli", *command],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        cwd=tmp_path,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (LIMIT, LIMIT)),
    )
    assert done.returncode == ExitStatus.FAILED
    (line,) = done.stderr.strip().splitlines()
    assert line.startswith("heave: this shell allows 0.7 GB of address space (ulimit -v)")
    assert not list(tmp_path.iterdir())
