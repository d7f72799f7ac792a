"""Whichever node is killed in a run: one line that names it, an exit status that says so, and a bag that reads to its end."""

import os
import signal
import subprocess
import time
from pathlib import Path

import pytest
from domain_coordinator import domain_id
from heave_bags.reader import Bag

from tests.loop_runs import command, environment

NODES = ("cable_sim", "wave_vessel", "virtual_winch", "winch_controller", "recorder")


def process_of(node: str, folder: Path) -> int:
    """Return the process id of a node of the run in `folder`."""
    scenario = str((folder / "scenario.yaml").resolve())
    modules = {"virtual_winch": "cable_sim_node.winch_node", "recorder": "heave_bags.recorder_node"}
    module = modules.get(node, f"{node}_node.node")
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                arguments = (entry / "cmdline").read_bytes().decode().split("\0")
            except OSError:
                continue
            if scenario in arguments and module in arguments:
                return int(entry.name)
    raise AssertionError(f"{node} does not run")


def wait_for_data(bag: Path, size: int) -> None:
    deadline = time.monotonic() + 60.0
    while not any(file.stat().st_size > size for file in bag.glob("*.mcap")):
        assert time.monotonic() < deadline, "the run does not get going"
        time.sleep(0.1)


@pytest.mark.parametrize("node", NODES)
def test_a_killed_node_ends_the_run_with_its_name_and_a_bag_that_reads_to_the_end(node, tmp_path):
    folder = tmp_path / "run"
    with domain_id() as domain:
        run = subprocess.Popen(
            command("run", "b2_calm_300", "--duration", "100000", "--bag", str(folder), "--no-report"),
            env=environment(domain),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        try:
            wait_for_data(folder / "bag", 200_000)
            os.kill(process_of(node, folder), signal.SIGKILL)
            _, err = run.communicate(timeout=60.0)
        finally:
            run.kill()
    assert run.returncode == 1
    last = err.strip().splitlines()[-1]
    assert last.startswith(f"heave: {node} was killed by SIGKILL")
    assert "Traceback" not in err
    bag = Bag(folder / "bag")
    decoded = sum(1 for _ in bag.messages())
    assert decoded > 1000
