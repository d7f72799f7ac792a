"""Ctrl-C at random moments of every long command: it ends in time, leaves no process, and keeps what was finished.

    python -m tests.campaigns.interrupted_studies --count 50

The signal goes to all processes of a terminal's group, or to the command alone, in turn. Prints a table and ends with
status 1 where something is wrong.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from heave_bringup.errors import ExitStatus
from heave_bringup.progress import ProgressLine

from tests.campaigns.commit import commit_line

LONGEST = 5.0
"""Wall time from the signal to the end [s]."""
LATEST = 60.0
"""Wall time from the start to the signal at most [s]: workers are busy by half of it."""
CASES = """
scenario: unit_1500
duration: 20
set: {all.transient: 1.0, wave_vessel.ramp: 0.5, cable_sim.segments: 2}
seeds: 500
"""
COMMANDS: dict[str, list[str]] = {
    "campaign": ["campaign", "own.yaml", "--output", "own.parquet", "--no-baseline", "--processes", "2"],
    "operability": ["operability", "unit_1500", "--output", "own.parquet", "--processes", "2"],
    "sizing": ["sizing", "unit_1500", "--output", "own.parquet", "--processes", "2"],
    "benchmark": ["benchmark", "run", "industrial", "--processes", "2"],
}


@dataclass(frozen=True)
class Interruption:
    """One command and its end: wall times of the signal and from it to the end [s], what was kept, what is wrong."""

    command: str
    after: float
    took: float
    kept: int
    wrong: str


def interrupt_one(command: str, number: int, folder: Path) -> Interruption:
    """Start a command in a folder, interrupt it at a moment drawn by the seed `number`, and judge its end."""
    chance = random.Random(number)
    (folder / "own.yaml").write_text(CASES)
    said = folder / "said"
    with said.open("wb") as sink:
        process = subprocess.Popen(
            [sys.executable, "-m", "heave_bringup.cli", *COMMANDS[command]],
            cwd=folder,
            stdout=subprocess.DEVNULL,
            stderr=sink,
            start_new_session=True,
        )
    try:
        after = chance.uniform(0.5, LATEST)
        time.sleep(after)
        finished = _lines(folder)
        began = time.monotonic()
        if number % 2:
            process.send_signal(signal.SIGINT)
        else:
            os.killpg(process.pid, signal.SIGINT)
        process.wait(120.0)
        took = time.monotonic() - began
        wrong = _judge(process, folder, finished, took)
    finally:
        if _group(process.pid):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    return Interruption(command, after, took, _lines(folder), wrong)


def _judge(process: subprocess.Popen[bytes], folder: Path, finished: int, took: float) -> str:
    complaint = (folder / "said").read_text(errors="replace")
    wrong = [f"it took {took:.1f} s"] if took > LONGEST else []
    if process.returncode not in (ExitStatus.INTERRUPTED, -signal.SIGINT):  # the latter before the command has begun
        wrong.append(f"status {process.returncode}: {complaint[-300:]}")
    if process.returncode == ExitStatus.INTERRUPTED and "Traceback" in complaint:
        wrong.append(complaint[-500:])
    deadline = time.monotonic() + LONGEST
    while _group(process.pid) and time.monotonic() < deadline:
        time.sleep(0.05)
    left = _group(process.pid)
    wrong += [f"left running: {left}"] if left else []
    if _lines(folder) < finished:
        wrong.append(f"{finished} cases were finished, {_lines(folder)} are kept")
    return "; ".join(wrong)


def _lines(folder: Path) -> int:
    """Return how many whole results the journal beside the table has."""
    journal = folder / "own.parquet.partial"
    return max(journal.read_text().count("\n") - 1, 0) if journal.exists() else 0


def _group(leader: int) -> list[int]:
    """Return the processes of a group that still run."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, group = path.read_text().rpartition(")")[2].split()[:3]
        except OSError:
            continue
        if int(group) == leader and state != "Z":
            found.append(int(path.parent.name))
    return found


def table(found: Sequence[Interruption]) -> str:
    """Return what became of the commands as a table."""
    lines = [f"{'command':14}{'times':>6}{'longest s':>11}{'most kept':>11}{'wrong':>7}"]
    for command in COMMANDS:
        part = [one for one in found if one.command == command]
        if part:
            longest, kept = max(one.took for one in part), max(one.kept for one in part)
            lines.append(f"{command:14}{len(part):6}{longest:11.1f}{kept:11}{sum(bool(one.wrong) for one in part):7}")
    return "\n".join([*lines, *(f"{one.command} after {one.after:.1f} s: {one.wrong}" for one in found if one.wrong)])


def main() -> int:
    """Run the campaign from the command line."""
    parser = argparse.ArgumentParser(prog="interrupted_studies", description=__doc__)
    parser.add_argument("--count", type=int, default=50, help="of each command (default 50)")
    parser.add_argument("--first", type=int, default=0, help="number of the first (default 0)")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # no command is left behind
    progress = ProgressLine()
    found = []
    for number in range(options.first, options.first + options.count):
        for command in COMMANDS:
            with tempfile.TemporaryDirectory() as folder:
                found.append(interrupt_one(command, number, Path(folder)))
            wrong = sum(bool(one.wrong) for one in found)
            progress.show(f"{len(found)} of {options.count * len(COMMANDS)}, {wrong} wrong")
    progress.close()
    sys.stdout.write(f"{commit_line()}\n{table(found)}\n")
    return 1 if any(one.wrong for one in found) else 0


if __name__ == "__main__":
    sys.exit(main())
