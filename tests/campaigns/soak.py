"""Long runs: memory, descriptors and files of the nodes stay what they were after the first quarter.

    python -m tests.campaigns.soak                                     # 15 simulated hours, then a real one
    python -m tests.campaigns.soak --kinds composed --hours 2
    python -m tests.campaigns.soak --kinds processes --hours 0.25

`composed` is a run in lockstep with all nodes in one process, as fast as it goes; `processes` is one in real time with
a process for each. While the nodes run they are looked at every few seconds; the median of the second quarter is
compared with that of the last. Prints a table, with the memory of each node, and ends with status 1 where something
grows, is left behind, or the run does not do what it should. A run ends with this program, however that ends.
"""

from __future__ import annotations

import argparse
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import psutil
from domain_coordinator import domain_id
from heave_bringup.nodes import PROCESS_BY_NAME
from heave_bringup.progress import ProgressLine
from heave_bringup.run.launcher import TOGETHER
from heave_node.ros.transport import parents_death

from tests.campaigns.in_process import commit_line
from tests.loop_runs import HAS_RUN, environment

HOURS = {"composed": 15.0, "processes": 1.0}
"""Length of a run of each kind, simulated and real [h]."""
OPTIONS = {"composed": ["--composed"], "processes": ["--pacing", "realtime"]}
"""Options of `heave run` for each kind."""

ALLOWED = {"memory": (0.02, 4.0), "descriptors": (0.0, 2.0), "files": (0.0, 0.0)}
"""What may be added from the second quarter to the last: a share, and so many megabytes, descriptors and files."""
UNITS = {"memory": "MB", "descriptors": "", "files": "beside the bag"}


@dataclass(frozen=True)
class Look:
    """What the nodes had at a time."""

    memory: Mapping[str, float]  # that no other process shares, of each node by its name [MB]
    descriptors: int  # that are open
    files: int  # in the folder of the run, the bag's apart

    def figures(self) -> dict[str, float]:
        """Return them by name."""
        values = (sum(self.memory.values()), self.descriptors, self.files)
        return dict(zip(ALLOWED, values, strict=True))


@dataclass(frozen=True)
class Soaked:
    """How a run went: what it had at each look, and what was wrong with it beside that."""

    kind: str
    hours: float
    wall: float
    looks: list[Look]
    wrong: list[str]


def look_at(command: psutil.Process, folder: Path) -> Look | None:
    """Return what the nodes of a `command` that runs into a `folder` have now; None where none runs."""
    memory: dict[str, float] = {}
    descriptors = 0
    nodes = [node for node in command.children() if "--ros-args" in _words(node)]
    for node in nodes:
        with suppress(psutil.Error):
            memory[_name(node)] = node.memory_full_info().uss / 1e6
            descriptors += node.num_fds()
    files = sum(path.is_file() for path in folder.rglob("*") if "bag" not in path.relative_to(folder).parts)
    return Look(memory, descriptors, files) if nodes else None


def _words(process: psutil.Process) -> list[str]:
    try:
        return list(process.cmdline())
    except psutil.Error:
        return []


def _name(process: psutil.Process) -> str:
    """Return the name of the node that a process runs; of several in one process, that they are."""
    words = _words(process)
    return next((node.name for node in PROCESS_BY_NAME.values() if node.module in words), TOGETHER)


def soak(kind: str, hours: float, scenario: str, place: Path, show: Callable[[str], None]) -> Soaked:
    """Run a `scenario` for so many `hours` into the folder `place`, and look at its nodes all the while."""
    folder = place / "run"
    wanted = 3600.0 * hours
    words = ["run", scenario, "--duration", f"{wanted:g}", "--quiet", "--no-report", "--no-baseline"]
    command = parents_death.command("heave_bringup.cli", *words, "--bag", str(folder), *OPTIONS[kind])
    begun, looks = time.monotonic(), []
    with domain_id() as domain, (place / "said.txt").open("wb") as said:
        of_domain = {**environment(domain), **parents_death.environment()}
        run = psutil.Popen(command, env=of_domain, stdin=subprocess.DEVNULL, stdout=said, stderr=subprocess.STDOUT)
        pause = min(10.0, 0.01 * wanted)
        try:
            while run.poll() is None:
                time.sleep(pause)
                look = look_at(run, folder) if run.is_running() else None
                looks += [] if look is None else [look]
                memory = look.figures()["memory"] if look else 0.0  # none: they start, or the bag is judged
                show(f"{kind}: {time.monotonic() - begun:.0f} s, {memory:.0f} MB")
        finally:
            with suppress(psutil.NoSuchProcess):  # it has come to its end
                run.terminate()
            run.wait()
    wrong = [] if run.returncode in HAS_RUN else [f"status {run.returncode}: {(place / 'said.txt').read_text()[-300:]}"]
    return Soaked(kind, hours, time.monotonic() - begun, looks, wrong)


def judged(soaked: Soaked) -> list[tuple[str, float, float, bool]]:
    """Return of each figure its name, the medians of the second quarter and the last, and whether it stayed."""
    found = []
    for name, (share, more) in ALLOWED.items():
        first, last = _quarters([look.figures()[name] for look in soaked.looks])
        found.append((name, first, last, last <= first * (1.0 + share) + more))
    return found


def _quarters(values: Sequence[float]) -> tuple[float, float]:
    """Return the medians of the second quarter of some `values`, and of the last."""
    quarter = len(values) // 4
    return statistics.median(values[quarter : 2 * quarter]), statistics.median(values[-quarter:])


def memory_by_node(soaked: Soaked) -> dict[str, tuple[float, float]]:
    """Return the memory of each node in the second quarter and in the last [MB]."""
    names = dict.fromkeys(name for look in soaked.looks for name in look.memory)
    return {name: _quarters([look.memory.get(name, 0.0) for look in soaked.looks]) for name in names}


def table(results: list[Soaked]) -> str:
    """Return the `results` as a table, and below it what was wrong."""
    lines = [f"{'':12}{'hours':>7}{'wall':>8}  {'of the nodes':28}{'2nd quarter':>12}{'last':>9}"]
    for soaked in results:
        run = f"{soaked.kind:12}{soaked.hours:7.2f}{soaked.wall:7.0f}s"
        if len(soaked.looks) < 8:
            lines.append(f"{run}  too short to judge: {len(soaked.looks)} looks")
            continue
        for name, first, last, has_stayed in judged(soaked):
            what = f"{name} {UNITS[name]}".strip()
            lines.append(f"{run}  {what:28}{first:12.1f}{last:9.1f}{'' if has_stayed else '  GROWS'}")
            run = " " * 28
        for name, (first, last) in memory_by_node(soaked).items():
            lines.append(f"{run}    {name:26}{first:12.1f}{last:9.1f}")
        lines += [f"  wrong: {text}" for text in soaked.wrong]
    return "\n".join(lines)


def is_well(soaked: Soaked) -> bool:
    """Return whether a run did what it should, and nothing grew."""
    return not soaked.wrong and len(soaked.looks) >= 8 and all(stayed for *_, stayed in judged(soaked))


def main() -> int:
    """Run the campaign from the command line."""
    parser = argparse.ArgumentParser(prog="soak", description=__doc__)
    parser.add_argument("--kinds", nargs="+", choices=HOURS, default=list(HOURS), help="of run (default: both)")
    parser.add_argument("--hours", type=float, help="for each kind (default: 15 composed, 1 of processes)")
    parser.add_argument("--scenario", default="b2_calm_300", help="(default b2_calm_300)")
    parser.add_argument("--folder", type=Path, help="for the bags while they are recorded (default: of the system)")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # its run ends in order
    progress, results, commit = ProgressLine(), [], commit_line()
    for kind in options.kinds:
        with tempfile.TemporaryDirectory(prefix="heave-soak-", dir=options.folder) as place:
            hours = options.hours or HOURS[kind]
            results.append(soak(kind, hours, options.scenario, Path(place), progress.show))
    progress.close()
    sys.stdout.write(f"{commit}\n{table(results)}\n")
    return 0 if all(map(is_well, results)) else 1


if __name__ == "__main__":
    sys.exit(main())
