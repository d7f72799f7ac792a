"""A fork is to whoever starts it what a new Python would be."""

from __future__ import annotations

import json
import signal
import subprocess
import sys

import psutil
import pytest

PARENT = """
import json, os, sys, threading
from pathlib import Path
from heave_node.ros.transport import forked
forked.LOADED_BEFORE = "json"
ENVIRONMENT = {**os.environ, "WORD": "given"}

def start(fork, *arguments):
    Path("log").touch()
    fork.run("wave_vessel", "child", *arguments, log=Path("log"), environment=ENVIRONMENT)
    return fork
"""

CHILD = """
import json, os, signal, sys, time
from pathlib import Path
def main():
    if sys.argv[1] == "exit":
        raise SystemExit(json.loads(sys.argv[2]))
    if sys.argv[1] == "fail":
        raise ValueError("a defect")
    if sys.argv[1] == "close":  # what the parent had open is open no more
        Path("open").write_text(json.dumps(sorted(map(int, os.listdir("/proc/self/fd")))))
    print(sys.argv[1], os.environ["WORD"], os.getsid(0) == os.getpid(), sys.modules["__main__"].__name__)
    print("said", file=sys.stderr)
    Path("number").write_text(str(os.getpid()))
    time.sleep(600.0 if sys.argv[1] == "stay" else 0.0)
"""


@pytest.fixture
def parent(tmp_path):
    """Return what runs a program that may start forks, and gives what it prints."""
    (tmp_path / "child.py").write_text(CHILD)

    def run(program):
        command = [sys.executable, "-c", PARENT + program]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120.0, check=False)
        assert not done.stderr
        return done.stdout

    return run


def test_a_fork_runs_a_program_as_a_new_python_would(parent, tmp_path):
    program = """
held = open("child.py"), os.pipe()
import atexit
atexit.register(print, "the parent ends")
print("of the parent", end=" ")
with forked.forks(1) as waiting:
    fork = start(waiting.pop(), "close")
    fork.wait()
print(fork.poll(), fork.returncode)
"""
    assert parent(program) == "of the parent 0 0\nthe parent ends\n"
    assert sorted((tmp_path / "log").read_text().splitlines()) == ["close given True child", "said"]
    assert len(json.loads((tmp_path / "open").read_text())) <= 4  # the folder itself


@pytest.mark.parametrize(
    ("arguments", "status", "words"),
    [
        (("exit", "3"), 3, ""),
        (("exit", "null"), 0, ""),
        (("exit", '"in words"'), 1, "in words"),
        (("fail",), 1, "ValueError: a defect"),
    ],
)
def test_a_fork_ends_with_the_status_of_its_program(parent, tmp_path, arguments, status, words):
    program = f"""
with forked.forks(1) as waiting:
    fork = start(waiting.pop(), *{arguments})
    fork.wait()
print(fork.poll())
"""
    assert parent(program) == f"{status}\n"
    assert (tmp_path / "log").read_text().rstrip().endswith(words)


def test_a_signal_that_ends_a_fork_is_seen_and_a_fork_that_is_not_needed_is_ended(parent):
    program = """
import signal
with forked.forks(3) as waiting:
    left = waiting[:2]
    fork = start(waiting.pop(), "stay")
    while not Path("number").exists():
        assert fork.poll() is None
    fork.send_signal(signal.SIGTERM)
    fork.wait()
    fork.kill()  # nobody, by now
print(fork.returncode, [one.returncode for one in left])
"""
    assert parent(program) == f"{-signal.SIGTERM} {[-signal.SIGKILL] * 2}\n"


@pytest.mark.parametrize("length", [0, 4000])
def test_a_fork_appears_under_its_own_command_and_ends_with_its_parent(parent, tmp_path, length):
    """Whether the command is longer than that of the parent or not."""
    (tmp_path / "child.py").write_text(CHILD)
    program = """
with forked.forks(1) as waiting:
    start(waiting.pop(), "stay", "--params-file", "b2.yaml").wait()
"""
    command = [sys.executable, "-c", PARENT + program, "x" * length]
    starter = subprocess.Popen(command, cwd=tmp_path)
    try:
        number = tmp_path / "number"
        while not (number.exists() and number.read_text()):
            assert starter.poll() is None
        child = psutil.Process(int(number.read_text()))
        assert child.name() == "wave_vessel"
        words = [word for word in child.cmdline() if word]
        assert words == [
            *(sys.executable, "-m", "heave_node.ros.transport.parents_death"),
            *("child", "stay", "--params-file", "b2.yaml"),
        ]
    finally:
        starter.kill()
        starter.wait()
    psutil.wait_procs([child], timeout=60.0)
    assert not child.is_running()


@pytest.mark.parametrize("why", ["import rclpy", "threading.Thread(target=threading.Event().wait).start()"])
def test_a_process_with_ros_or_with_threads_is_not_forked(parent, why):
    program = f"{why}\nwith forked.forks(2) as waiting:\n    print(waiting, flush=True)\nos._exit(0)"
    assert parent(program) == "[]\n"


def test_where_the_system_allows_no_more_processes_there_are_fewer_forks_and_signals_come_as_before(parent):
    program = """
import signal
fork, made = os.fork, []
def limited():
    if made:
        raise BlockingIOError(11, "Resource temporarily unavailable")
    made.append(fork())
    return made[0]
os.fork = limited
with forked.forks(3) as waiting:
    print(len(waiting), signal.pthread_sigmask(signal.SIG_BLOCK, ()))
"""
    assert parent(program) == "1 set()\n"
