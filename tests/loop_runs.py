"""Runs of the whole loop for tests: the `heave` command as a user gives it, in a ROS domain of its own."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import psutil
from domain_coordinator import domain_id
from heave_bringup.errors import ExitStatus
from mcap.reader import make_reader

CALM_DURATION = 10.0
"""Simulated time of the run that several tests look at [s]."""

HAS_RUN = (ExitStatus.DONE, ExitStatus.VERDICT_FAILED)
"""Exit statuses of a run that reached its end, whatever its verdict."""


def command(*arguments: str) -> list[str]:
    """Return the `heave` command; a run spares the baseline, unless it is asked for."""
    spares = arguments[0] == "run" and "--baseline" not in arguments
    return [sys.executable, "-m", "heave_bringup.cli", *arguments, *(["--no-baseline"] if spares else [])]


def environment(domain: int) -> dict[str, str]:
    return {**os.environ, "ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


def heave(*arguments: str, timeout: float = 120.0) -> subprocess.CompletedProcess[str]:
    """Give the `heave` command and return what it printed and its exit status."""
    with domain_id() as domain:
        return give(domain, *arguments, timeout=timeout)


def give(domain: int, *arguments: str, timeout: float = 150.0) -> subprocess.CompletedProcess[str]:
    """Give the `heave` command in a ROS domain that others are in as well."""
    return subprocess.run(
        command(*arguments), env=environment(domain), capture_output=True, text=True, timeout=timeout, check=False
    )


@contextmanager
def beside(domain: int, *words: str, stderr: int | None = None) -> Iterator[subprocess.Popen[str]]:
    """Run a Python program of these words in a ROS domain while a test looks; it is then interrupted, or killed.

    One that is interrupted before it runs may not hear it, and must not speak in the runs of others.
    """
    program = subprocess.Popen([sys.executable, *words], env=environment(domain), stderr=stderr, text=True)
    try:
        yield program
    finally:
        if program.poll() is None:
            program.send_signal(signal.SIGINT)
        try:
            program.wait(10.0)
        except subprocess.TimeoutExpired:
            program.kill()
            program.wait()


@contextmanager
def under_way(domain: int, *arguments: str) -> Iterator[subprocess.Popen[str]]:
    """Give a `heave` command in a ROS domain, and let a test do something while it runs; it is killed at the end."""
    run = subprocess.Popen(
        command(*arguments), env=environment(domain), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        yield run
    finally:
        run.kill()


class Adapted(NamedTuple):
    """How `heave adapt` has ended: exit status, and what it printed."""

    returncode: int
    out: str
    err: str


@contextmanager
def adapting(domain: int, *arguments: str) -> Iterator[list[Adapted]]:
    """Give `heave adapt` while others run in a ROS domain, and interrupt it; it has then ended as the list says."""
    ended: list[Adapted] = []
    adapter = subprocess.Popen(
        command("adapt", *arguments),
        env=environment(domain),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield ended
    finally:
        adapter.send_signal(signal.SIGINT)
        out, err = adapter.communicate(timeout=20.0)
        ended.append(Adapted(adapter.returncode, out, err))


def run_scenario(folder: Path, scenario: str = "b2_calm_300", *, duration: float, options: Sequence[str] = ()) -> Path:
    """Run a scenario and return its bag; the run must reach its end, whatever its verdict."""
    result = heave("run", scenario, "--duration", str(duration), "--bag", str(folder), "--no-report", *options)
    assert result.returncode in HAS_RUN, result.stderr
    return folder / "bag"


def recorded_messages(bag: Path) -> list[tuple[str, int, int]]:
    """Return topic, log time and checksum of every message, in file order."""
    found = []
    for file in sorted(bag.glob("*.mcap")):
        with file.open("rb") as stream:
            for _, channel, message in make_reader(stream).iter_messages(log_time_order=False):
                found.append((channel.topic, message.log_time, zlib.crc32(message.data)))
    return found


def process_of(node: str, folder: Path) -> int:
    """Return the process id of a node of the run in `folder`."""
    scenario = str((folder / "scenario.yaml").resolve())
    modules = {
        "virtual_winch": "cable_sim_node.winch_node",
        "winch_adviser": "winch_controller_node.adviser_node",
        "recorder": "heave_bags.record.recorder_node",
    }
    module = modules.get(node, f"{node}_node.node")
    for process in psutil.process_iter(["cmdline"]):
        arguments = process.info["cmdline"] or []
        if scenario in arguments and module in arguments:
            return int(process.pid)
    raise AssertionError(f"{node} does not run")


def wait_until(condition: Callable[[], bool], timeout: float) -> None:
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline, "the run does not get going"
        time.sleep(0.2)
