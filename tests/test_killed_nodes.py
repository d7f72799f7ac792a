"""Whichever node is killed in a run: one line that names it, an exit status that says so, and a bag that reads to its
end. Where the command itself is killed, no node outlives it."""

import os
import signal
import subprocess

import psutil
import pytest
from domain_coordinator import domain_id
from heave_bags.mcap.reader import Bag
from rosbags.highlevel import AnyReader

from tests.loop_runs import command, environment, process_of, under_way, wait_until

NODES = ("cable_sim", "wave_vessel", "virtual_winch", "winch_controller", "winch_adviser", "recorder")
OTHERS = ("wave_vessel", "virtual_winch", "winch_controller", "winch_adviser")
"""Nodes that are killed by `make validate` alone."""


@pytest.mark.parametrize(
    "node", [pytest.param(node, marks=pytest.mark.long) if node in OTHERS else node for node in NODES]
)
def test_a_killed_node_ends_the_run_with_its_name_and_a_bag_that_reads_to_the_end(node, tmp_path):
    folder = tmp_path / "run"
    arguments = ("run", "b2_calm_300", "--duration", "100000", "--bag", str(folder), "--no-report")
    with domain_id() as domain, under_way(domain, *arguments) as run:
        wait_until(lambda: any(f.stat().st_size > 200_000 for f in (folder / "bag").glob("*.mcap")), 240.0)
        os.kill(process_of(node, folder), signal.SIGKILL)
        _, err = run.communicate(timeout=120.0)
    assert run.returncode in (1, -signal.SIGKILL), "the watchdog ends a command that waits for a lock of the killed"
    last = err.strip().splitlines()[-1]
    assert last.startswith(f"heave: {node} was killed by SIGKILL")
    assert "Traceback" not in err
    bag = Bag(folder / "bag")
    read = sum(1 for _ in bag.messages())
    assert read > 1000
    with AnyReader([bag.path]) as reader:
        by_others = sum(1 for _ in reader.messages())
    assert by_others == read if node != "recorder" else by_others > 0, "a killed recorder leaves a journal besides"


@pytest.mark.long
@pytest.mark.parametrize("moment", ["in its start", "at work"])
@pytest.mark.parametrize("options", [[], ["--composed"]], ids=["processes", "composed"])
def test_no_node_outlives_a_command_that_was_killed(moment, options, tmp_path):
    folder = tmp_path / "run"
    nodes: list[psutil.Process] = []
    with domain_id() as domain:
        arguments = ("b2_calm_300", "--duration", "100000", "--bag", str(folder), "--no-report", *options)
        run = subprocess.Popen(command("run", *arguments), env=environment(domain), stderr=subprocess.DEVNULL)
        try:
            wait_until(lambda: len(psutil.Process(run.pid).children()) > 1, 240.0)  # a watchdog of the start is one
            if moment == "at work":
                wait_until(lambda: any(f.stat().st_size > 200_000 for f in (folder / "bag").glob("*.mcap")), 240.0)
            nodes = psutil.Process(run.pid).children(recursive=True)
        finally:
            run.kill()
            run.wait()
        assert len(nodes) > 0
        assert psutil.wait_procs(nodes, timeout=60.0)[1] == []
    if moment == "at work":  # they had the time to close it
        bag = Bag(folder / "bag")
        assert sum(1 for _ in bag.messages()) > 1000
        assert bag.losses == []
