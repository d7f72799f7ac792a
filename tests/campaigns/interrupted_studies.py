"""Ctrl-C at random moments of every long command: it ends in time, leaves no process, and keeps what was finished.

    python -m tests.campaigns.interrupted_studies --count 50
    python -m tests.campaigns.interrupted_studies --only run record --latest 30

The signal goes to all processes of a terminal's group, or to the command alone, in turn. Of a study the finished cases
are kept, of a run and a recording the bag, whole. Prints a table, with the load of the machine, and ends with status 1
where something is wrong.
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
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import pandas
import psutil
from domain_coordinator import domain_id
from heave_bags.mcap.reader import Bag
from heave_bringup.errors import ExitStatus
from heave_bringup.progress import ProgressLine

from tests.campaigns.in_process import commit_line
from tests.loop_runs import HAS_RUN

LONGEST = 5.0
"""Wall time from the signal to the end [s]."""
GIVEN_UP = 120.0
"""Wall time from the signal after which a command is killed [s]."""
LATEST = 60.0
"""Wall time from the start to the signal at most [s]: workers are busy by half of it."""
AT_ITS_END = 0.3
"""Wall time [s]: a command that ends so soon after the signal may have been at its end, with the status that it had."""
MARK = "HEAVE_INTERRUPTED_STUDY"
"""Environment variable by which all that a command has started is known, in whatever group or session it runs."""
CASES = """
scenario: unit_1500
duration: 20
set: {all.transient: 1.0, wave_vessel.ramp: 0.5, cable_sim.segments: 2}
seeds: 500
"""
COMMANDS: dict[str, list[str]] = {
    "study": ["study", "own.yaml", "--processes", "2"],
    "operability": ["study", "operability", "--processes", "2"],
    "sizing": ["study", "sizing", "--processes", "2"],
    "run": ["run", "b2_calm_300", "--duration", "100000", "--bag", "run", "--no-report"],
    "short run": ["run", "b2_calm_300", "--duration", "300", "--bag", "run"],
    "record": ["record", "bag"],
    "whatif": ["whatif", "RECORD", "--law", "off,industrial,lqg,mpc"],
    "acceptance": ["study", "harbour_test", "--output", "accepted"],
}
RECORDED = ("run", "b2_calm_300", "--duration", "120", "--composed", "--no-report", "--no-baseline", "--quiet")
"""The run, by its command, of which `whatif` is asked."""
ENDS = {"record": (ExitStatus.DONE, ExitStatus.INTERRUPTED)}
"""Exit statuses after Ctrl-C where it is not INTERRUPTED alone: a recording ends by it."""


@dataclass(frozen=True)
class Interruption:
    """One command and its end: wall times of the signal and from it to the end [s], what was kept, what is wrong, and
    whether it had come to its own end before."""

    command: str
    after: float
    took: float
    kept: int
    wrong: str
    had_ended: bool = False

    def __str__(self) -> str:
        return f"{self.command} after {self.after:.1f} s, ended within {self.took:.1f} s: {self.wrong or 'well'}"


def interrupt_one(command: str, number: int, folder: Path, record: Path, latest: float = LATEST) -> Interruption:
    """Start a command in a folder, interrupt it at a moment drawn by the seed `number`, and judge its end.

    Parameters
    ----------
    command : its name
    number : seed; the signal goes to the whole group where it is even, to the command alone where it is odd
    folder : that it works in
    record : bag of which `whatif` is asked
    latest : wall time from the start to the signal at most [s]
    """
    chance = random.Random(number)
    (folder / "own.yaml").write_text(CASES)
    words = [str(record) if word == "RECORD" else word for word in COMMANDS[command]]
    with (folder / "said").open("wb") as sink, domain_id() as domain:
        process = subprocess.Popen(
            [sys.executable, "-m", "heave_bringup.cli", *words],
            cwd=folder,
            env={**os.environ, "ROS_DOMAIN_ID": str(domain), MARK: str(folder)},
            stdout=subprocess.DEVNULL,
            stderr=sink,
            start_new_session=True,
        )
        try:
            after = chance.uniform(0.5, latest)
            with suppress(subprocess.TimeoutExpired):
                process.wait(after)
            had_ended = process.poll() is not None
            finished = _lines(folder)
            began = time.monotonic()
            if number % 2:
                process.send_signal(signal.SIGINT)
            elif not had_ended:
                os.killpg(process.pid, signal.SIGINT)
            with suppress(subprocess.TimeoutExpired):
                process.wait(GIVEN_UP)
            took = time.monotonic() - began
            wrong = _judge(command, process, folder, finished, took)
        finally:
            for left in started_for(folder):
                left.kill()
            process.wait()
    return Interruption(command, after, took, _lines(folder), wrong, had_ended)


def _judge(command: str, process: subprocess.Popen[bytes], folder: Path, finished: int, took: float) -> str:
    complaint = (folder / "said").read_text(errors="replace")
    wrong = [f"it took {took:.1f} s"] if took > LONGEST else []
    ends = (*ENDS.get(command, (ExitStatus.INTERRUPTED,)), *(HAS_RUN if took < AT_ITS_END else ()))
    if process.returncode not in (*ends, -signal.SIGINT):  # the latter before the command has begun
        wrong.append(f"status {process.returncode}: {complaint[-300:]}")
    if process.returncode != -signal.SIGINT and "Traceback" in complaint:
        wrong.append(complaint[-500:])
    left = psutil.wait_procs(started_for(folder), timeout=LONGEST)[1]
    wrong += [f"left running: {[' '.join(one.cmdline())[-80:] for one in left]}"] if left else []
    if _lines(folder) < finished:
        wrong.append(f"{finished} cases were finished, {_lines(folder)} are kept")
    for bag in {file.parent for file in folder.rglob("*.mcap")}:
        losses = [str(loss) for loss in Bag(bag).losses if loss.messages != 0]
        wrong += [f"{bag.relative_to(folder)}: {losses[0]}"] if losses else []
    return "; ".join(wrong)


def started_for(folder: Path) -> list[psutil.Process]:
    """Return the processes that run and belong to the command that works in a `folder`."""
    found = []
    for process in psutil.process_iter(["environ", "status"]):
        is_its_own = (process.info["environ"] or {}).get(MARK) == str(folder)
        if is_its_own and process.info["status"] != psutil.STATUS_ZOMBIE:
            found.append(process)
    return found


def _lines(folder: Path) -> int:
    """Return how many whole results the journal beside the table has."""
    journal = folder / "studies" / "own" / "journal.jsonl"
    return max(journal.read_text().count("\n") - 1, 0) if journal.exists() else 0


def table(found: Sequence[Interruption]) -> str:
    """Return what became of the commands as a table; those that had come to their own end before do not count."""
    ends = pandas.DataFrame(found).query("not had_ended").assign(is_wrong=lambda one: one["wrong"] != "")
    figures = {"took": ["count", "median", "max"], "kept": "max", "is_wrong": "sum"}
    lines = [str(one) for one in found if one.wrong]
    return "\n".join([ends.groupby("command").agg(figures).to_string(), *lines])


def main() -> int:
    """Run the campaign from the command line."""
    parser = argparse.ArgumentParser(prog="interrupted_studies", description=__doc__)
    parser.add_argument("--count", type=int, default=50, help="of each command (default 50)")
    parser.add_argument("--first", type=int, default=0, help="number of the first (default 0)")
    parser.add_argument("--only", nargs="+", choices=COMMANDS, default=list(COMMANDS), help="commands (default: all)")
    parser.add_argument("--latest", type=float, default=LATEST, help=f"time to the signal [s] (default {LATEST:g})")
    options = parser.parse_args()
    for number in (signal.SIGTERM, signal.SIGINT):  # no command is left behind; one in the background ignores SIGINT,
        signal.signal(number, signal.default_int_handler)  # and so would what it starts until it knows better
    progress = ProgressLine()
    found: list[Interruption] = []
    loads = []
    with tempfile.TemporaryDirectory() as recorded:
        record = Path(recorded) / "run"
        if "whatif" in options.only:
            subprocess.run([sys.executable, "-m", "heave_bringup.cli", *RECORDED, "--bag", str(record)], check=True)
        for number in range(options.first, options.first + options.count):
            for command in options.only:
                with tempfile.TemporaryDirectory() as folder:
                    found.append(interrupt_one(command, number, Path(folder), record, options.latest))
                if found[-1].wrong:
                    progress.tell(str(found[-1]))
                loads.append(os.getloadavg()[0])
                wrong = sum(bool(one.wrong) for one in found)
                progress.show(f"{len(found)} of {options.count * len(options.only)}, {wrong} wrong")
    progress.close()
    load = f"load {min(loads):.1f} to {max(loads):.1f}" if loads else ""
    sys.stdout.write(f"{commit_line()}, {load}\n{table(found)}\n")
    return 1 if any(one.wrong for one in found) else 0


if __name__ == "__main__":
    sys.exit(main())
