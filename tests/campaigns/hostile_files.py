"""Scenarios, tables of cases and attachments of bags, changed by chance and by intent, through the commands that read
them.

    python -m tests.campaigns.hostile_files --count 1000

Of each file it is checked that no command ends in a traceback, that none takes more memory or more time of a processor
than it may, and that nothing is written outside the folder that a command was given. Prints a table and ends with
status 1 where something is wrong.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[2] / "bags" / "test"))

from heave_bringup.progress import ProgressLine
from heave_node.ros.transport import parents_death
from made_up_run import MadeUpRun, write_run
from memory import peak_memory

from tests.campaigns.commit import commit_line
from tests.campaigns.hostile_texts import changed_scenario, changed_table
from tests.campaigns.in_process import Watch, heave, judge

MEMORY = 500 << 20
"""Bytes that a process may take on any file."""
LONGEST = 5.0
"""Time of a processor that a command may take on a file [s]."""
HANGING = 900
"""Wall time after which a command is said to hang [s]: on a busy machine, at the lowest priority, one takes minutes."""
BATCH = 50
"""Files for one process."""
ELSEWHERE = (Path("/tmp/heave-hostile"), Path("/tmp/heave-hostile.csv"), Path("/tmp/hostile"))
"""Files that the changed tables would write, if they could."""
KINDS = ("scenario", "table", "attachment")


@dataclass
class Result:
    """What became of one file: what was wrong, by command; the longest command [s of a processor], and the memory."""

    number: int
    kind: str
    wrong: dict[str, str] = field(default_factory=dict)
    refused: bool = False
    longest: float = 0.0
    memory: int = 0


def commands_of(kind: str, file: Path, out: Path) -> dict[str, list[str]]:
    """Return the commands that read a file of a `kind`, by name; they write to the folder `out`."""
    if kind == "attachment":
        report = ["report", str(file), "--output", str(out / "report.html"), "--json", "-"]
        return {"kpi": ["kpi", str(file), "--json", "-"], "report": report}
    name = f"{file}:1" if kind == "table" else str(file)
    commands = {
        "new": ["new", str(out / "own.yaml"), "--like", name, "--json", "-"],
        "static": ["static", name, "--picture", str(out / "static.svg"), "--json", "-"],
    }
    return commands | ({"extremes": ["extremes", str(file), "--json", "-"]} if kind == "table" else {})


def make_file(kind: str, chance: random.Random, folder: Path) -> Path:
    """Write a changed file of a `kind` into a `folder` by `chance`; return its path."""
    if kind == "table":
        return changed_table(chance, folder / "own.parquet")
    content = changed_scenario(chance)
    if kind == "scenario":
        (folder / "own.yaml").write_bytes(content)
        return folder / "own.yaml"
    write_run(folder / "bag", MadeUpRun(duration=20.0), scenario=content)
    return folder / "bag"


def try_file(number: int, work: Path) -> Result:
    """Make the file of a `number` in the folder `work` and give it to every command that reads it, in processes."""
    kind = KINDS[number % len(KINDS)]
    folder = work / f"{number}"
    (folder / "out").mkdir(parents=True)
    file = _in_a_fork(lambda: make_file(kind, random.Random(number), folder))
    result = _in_a_fork(lambda: _try(Result(number, kind), file, folder))
    shutil.rmtree(folder)
    return result if isinstance(result, Result) else Result(number, kind, {"all": str(result)})


def _try(result: Result, file: Path, folder: Path) -> Result:
    out = folder / "out"
    before = _listing(folder.parent, out)
    for command, words in commands_of(result.kind, file, out).items():
        begun = time.process_time()
        with Watch(result.wrong, command, HANGING):
            status, said, complaint = heave(words)
            result.refused |= status != 0
            problem = judge(status, said, complaint)
            if problem:
                result.wrong[command] = problem
        result.longest = max(result.longest, time.process_time() - begun)
    strange = _listing(folder.parent, out) - before - {str(file.with_name(f"{file.name}.baseline.npz"))}
    strange |= {str(path) for path in ELSEWHERE if path.exists()}
    if strange:
        result.wrong["files"] = f"wrote {sorted(strange)[:3]}"
    result.memory = peak_memory()
    return result


def _in_a_fork(task: Callable[[], Any]) -> Any:
    """Return what a task gives in a process of its own, or in words how that ended: memory is counted from here."""
    ours, theirs = multiprocessing.Pipe(duplex=False)
    child = multiprocessing.get_context("fork").Process(target=lambda: theirs.send(task()))
    child.start()
    theirs.close()
    try:
        return ours.recv()
    except EOFError:
        child.join()
        return f"the process ended with {child.exitcode}"
    finally:
        child.join()


def _listing(work: Path, out: Path) -> set[str]:
    """Return what there is below a folder `work`, but for the folder `out` that a command may write to."""
    return {str(path) for path in work.rglob("*") if out not in path.parents}


def warm_up(work: Path) -> None:
    """Give sound files to every command: compiled code is loaded, and does not count for a file."""
    from heave_bringup.scenarios import shipped_scenarios  # noqa: PLC0415 - after the limits are set

    work.mkdir(exist_ok=True)
    for name in ("unit_1500", "b1_thesis", "b4_limit_900_tp8"):
        for words in commands_of("scenario", shipped_scenarios()[name], work).values():
            heave([*words, *(["--force"] if words[0] == "new" else [])])
    scenario = shipped_scenarios()["unit_1500"].read_bytes()
    write_run(work / "bag", MadeUpRun(duration=20.0), scenario=scenario)
    heave(["report", str(work / "bag"), "--output", str(work / "report.html"), "--json", "-"])
    heave(["kpi", str(work / "bag"), "--json", "-"])
    shutil.rmtree(work)


def run_batch(numbers: range, work: Path) -> list[Result]:
    """Try the files of these `numbers`; in this process."""
    warm_up(work / "warm")
    return [try_file(number, work) for number in numbers]


def campaign(count: int, progress: Callable[[list[Result]], None], first: int = 0) -> list[Result]:
    """Try `count` files, beginning with the number `first`; each batch in a process of its own.

    After each batch `progress` is given the results so far.
    """
    results: list[Result] = []
    for begin in range(first, first + count, BATCH):
        with tempfile.TemporaryDirectory() as folder:
            numbers = f"{begin}:{min(begin + BATCH, first + count)}"
            path = Path(folder) / "results.json"
            command = parents_death.command("tests.campaigns.hostile_files", "--batch", numbers, "--results", str(path))
            environment, root = {**os.environ, **parents_death.environment()}, Path(__file__).parents[2]
            done = subprocess.run(command, stderr=subprocess.PIPE, cwd=root, env=environment, check=False)
            if path.exists():
                results += [Result(**entry) for entry in json.loads(path.read_text())]
            else:
                said = done.stderr.decode(errors="replace")[-2000:]
                results.append(Result(begin, "process", {"all": f"ended with {done.returncode}: {said}"}))
        progress(results)
    return results


def problems(result: Result) -> dict[str, str]:
    """Return what was wrong with a file, time and memory among it, by command."""
    found = dict(result.wrong)
    if result.longest > LONGEST:
        found["time"] = f"{result.longest:.1f} s of a processor"
    if result.memory > MEMORY:
        found["memory"] = f"{result.memory / 2**20:.0f} MB"
    return found


def table(results: Sequence[Result]) -> str:
    """Return the results as a table."""
    lines = [f"{'file':12}{'tried':>7}{'refused':>9}{'longest s':>11}{'most MB':>9}{'wrong':>7}"]
    for kind in dict.fromkeys(result.kind for result in results):
        part = [result for result in results if result.kind == kind]
        refused, wrong = sum(result.refused for result in part), sum(bool(problems(result)) for result in part)
        longest, memory = max(result.longest for result in part), max(result.memory for result in part) / 2**20
        lines.append(f"{kind:12}{len(part):7}{refused:9}{longest:11.1f}{memory:9.0f}{wrong:7}")
    return "\n".join([*lines, *wrong_ones(results)])


def wrong_ones(results: Iterable[Result]) -> list[str]:
    """Return a line for each thing that is wrong."""
    return [f"{one.kind} {one.number}: {where}: {text}" for one in results for where, text in problems(one).items()]


def _child(options: argparse.Namespace) -> None:
    resource.setrlimit(resource.RLIMIT_DATA, (2 * MEMORY, 2 * MEMORY))  # what is asked for; what is used is measured
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    first, after = (int(part) for part in options.batch.split(":"))
    work = options.results.parent / "work"
    work.mkdir()
    options.results.write_text(json.dumps([asdict(result) for result in run_batch(range(first, after), work)]))


def main() -> int:
    """Run the campaign from the command line."""
    parser = argparse.ArgumentParser(prog="hostile_files", description=__doc__)
    parser.add_argument("--count", type=int, default=1000, help="files (default 1000)")
    parser.add_argument("--first", type=int, default=0, help="number of the first (default 0)")
    parser.add_argument("--batch", help=argparse.SUPPRESS)
    parser.add_argument("--results", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.results:
        _child(options)
        return 0
    progress, told = ProgressLine(), set[str]()

    def tell(results: list[Result]) -> None:
        for line in wrong_ones(results):
            if line not in told:
                progress.tell(line)
        told.update(wrong_ones(results))
        progress.show(f"{len(results)} of {options.count} files")

    results = campaign(options.count, tell, options.first)
    progress.close()
    sys.stdout.write(f"{commit_line()}\n{table(results)}\n")
    return 1 if any(problems(result) for result in results) else 0


if __name__ == "__main__":
    sys.exit(main())
