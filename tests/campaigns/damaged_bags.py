"""Bags damaged by chance, and bags made to hurt, through every command that reads bags.

    python -m tests.campaigns.damaged_bags --count 1000

Of each bag it is checked that no command ends in a traceback or hangs, that none takes more memory than it may, and
that the loss that is stated equals the loss that is true. Prints a table and ends with status 1 where something is
wrong.
"""

from __future__ import annotations

import argparse
import json
import random
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "bags" / "test"))

from damages import KINDS, damage_one_file, read_all, stated_loss, true_loss
from foreign_bags import by_host_clock, write_foreign
from heave_bags.errors import BagError
from heave_bags.mcap.bag_writer import BagPolicy
from heave_bags.mcap.reader import Bag
from heave_bags.mcap.writer import ChunkPolicy
from heave_bringup.progress import ProgressLine
from hostile_bags import write_hostile_bags
from made_up_run import MadeUpRun, write_run
from memory import peak_memory

from tests.campaigns.in_process import Result, Watch, commit_line, heave, judge, run_batches, table, write_results

LONGEST = 120
"""Wall time after which a command is said to hang [s]."""
BATCH = 25
"""Bags for one process."""
_COUNTED = re.compile(r"with (\d+|an unknown number of) messages lost")


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


def campaign(count: int, processes: int, progress: Callable[[list[Result]], None]) -> list[Result]:
    """Run the hostile bags and `count` damaged ones; return what became of them."""
    with tempfile.TemporaryDirectory() as folder:
        base = Path(folder)
        sound = [str(path) for path in make_bags(base / "sound")]
        write_hostile_bags(base / "hostile")
        tasks = [["--hostile", str(base / "hostile")]]
        for first in range(0, count, BATCH):
            numbers = f"{first}:{min(first + BATCH, count)}"
            tasks.append(["--batch", numbers, str(base / f"batch-{first}"), *sound])
        return run_batches("tests.campaigns.damaged_bags", tasks, processes, progress)


def main() -> int:
    """Run the campaign from the command line."""
    parser = argparse.ArgumentParser(prog="damaged_bags", description=__doc__)
    parser.add_argument("--count", type=int, default=1000, help="damaged bags (default 1000)")
    parser.add_argument("--processes", type=int, default=2, help="at a time (default 2)")
    parser.add_argument("--batch", nargs="+", help=argparse.SUPPRESS)
    parser.add_argument("--hostile", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--results", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.hostile:
        return write_results(options.results, lambda: run_hostile(options.hostile))
    if options.batch:
        numbers, work, *sound = options.batch
        first, after = (int(part) for part in numbers.split(":"))
        paths = [Path(path) for path in sound]
        return write_results(options.results, lambda: run_batch(paths, range(first, after), Path(work)))
    with ProgressLine() as progress:
        results = campaign(options.count, options.processes, lambda found: progress.show(f"{len(found)} bags"))
    sys.stdout.write(f"{commit_line()}\n{table(results)}\n")
    return int(any(result.problems for result in results))


if __name__ == "__main__":
    sys.exit(main())
