"""`heave benchmark`: anyone's controller on the open benchmark of heave compensation, without ROS."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from heave_node.parameters import ParameterError

if TYPE_CHECKING:
    from heave_bringup.benchmark.case import Case
    from heave_bringup.benchmark.run import Result, Task

SUMMARY = "Run any controller on the open benchmark of heave compensation, without ROS, and print a table."
EXAMPLES = (
    "heave benchmark list",
    "heave benchmark run my_controller.py:MyController industrial --cases b3_deep_900 u2_hold --seeds 2",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument("action", choices=("run", "list"), help="run entrants, or list cases and entrants")
    parser.add_argument(
        "entrants",
        nargs="*",
        metavar="ENTRANT",
        help="FILE:Class, module:Class, or a shipped one (heave benchmark list)",
    )
    parser.add_argument("--cases", nargs="+", metavar="CASE", help="only these; * in a name matches anything")
    parser.add_argument("--seeds", type=int, metavar="N", help="only the first N of each case's seeds")
    parser.add_argument("--duration", type=float, metavar="S", help="end each run after S simulated seconds")
    parser.add_argument("--records", type=Path, metavar="DIR", help="folder of the published records of ship motion")
    parser.add_argument("--processes", type=int, metavar="N", help="default: one per processor")


def execute(options: argparse.Namespace) -> None:
    """List, or run every entrant on every case and print one table, as `options` say."""
    from heave_bringup.benchmark.records import HOW, records_folder
    from heave_bringup.benchmark.results import document, summarise, table
    from heave_bringup.benchmark.run import all_cases, check
    from heave_bringup.output import write_result

    folder = records_folder(options.records)
    cases = all_cases(folder)
    if options.action == "list":
        write_result(options, _listing(cases, folder), _listed(cases))
        return
    chosen = _chosen(cases, options.cases, folder)
    tasks = _tasks(options, chosen, folder)
    check(tasks)
    results = _run(tasks, options.processes)
    content = document(results, chosen)
    text = table(summarise(results), chosen)
    digests = f"problem digest {content['problem_digest']}   result digest {content['result_digest']}"
    left_out = [name for name in cases if not options.cases and name not in chosen]
    note = f"\nskipped, their records are not available:  {', '.join(left_out)}; {HOW}" if left_out else ""
    write_result(options, f"{text}\n\n{digests}{note}", content)


def _chosen(cases: Mapping[str, Case], names: Sequence[str] | None, folder: Path | None) -> dict[str, Case]:
    """Return the requested cases; by default all that can be run."""
    if not names:
        return {name: case for name, case in cases.items() if _is_at_hand(name, folder)}
    chosen: dict[str, Case] = {}
    for name in names:
        fitting = [case for case in cases if Path(case).match(name)]
        if not fitting:
            raise ParameterError(f"--cases {name}: no such case; known: {', '.join(cases)}")
        chosen |= {case: cases[case] for case in fitting}
    return chosen


def _is_at_hand(name: str, folder: Path | None) -> bool:
    from heave_bringup.benchmark.records import find_record

    return not name.startswith("z_") or find_record(folder, name.split("_")[1]) is not None


def _tasks(options: argparse.Namespace, cases: Mapping[str, Case], folder: Path | None) -> list[Task]:
    from heave_bringup.benchmark.entrants.table import Named
    from heave_bringup.benchmark.run import Task

    if not options.entrants:
        raise ParameterError("heave benchmark run: name at least one ENTRANT (heave benchmark list)")
    if options.seeds is not None and options.seeds < 1:
        raise ParameterError(f"--seeds {options.seeds}: must be at least 1")
    if options.processes is not None and options.processes < 1:
        raise ParameterError(f"--processes {options.processes}: must be at least 1")
    if options.duration is not None and not 0.0 < options.duration < math.inf:
        raise ParameterError(f"--duration {options.duration:g}: must be a number above 0 [s]")
    entrants = [Named(name) for name in dict.fromkeys(options.entrants)]
    return [
        Task(entrant, case.name, seed, options.duration, folder)
        for case in cases.values()
        for entrant in entrants
        for seed in case.seeds[: options.seeds]
    ]


def _run(tasks: Sequence[Task], processes: int | None) -> list[Result]:
    """Run all tasks; results in the order of the tasks, however they came."""
    from heave_bringup.benchmark.run import run_all
    from heave_bringup.progress import ProgressLine

    done = {}
    with ProgressLine() as progress, closing(run_all(tasks, processes)) as coming:
        progress.show(f"{len(tasks)} runs", 0.0)
        for result in coming:
            task = result.task
            done[task] = result
            words = f"run {len(done)} of {len(tasks)}: {task.entrant.short_name} on {task.case}, seed {task.seed}"
            progress.show(words, len(done) / len(tasks))
    return [done[task] for task in tasks]


def _listing(cases: Mapping[str, Case], folder: Path | None) -> str:
    from heave_bringup.benchmark.entrants.table import SHIPPED
    from heave_bringup.benchmark.records import HOW

    width = max(len(name) for name in (*cases, *SHIPPED))
    lines = ["cases"]
    for case in cases.values():
        missing = "" if _is_at_hand(case.name, folder) else "  *"
        seeds = "1 seed" if len(case.seeds) == 1 else f"{len(case.seeds)} seeds"
        lines.append(f"  {case.name.ljust(width)}  {seeds} of {case.duration:g} s: {case.title}{missing}")
    if any(line.endswith("*") for line in lines):
        lines.append(f"* its record of a ship's motion is not shipped: {HOW}")
    lines += ["entrants", *(f"  {name.ljust(width)}  {words}" for name, (_, words) in SHIPPED.items())]
    return "\n".join(lines)


def _listed(cases: Mapping[str, Case]) -> dict[str, object]:
    from heave_bringup.benchmark.entrants.table import SHIPPED

    return {
        "cases": [
            {
                "name": c.name,
                "title": c.title,
                "seeds": list(c.seeds),
                "duration": c.duration,
                "published_m": c.published,
            }
            for c in cases.values()
        ],
        "entrants": {name: words for name, (_, words) in SHIPPED.items()},
    }
