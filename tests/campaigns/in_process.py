"""What campaigns have in common: what they were measured on, and the command `heave` given in this process."""

from __future__ import annotations

import json
import multiprocessing
import os
import platform
import resource
import signal
import subprocess
import time
import traceback
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import asdict, dataclass, field
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile
from types import FrameType
from typing import Any

from heave_bags.record.provenance import git_commit
from heave_bringup.errors import ExitStatus
from heave_node.ros.transport import parents_death

ROOT = Path(__file__).parents[2]
MEMORY = 500 << 20
"""Bytes that a process may take on anything that it is given."""


def commit_line() -> str:
    """Return the commit that runs, Python and processors, in one line."""
    commit = git_commit(Path(__file__).parent) or "no commit known"
    return f"measured on {commit}, Python {platform.python_version()}, {os.cpu_count()} processors"


def heave(words: Sequence[str]) -> tuple[int, str, str]:
    """Give a command of these `words`; return its status, and what it said on standard output and error."""
    from heave_bringup.cli import main  # noqa: PLC0415 - after the limits of this process are set

    with TemporaryFile("w+") as err, redirect_stdout(StringIO()) as out, redirect_stderr(err):
        try:
            status = main(words)
        except SystemExit as error:
            status = int(error.code or 0)
        err.seek(0)
        complaint = err.read()
    return status, out.getvalue(), complaint


def judge(status: int, said: str, complaint: str) -> str:
    """Return what is wrong with the end of a command: it does what it says, or ends in one line.

    Parameters
    ----------
    status : of the command
    said : on standard output: JSON
    complaint : on standard error
    """
    if "Traceback" in complaint:
        return complaint
    if status in (ExitStatus.DONE, ExitStatus.VERDICT_FAILED):
        json.loads(said)
        return ""
    last = complaint.strip().splitlines()[-1:] or [""]
    return "" if status in (1, 2) and last[0].startswith("heave: ") else f"status {status}: {complaint[-300:]}"


class Watch:
    """Turns an exception, or more wall time than is allowed, into an entry of what is wrong.

    Parameters
    ----------
    wrong : by command
    command : its name
    longest : wall time after which it is said to hang [s]
    """

    def __init__(self, wrong: dict[str, str], command: str, longest: int) -> None:
        self._wrong, self._command, self._longest = wrong, command, longest

    def __enter__(self) -> None:
        signal.signal(signal.SIGALRM, self._late)
        signal.alarm(self._longest)

    def _late(self, _number: int, _frame: FrameType | None) -> None:
        raise TimeoutError(f"no end within {self._longest} s")

    def __exit__(self, kind: object, error: BaseException | None, _traceback: object) -> bool:
        signal.alarm(0)
        if error is not None:
            place = " ".join(traceback.format_exception(error)[-2].split())
            self._wrong[self._command] = f"{type(error).__name__}: {error}; {place}"
        return True


def in_a_fork(task: Callable[[], Any], longest: float | None = None) -> Any:
    """Return what a task gives in a process of its own; None after `longest` [s], its exit status where it crashes."""
    ours, theirs = multiprocessing.Pipe(duplex=False)
    child = multiprocessing.get_context("fork").Process(target=lambda: theirs.send(task()))
    child.start()
    theirs.close()
    try:
        if not ours.poll(longest):
            child.kill()
            return None
        return ours.recv()
    except EOFError:
        child.join()
        return child.exitcode
    finally:
        child.join()


@dataclass
class Result:
    """What became of one bag or file that was given to commands."""

    name: str  # of it
    kind: str  # of damage, or of file
    wrong: dict[str, str] = field(default_factory=dict)  # what was wrong, by command; "" is never in it
    lost: int = 0  # messages of a bag
    refused: bool = False  # by a command at least
    longest: float = 0.0  # command [s of a processor]
    memory: int = 0  # most that the process has taken [bytes]

    @property
    def problems(self) -> list[str]:
        """What was wrong, memory among it, a line each."""
        found = dict(self.wrong)
        if self.memory > MEMORY:
            found["memory"] = f"{self.memory / 2**20:.0f} MB"
        return [f"{self.kind}: {self.name}: {where}: {text}" for where, text in found.items()]


def run_batches(
    module: str, tasks: Sequence[Sequence[str]], processes: int, progress: Callable[[list[Result]], None]
) -> list[Result]:
    """Run `python -m MODULE TASK --results FILE` for each of some tasks, and return the results of all.

    Parameters
    ----------
    module : that is run; it ends by `write_results`
    tasks : words of the command line
    processes : at a time
    progress : is given the results so far

    A process that ends without results is one.
    """
    results: list[Result] = []
    running: list[tuple[subprocess.Popen[bytes], Path]] = []
    waiting = [list(task) for task in tasks]
    with TemporaryDirectory() as folder:
        while waiting or running:
            while waiting and len(running) < processes:
                path = Path(folder) / f"{len(waiting)}.json"
                command = parents_death.command(module, *waiting.pop(0), "--results", str(path))
                environment = {**os.environ, **parents_death.environment()}
                running.append((subprocess.Popen(command, stderr=subprocess.PIPE, cwd=ROOT, env=environment), path))
            for child, path in [one for one in running if one[0].poll() is not None]:
                running.remove((child, path))
                if path.exists():
                    results += [Result(**entry) for entry in json.loads(path.read_text())]
                else:
                    said = (child.stderr.read() if child.stderr else b"").decode(errors="replace")[-2000:]
                    results.append(Result("a process", "process", {"all": f"ended with {child.returncode}: {said}"}))
                progress(results)
            time.sleep(0.2)
    return results


def write_results(path: Path, make: Callable[[], list[Result]]) -> int:
    """Write what `make` returns to a file; what this process may ask for of memory is limited first."""
    resource.setrlimit(resource.RLIMIT_DATA, (2 * MEMORY, 2 * MEMORY))  # what is asked for; what is used is measured
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    path.write_text(json.dumps([asdict(result) for result in make()]))
    return 0


def table(results: Sequence[Result]) -> str:
    """Return the results as a table, and below it what was wrong."""
    heads = ("kind", "tried", "refused", "with loss", "messages lost", "longest s", "most MB", "wrong")
    lines = ["".join(f"{head:>15}" for head in heads)]
    for kind in dict.fromkeys(result.kind for result in results):
        part = [result for result in results if result.kind == kind]
        counts = (len(part), sum(one.refused for one in part), sum(one.lost > 0 for one in part))
        worst = (f"{max(one.longest for one in part):.1f}", f"{max(one.memory for one in part) / 2**20:.0f}")
        row = (kind, *counts, sum(one.lost for one in part), *worst, sum(bool(one.problems) for one in part))
        lines.append("".join(f"{cell:>15}" for cell in row))
    return "\n".join([*lines, *(line for one in results for line in one.problems)])
