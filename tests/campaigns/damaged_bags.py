"""Bags damaged by chance, and bags made to hurt, through every command that reads bags.

    python -m tests.campaigns.damaged_bags --count 1000

Of each bag it is checked that no command ends in a traceback or hangs, that none takes more memory than it may, and
that the loss that is stated equals the loss that is true. Prints a table and ends with status 1 where something is
wrong.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "bags" / "test"))

from damages import KINDS, damage_one_file, read_all, stated_loss, true_loss
from foreign_bags import by_host_clock, write_foreign
from heave_bags.errors import BagError
from heave_bags.mcap.bag_writer import BagPolicy
from heave_bags.mcap.reader import Bag
from heave_bags.mcap.writer import ChunkPolicy
from heave_bringup.progress import ProgressLine
from heave_node.ros.transport import parents_death
from hostile_bags import write_hostile_bags
from made_up_run import MadeUpRun, write_run
from memory import peak_memory

from tests.campaigns.commit import commit_line
from tests.campaigns.in_process import Watch, heave, judge

MEMORY = 500 << 20
"""Bytes that a process may take on any bag."""
LONGEST = 120
"""Wall time after which a command is said to hang [s]."""
BATCH = 25
"""Bags for one process."""
COMMANDS = ("reader", "kpi", "report", "import", "repair", "replay")
_COUNTED = re.compile(r"with (\d+|an unknown number of) messages lost")


@dataclass
class Result:
    """What became of one bag: what was wrong, by command; "" is never in it."""

    bag: str
    kind: str
    lost: int = 0
    wrong: dict[str, str] = field(default_factory=dict)
    memory: int = 0


def make_bags(folder: Path) -> list[Path]:
    """Write the sound bags: all compressions, many chunks and one, split, and one of another recorder."""
    policies = {
        "zstd": BagPolicy(ChunkPolicy(size=8_000)),
        "plain": BagPolicy(ChunkPolicy(size=8_000, compression="")),
        "split": BagPolicy(ChunkPolicy(size=20_000, compression="lz4"), max_file_bytes=40_000),
        "large": BagPolicy(ChunkPolicy(size=400_000)),
    }
    for name, policy in policies.items():
        write_run(folder / name, MadeUpRun(duration=20.0), policy)
    foreign = write_foreign(folder / "zstd", folder / "foreign", by_host_clock)
    _describe(foreign)
    return [*(folder / name for name in policies), foreign]


def _describe(folder: Path) -> None:
    """Write the metadata.yaml that another recorder would have written."""
    from heave_bags.mcap.repair import reindex  # noqa: PLC0415

    reindex(folder)


def run_batch(sound: Sequence[Path], numbers: range, work: Path) -> list[Result]:
    """Damage a bag for each number and give it to every command; in this process."""
    originals = {path: read_all(path)[0] for path in sound}
    results = []
    for number in numbers:
        chance = random.Random(number)
        kind = KINDS[number % len(KINDS)]
        source = sound[number // len(KINDS) % len(sound)]
        bag = work / f"{number}" / source.name
        shutil.copytree(source, bag)
        damage_one_file(bag, kind, chance)
        result = Result(f"{source.name} {number}", kind)
        _try_all(bag, result)
        with Watch(result.wrong, "reader", LONGEST):
            after, losses = read_all(bag)
            result.lost = true_loss(originals[source], after)
            if stated_loss(losses) != result.lost:
                result.wrong["reader"] = f"states {stated_loss(losses)}, lost {result.lost}"
        result.memory = peak_memory()
        results.append(result)
        shutil.rmtree(bag.parent)
    return results


def run_hostile(work: Path) -> list[Result]:
    """Give every hostile bag to every command; in this process."""
    results = []
    for bag in sorted(work.iterdir()):
        result = Result(bag.name, "hostile")
        with Watch(result.wrong, "reader", LONGEST):
            try:
                for topic in Bag(bag).topics:
                    Bag(bag).frame(topic)
            except BagError:
                pass
        _try_all(bag, result, may_state=False)
        result.memory = peak_memory()
        results.append(result)
    return results


def _try_all(bag: Path, result: Result, *, may_state: bool = True) -> None:
    out = Path(tempfile.mkdtemp())
    topic = "/boom_tip"
    arguments = {
        "kpi": ["kpi", str(bag), "--json", "-"],
        "report": ["report", str(bag), "--output", str(out / "report.html"), "--json", "-"],
        "import": ["import", str(bag), "--topic", topic, "--output", str(out / "sea.csv"), "--json", "-"],
        "repair": ["repair", str(bag), "--output", str(out / "saved"), "--json", "-"],
        "replay": ["replay", str(bag), "--delay", "0", "--rate", "100000", "--json", "-"],
    }
    for command, words in arguments.items():
        with Watch(result.wrong, command, LONGEST):
            status, said, complaint = heave(words)
            problem = judge(status, said, complaint)
            if problem:
                result.wrong[command] = problem
            elif may_state and status == 0 and command in ("kpi", "repair"):
                _compare(result, command, said, bag)
    shutil.rmtree(out)


def _compare(result: Result, command: str, said: str, bag: Path) -> None:
    """Hold what a command says of the loss against the reader, which is held against the truth."""
    losses = json.loads(said)["losses"]
    counts = [_COUNTED.search(text) for text in losses]
    stated = [match.group(1) if match else "nothing" for match in counts]
    of_reader = ["an unknown number of" if loss.messages is None else str(loss.messages) for loss in read_all(bag)[1]]
    if sorted(stated) != sorted(of_reader):
        result.wrong[command] = f"states {stated}, the reader {of_reader}"


def _in_child(task: Sequence[str], results: Path) -> subprocess.Popen[bytes]:
    command = parents_death.command("tests.campaigns.damaged_bags", *task, "--results", str(results))
    return subprocess.Popen(command, stderr=subprocess.PIPE, env={**os.environ, **parents_death.environment()})


def campaign(count: int, processes: int, progress: Callable[[str], None]) -> list[Result]:
    """Run the hostile bags and `count` damaged ones; return what became of them."""
    with tempfile.TemporaryDirectory() as folder:
        base = Path(folder)
        sound = make_bags(base / "sound")
        write_hostile_bags(base / "hostile")
        tasks = [["--hostile", str(base / "hostile")]]
        for first in range(0, count, BATCH):
            numbers = f"{first}:{min(first + BATCH, count)}"
            tasks.append(["--batch", numbers, str(base / f"batch-{first}"), *map(str, sound)])
        results: list[Result] = []
        running: list[tuple[subprocess.Popen[bytes], Path]] = []
        while tasks or running:
            while tasks and len(running) < processes:
                path = base / f"results-{len(tasks)}.json"
                running.append((_in_child(tasks.pop(0), path), path))
            running = [(child, path) for child, path in running if not _collect(child, path, results)]
            time.sleep(0.2)
            progress(f"{len(results)} bags")
    return results


def _collect(child: subprocess.Popen[bytes], path: Path, results: list[Result]) -> bool:
    """Take the results of a child that has ended; tell whether it has."""
    if child.poll() is None:
        return False
    assert child.stderr is not None
    said = child.stderr.read().decode(errors="replace")
    if child.returncode != 0 or not path.exists():
        results.append(Result("a process", "process", wrong={"all": f"ended with {child.returncode}: {said[-2000:]}"}))
        return True
    results += [Result(**entry) for entry in json.loads(path.read_text())]
    return True


def table(results: Sequence[Result]) -> str:
    """Return the results as a table."""
    lines = [f"{'damage':12}{'bags':>6}{'with loss':>11}{'messages lost':>15}{'wrong':>7}"]
    for kind in dict.fromkeys(result.kind for result in results):
        part = [result for result in results if result.kind == kind]
        wrong = sum(1 for result in part if result.wrong)
        hit = sum(1 for result in part if result.lost)
        lost = sum(result.lost for result in part)
        lines.append(f"{kind:12}{len(part):6}{hit:11}{lost:15}{wrong:7}")
    peak = max((result.memory for result in results), default=0)
    lines.append(f"commands: {', '.join(COMMANDS)}; most memory of a process: {peak / (1 << 20):.0f} MB")
    for result in results:
        lines += [f"{result.kind}: {result.bag}: {command}: {text}" for command, text in result.wrong.items()]
    tally = Counter(command for result in results for command in result.wrong)
    return "\n".join([*lines, f"wrong: {dict(tally) or 'nothing'}"])


def _child(options: argparse.Namespace) -> None:
    resource.setrlimit(resource.RLIMIT_DATA, (2 * MEMORY, 2 * MEMORY))  # what is asked for; what is used is measured
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    if options.hostile:
        results = run_hostile(options.hostile)
    else:
        numbers, work, *sound = options.batch
        first, after = (int(part) for part in numbers.split(":"))
        results = run_batch([Path(path) for path in sound], range(first, after), Path(work))
    options.results.write_text(json.dumps([asdict(result) for result in results]))


def main() -> int:
    """Run the campaign from the command line."""
    parser = argparse.ArgumentParser(prog="damaged_bags", description=__doc__)
    parser.add_argument("--count", type=int, default=1000, help="damaged bags (default 1000)")
    parser.add_argument("--processes", type=int, default=2, help="at a time (default 2)")
    parser.add_argument("--batch", nargs="+", help=argparse.SUPPRESS)
    parser.add_argument("--hostile", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--results", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.results:
        _child(options)
        return 0
    progress = ProgressLine()
    results = campaign(options.count, options.processes, progress.show)
    progress.close()
    sys.stdout.write(f"{commit_line()}\n{table(results)}\n")
    is_small = max(result.memory for result in results) < MEMORY
    return 0 if is_small and not any(result.wrong for result in results) else 1


if __name__ == "__main__":
    sys.exit(main())
