"""Scenarios, tables of cases and attachments of bags, changed by chance and by intent, through the commands that read
them.

    python -m tests.campaigns.hostile_files --count 1000

Of each file it is checked that no command ends in a traceback, that none takes more memory or more time of a processor
than it may, and that nothing is written outside the folder that a command was given. Prints a table and ends with
status 1 where something is wrong.
"""

from __future__ import annotations

import argparse
import random
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "bags" / "test"))

from heave_bringup.progress import ProgressLine
from made_up_run import MadeUpRun, write_run
from memory import peak_memory

from tests.campaigns.hostile_texts import changed_scenario, changed_table
from tests.campaigns.in_process import (
    Result,
    Watch,
    commit_line,
    heave,
    in_a_fork,
    judge,
    run_batches,
    table,
    write_results,
)

LONGEST = 5.0
"""Time of a processor that a command may take on a file [s]."""
HANGING = 900
"""Wall time after which a command is said to hang [s]: on a busy machine, at the lowest priority, one takes minutes."""
BATCH = 50
"""Files for one process."""
ELSEWHERE = (Path("/tmp/heave-hostile"), Path("/tmp/heave-hostile.csv"), Path("/tmp/hostile"))
"""Files that the changed tables would write, if they could."""
KINDS = ("scenario", "table", "attachment")


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
    """Make the file of a `number` in the folder `work` and give it to every command that reads it.

    Each in a process of its own, whose memory is counted from there.
    """
    kind = KINDS[number % len(KINDS)]
    folder = work / f"{number}"
    (folder / "out").mkdir(parents=True)
    file = in_a_fork(lambda: make_file(kind, random.Random(number), folder))
    result = in_a_fork(lambda: _try(Result(str(number), kind), file, folder))
    shutil.rmtree(folder)
    return result if isinstance(result, Result) else Result(str(number), kind, {"all": f"ended with {result}"})


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
        if result.longest > LONGEST:
            result.wrong["time"] = f"{result.longest:.1f} s of a processor"
    strange = _listing(folder.parent, out) - before - {str(file.with_name(f"{file.name}.baseline.npz"))}
    strange |= {str(path) for path in ELSEWHERE if path.exists()}
    if strange:
        result.wrong["files"] = f"wrote {sorted(strange)[:3]}"
    result.memory = peak_memory()
    return result


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
    """Try `count` files, beginning with the number `first`; each batch in a process of its own."""
    begins = range(first, first + count, BATCH)
    tasks = [["--batch", f"{begin}:{min(begin + BATCH, first + count)}"] for begin in begins]
    return run_batches("tests.campaigns.hostile_files", tasks, 1, progress)


def main() -> int:
    """Run the campaign from the command line."""
    parser = argparse.ArgumentParser(prog="hostile_files", description=__doc__)
    parser.add_argument("--count", type=int, default=1000, help="files (default 1000)")
    parser.add_argument("--first", type=int, default=0, help="number of the first (default 0)")
    parser.add_argument("--batch", help=argparse.SUPPRESS)
    parser.add_argument("--results", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.batch:
        numbers = range(*(int(part) for part in options.batch.split(":")))
        with tempfile.TemporaryDirectory() as work:
            return write_results(options.results, lambda: run_batch(numbers, Path(work)))
    with ProgressLine() as progress:
        results = campaign(
            options.count, lambda found: progress.show(f"{len(found)} of {options.count} files"), options.first
        )
    sys.stdout.write(f"{commit_line()}\n{table(results)}\n")
    return int(any(result.problems for result in results))


if __name__ == "__main__":
    sys.exit(main())
