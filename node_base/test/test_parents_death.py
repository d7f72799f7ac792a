"""No node outlives what started it, whatever it is doing: importing, held up by the middleware, or at work."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import psutil
import pytest
from heave_node.ros.process import _ended_by_signals
from heave_node.ros.transport.parents_death import LAUNCHER_VARIABLE, launcher_of

PARENT = """
import os, subprocess, sys, time
from heave_node.ros.transport import parents_death
os.environ[parents_death.LAUNCHER_VARIABLE] = str(os.getpid())
python = sys.executable, "-m"  # as launch starts a node
subprocess.Popen(parents_death.command("child", sys.argv[1]) if sys.argv[2:] else [*python, "child", sys.argv[1]])
time.sleep(600)
"""

CHILD = """
import ctypes, os, pathlib, sys
from heave_node.ros.transport import parents_death

def go_on():
    pathlib.Path(sys.argv[1]).write_text(str(os.getpid()))
    ctypes.PyDLL(None).sleep(600)  # holds the interpreter, as the middleware does: no handler has a turn
"""
AT_WORK = """
import signal
parents_death.ASKED = signal.SIGHUP  # 1: so many seconds
parents_death.close_with(os.getppid())
"""

THREAD = """
import threading, time
threading.Thread(target=time.sleep, args=(600,)).start()
"""

NODE = """
import pathlib, sys, time
from heave_node.ros import process
from heave_node.ros.transport import parents_death

class Stuck:
    name = "cable_sim"
    def __init__(self):
        import ctypes, os
        pathlib.Path(sys.argv[1]).write_text(str(os.getpid()))
        ctypes.PyDLL(None).sleep(600)

process.run_node(Stuck, [])
"""


def wait_until(condition: Callable[[], bool], seconds: float = 120.0) -> None:
    """Wait until something is so; no test asserts how long it took."""
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "it did not come about"
        time.sleep(0.02)


def runs(process: int) -> bool:
    try:
        return psutil.Process(process).status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


@pytest.fixture
def started(tmp_path: Path) -> Iterator[Callable[..., tuple[subprocess.Popen[bytes], int]]]:
    """Return what starts a program by a parent of its own, and returns both once the program is held up."""
    processes: list[int] = []

    def start(program: str, *options: str) -> tuple[subprocess.Popen[bytes], int]:
        (tmp_path / "child.py").write_text(program)
        said = tmp_path / "number"
        parent = subprocess.Popen([sys.executable, "-c", PARENT, str(said), *options], cwd=tmp_path)
        processes.append(parent.pid)
        wait_until(lambda: said.exists() and bool(said.read_text()))
        processes.append(int(said.read_text()))
        return parent, processes[-1]

    yield start
    for process in filter(runs, processes):
        os.kill(process, 9)


@pytest.mark.parametrize(
    "program",
    [(CHILD + "go_on()", "from its first moment"), (CHILD + AT_WORK + "go_on()",), (NODE,)],
    ids=["while it loads its modules", "at work", "held up in the start of the middleware"],
)
def test_a_process_in_which_no_handler_has_a_turn_ends_after_a_parent_that_was_killed(started, program):
    parent, child = started(*program)
    assert runs(child)
    parent.kill()
    parent.wait()
    wait_until(lambda: not runs(child))


def test_a_node_that_loads_its_modules_ends_by_an_interrupt_at_once(started):
    _, child = started(CHILD + "go_on()", "from its first moment")
    os.kill(child, signal.SIGINT)
    wait_until(lambda: not runs(child))


def test_a_node_that_has_ended_waits_for_no_thread(tmp_path):
    (tmp_path / "child.py").write_text(THREAD + "print('closed')\nraise SystemExit(3)")
    command = [sys.executable, "-m", "heave_node.ros.transport.parents_death", "child"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120.0, check=False)
    assert (done.returncode, done.stdout) == (3, "closed\n")


@pytest.fixture
def interrupts() -> Iterator[Callable[[], None]]:
    """Return what interrupts this process; its handlers are put back afterwards."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield lambda: os.kill(os.getpid(), signal.SIGINT)
    for number, handler in before.items():
        signal.signal(number, handler)


def test_an_interrupt_breaks_off_the_building_of_a_node_and_nothing_after_it(interrupts):
    said: list[str] = []
    node: Any = SimpleNamespace(failure="", was_ended=False, fail=said.append)
    with pytest.raises(KeyboardInterrupt), _ended_by_signals([node]):
        interrupts()
        said.append("built to the end")
    assert said == ["ended by SIGINT"]
    assert node.was_ended
    interrupts()
    assert said == ["ended by SIGINT"] * 2

    with _ended_by_signals([node]):
        pass
    interrupts()


def test_one_whose_parent_ended_before_it_could_ask_does_not_begin(tmp_path):
    """The launcher of the environment is not the parent: it has ended, and somebody has inherited its child."""
    done = subprocess.run(
        [sys.executable, "-m", "heave_node.ros.transport.parents_death", "this"],
        env={**os.environ, LAUNCHER_VARIABLE: "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert done.stderr == f"the process 1, which has started this one ({LAUNCHER_VARIABLE}), has ended\n"


@pytest.mark.parametrize(
    ("environment", "launcher"), [({}, None), ({LAUNCHER_VARIABLE: ""}, None), ({LAUNCHER_VARIABLE: "12"}, 12)]
)
def test_nobody_is_outlived_by_what_has_no_launcher(environment, launcher):
    assert launcher_of(environment) == launcher


def test_a_module_is_run_as_python_runs_it(tmp_path):
    (tmp_path / "child.py").write_text("import sys\nprint(__name__, __spec__.name, *sys.argv[1:])")
    command = [sys.executable, "-m", "heave_node.ros.transport.parents_death", "child", "a", "b"]
    environment = {name: value for name, value in os.environ.items() if name != LAUNCHER_VARIABLE}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout == "__main__ child a b\n"
