"""Worker processes end with what started them, however busy they are."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from heave_bringup.errors import ExitStatus

PARENT = """
import sys
from functools import partial
sys.path.insert(0, {folder!r})
from busy import busy
from heave_bringup.interrupts import raise_interrupts
from heave_studies.study.workers import Job, workers

if __name__ == "__main__":
    raise_interrupts()
    with workers(2) as run:
        list(run([Job(number, "", partial(busy, number)) for number in range(5)]))
"""
BUSY = """
import os
from pathlib import Path

def busy(number):
    Path(__file__).with_name(f"worker_{os.getpid()}").touch()
    sum(range(10**15))  # in C: no thread of Python has a turn in it
"""


def wait_for(condition, seconds=120.0):
    """Wait until something is so; no test asserts how long it took."""
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "it did not come about"
        time.sleep(0.05)


def is_running(process: int) -> bool:
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


@pytest.fixture
def parent(tmp_path: Path) -> Iterator[tuple[subprocess.Popen[bytes], list[int]]]:
    """Give a process whose two workers are busy, and the workers."""
    (tmp_path / "busy.py").write_text(BUSY)
    (tmp_path / "parent.py").write_text(PARENT.format(folder=str(tmp_path)))
    process = subprocess.Popen([sys.executable, str(tmp_path / "parent.py")], stderr=subprocess.DEVNULL)
    workers: list[int] = []
    try:
        wait_for(lambda: len(list(tmp_path.glob("worker_*"))) == 2)
        workers += [int(path.name.partition("_")[2]) for path in tmp_path.glob("worker_*")]
        yield process, workers
    finally:
        process.kill()
        process.wait()
        for worker in workers:
            if is_running(worker):
                os.kill(worker, signal.SIGKILL)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_no_worker_outlives_its_parent(parent, number):
    process, workers = parent
    process.send_signal(number)
    process.wait(60)
    wait_for(lambda: not any(map(is_running, workers)))


def study_of_a_minute(folder: Path) -> subprocess.Popen[str]:
    """Start a study whose first cases take moments and whose others take minutes."""
    (folder / "own.yaml").write_text(
        """
scenario: unit_1500
set: {all.transient: 1.0, wave_vessel.ramp: 0.5, cable_sim.segments: 2}
vary: {all.duration: [2, 2, 100000, 100000, 100000]}
"""
    )
    command = [sys.executable, "-m", "heave_bringup.cli", "study", "own.yaml", "--processes", "2"]
    return subprocess.Popen(
        command,
        cwd=folder,
        text=True,
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        start_new_session=True,
    )


def finished(folder: Path) -> int:
    journal = folder / "studies" / "own" / "journal.jsonl"
    return journal.read_text().count('"failure"') if journal.exists() else 0


def children_of(process: int) -> list[int]:
    found = [one for of in Path(f"/proc/{process}/task").glob("*/children") for one in of.read_text().split()]
    return [int(child) for child in found]


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_study_that_is_interrupted_ends_with_status_130_and_keeps_what_was_finished(tmp_path, number):
    process = study_of_a_minute(tmp_path)
    try:
        wait_for(lambda: finished(tmp_path) == 2 or process.poll() is not None, 300)
        workers = children_of(process.pid)
        assert len(workers) >= 2
        os.killpg(process.pid, number) if number == signal.SIGINT else process.send_signal(number)
        _, said = process.communicate(timeout=60)
        assert process.returncode == ExitStatus.INTERRUPTED
        assert "Traceback" not in said
        assert "2 cases are kept" in said
        assert finished(tmp_path) == 2
        wait_for(lambda: not any(map(is_running, workers)))
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
