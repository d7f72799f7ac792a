"""How the launcher judges nodes by the way they end."""

import signal
import subprocess
import sys

import pytest
from heave_bringup.run import launcher
from heave_bringup.run.launcher import Launcher, NodeProcess

STUCK = """
import time
from heave_node.ros import process

class Node:
    has_joined = True
    def fail_on_error(self, work):
        work()
    def wait_until_heard(self):
        if "HELD" == "waiting":
            time.sleep(60.0)
    def destroy_node(self):
        time.sleep(60.0)

process.SHUTDOWN_TIMEOUT = 1
process.shut_down([Node()])
"""


def ended(tmp_path, name, program):
    log = tmp_path / f"{name}.log"
    with log.open("wb") as sink:
        process = subprocess.Popen([sys.executable, "-c", program], stdout=sink, stderr=subprocess.STDOUT)
    process.wait(timeout=30.0)
    return NodeProcess(name, process, log, [name])


@pytest.mark.parametrize("held", ["waiting", "destroyed"])
def test_a_node_that_the_middleware_does_not_let_go_has_left_and_holds_up_nobody(tmp_path, held):
    node = ended(tmp_path, "recorder", STUCK.replace("HELD", held))
    assert node.has_left
    assert not node.has_failed


def test_a_node_that_failed_has_failed_even_where_the_middleware_did_not_let_it_go(tmp_path):
    node = ended(tmp_path, "recorder", "print('recorder: the disk is full', flush=True)" + STUCK)
    assert node.has_failed
    assert node.how_it_ended() == "recorder: the disk is full"


@pytest.mark.parametrize(
    ("program", "words"),
    [
        ("import os, signal; os.kill(os.getpid(), signal.SIGKILL)", "wave_vessel was killed by SIGKILL"),
        ("print('wave_vessel: no such file'); raise SystemExit(1)", "wave_vessel: no such file"),
        ("print('half a word'); raise SystemExit(3)", "wave_vessel ended with exit status 3: half a word"),
        ("raise SystemExit(3)", "wave_vessel ended with exit status 3"),
    ],
)
def test_what_is_said_of_a_node_that_failed(tmp_path, program, words):
    node = ended(tmp_path, "wave_vessel", program)
    assert node.has_failed
    assert node.how_it_ended() == words


def test_a_node_under_way_is_named_until_it_ends(tmp_path):
    process = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60.0)"])
    nodes = Launcher()
    nodes.nodes.append(NodeProcess("virtual_winch", process, tmp_path / "log", ["virtual_winch"]))
    assert nodes.running() == ["virtual_winch"]
    assert nodes.failed() == []
    assert nodes.left() == []
    nodes.stop(grace=5.0)
    assert nodes.all_ended()


def test_a_node_that_has_files_to_close_is_given_more_time_than_the_others(tmp_path, monkeypatch):
    monkeypatch.setattr(launcher, "GRACE", 0.2)
    monkeypatch.setattr(launcher, "GRACE_OF_FILES", 60.0)
    program = (
        "import signal, sys, time; signal.signal(signal.SIGINT, lambda *_: (time.sleep(1.0), sys.exit()));"
        "print('on', flush=True); time.sleep(60.0)"
    )
    nodes = Launcher()
    for name in ("wave_vessel", "recorder"):
        process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE)
        process.stdout.read(2)
        nodes.nodes.append(NodeProcess(name, process, tmp_path / "log", [name]))
    nodes.stop()
    assert [node.process.poll() for node in nodes.nodes] == [-signal.SIGKILL, 0]


def test_the_nodes_of_a_run_are_forked(tmp_path):
    """Neither what it loads before nor its checks start a thread, or load ROS."""
    program = """
import sys
from heave_bringup import cli
from heave_node.ros.transport import forked
forked.Forked.__init__ = lambda self: print("forked", flush=True) or sys.exit()
sys.exit(cli.main(["run", "b2_calm_300"]))
"""
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.stdout == "forked\n"
