"""`heave falsify`: a search for the worst minute of a scenario that no alarm announces."""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from heave_bringup.commands.arguments import add_scenario
from heave_bringup.errors import CommandError, VerdictError
from heave_node.parameters import ParameterError

if TYPE_CHECKING:
    from heave_studies.falsify.search import Found, Search

SUMMARY = "Find the worst case without an alarm by varying sea, plant, faults and operator actions."
EXAMPLES = (
    "heave falsify b3_deep_900 --budget 3600",
    "heave falsify b2_calm_300 --space my_space.yaml --output my_search",
    "heave run falsify-b3_deep_900/worst_1.yaml          # the worst case again, with a bag and a report",
)

SPACE = "worst_case"
"""Campaign whose draws are searched where no other is named."""
JOURNAL = "journal.jsonl"
"""Name of the file with every answer, in the folder of the search."""
SHOWN_VALUES = 6
"""Values of a case that a table has room for; its scenario has all."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    add_scenario(parser)
    parser.add_argument(
        "--space",
        default=SPACE,
        metavar="CAMPAIGN",
        help=f"search space: the draws of this campaign (default: {SPACE})",
    )
    parser.add_argument(
        "--budget", type=float, default=600.0, metavar="S", help="wall time of the search (default: 600)"
    )
    parser.add_argument("--duration", type=float, metavar="S", help="simulated time per case, instead of the space's")
    parser.add_argument(
        "--population",
        type=int,
        metavar="N",
        help="cases per generation, instead of the draws' count",
    )
    parser.add_argument("--seed", type=int, metavar="N", help="seed of the search, instead of the draws'")
    parser.add_argument("--processes", type=int, metavar="N", help="default: one per processor")
    parser.add_argument(
        "--severity",
        default="medium",
        choices=("event", "low", "medium", "high", "critical"),
        help="lowest severity of an alarm that counts as a warning, in the worst minute or the one before "
        "(default: medium)",
    )
    parser.add_argument(
        "--bound", type=float, metavar="X", help="FAILED if the worst minute exceeds this ratio (default: 1.05)"
    )
    parser.add_argument(
        "--keep", type=int, default=3, metavar="N", help="number of worst cases to save as scenarios (default: 3)"
    )
    parser.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        help="folder for journal and scenarios (default: falsify-SCENARIO); repeat the command to resume",
    )


def execute(options: argparse.Namespace) -> None:
    """Search, write the worst cases, and report, as `options` say."""
    from heave_bringup.output import make_table, write_result
    from heave_bringup.progress import ProgressLine, time_to_go
    from heave_node.kpi import WORSE_RATIO

    _check(options)
    folder: Path = options.output or Path(f"falsify-{Path(options.scenario).stem}")
    search = _search(options, folder)
    with ProgressLine() as progress:

        def show(cases: int, worst: float, share: float) -> None:
            rest = time_to_go(share * options.budget, share) if share > 0.0 else ""
            progress.show(f"{cases} cases, worst minute {worst:.3f}, {rest}", share)

        is_whole = search.run(options.budget, options.processes, show)
    if not search.found:
        raise CommandError(f"--budget {options.budget:g}: no case was finished; give more time")
    if all(one.minute.failure for one in search.found):
        raise CommandError(f"none of {search.asked} cases could be run: {search.found[0].minute.failure}")
    files = [_write(search, one, folder / f"worst_{rank}.yaml") for rank, one in enumerate(_kept(search, options), 1)]
    rows = [
        [
            str(rank),
            f"{one.minute.ratio:.3f}",
            f"{one.minute.start:.0f}",
            f"{one.minute.of_all:.3f}",
            _short(one),
            str(file),
        ]
        for rank, (one, file) in enumerate(zip(_kept(search, options), files, strict=True), 1)
    ]
    bound, worst = options.bound or WORSE_RATIO, search.found[0].minute
    head = ("rank", "ratio", "from [s]", "of all", "case", "scenario")
    result = {
        "cases": search.asked,
        "failed": sum(bool(one.minute.failure) for one in search.found),
        "worst": [_json(one, file) for one, file in zip(_kept(search, options), files, strict=True)],
        "bound": bound,
        "generation_s": search.seconds,
    }
    told = [*_verdict(search, bound, is_whole=is_whole), f"journal   {(folder / JOURNAL).resolve()}"]
    write_result(options, [make_table(head, rows, texts=("case", "scenario")), "\n".join(told)], result)
    if worst.ratio > bound:
        raise VerdictError(
            [f"worst minute {worst.ratio:.3f} times uncompensated, without an alarm: heave run {files[0]}"]
        )


def _verdict(search: Search, bound: float, *, is_whole: bool) -> list[str]:
    """Return the verdict on a search in lines, with what it covers; `is_whole`: it has ended by itself."""
    worst = search.found[0].minute
    failed = sum(bool(one.minute.failure) for one in search.found)
    of = f"{search.generations}{', the population has converged' if is_whole else ''}; {failed} could not be run"
    lines = [
        f"verdict: {'FAILED' if worst.ratio > bound else 'passed'}; {of}",
        f"  worst minute without an alarm: {worst.ratio:.3f} times uncompensated (at most {bound:g})",
        f"  the worst of all minutes of that run: {worst.of_all_words}",
        "  heave run judges a case by the criteria of its scenario, not by this bound; worst 60 s of heave kpi is the "
        "worst of all minutes",
    ]
    if math.isfinite(search.seconds):
        lines.append(f"  a generation of {search.draws.count} cases takes about {search.seconds:.0f} s here")
    return lines


def _check(options: argparse.Namespace) -> None:
    for name in ("budget", "duration", "bound"):
        value = getattr(options, name)
        if value is not None and not value > 0.0:
            raise ParameterError(f"--{name} {value:g}: must be above 0")
    for name in ("population", "processes", "keep"):
        value = getattr(options, name)
        if value is not None and value < 1:
            raise ParameterError(f"--{name} {value}: must be at least 1")


def _search(options: argparse.Namespace, folder: Path) -> Search:
    """Return the search in a folder, which is made; raise ParameterError for what is wrong with it."""
    from heave_bags.record.provenance import git_commit
    from heave_node.interface.alarm import Severity

    from heave_studies.campaign.campaign_file import find_campaign, read_campaign, with_settings
    from heave_studies.campaign.journal import digest_of, mark_of
    from heave_studies.campaign.runs import make_tasks
    from heave_studies.falsify.search import Search, over_scenario, population

    space = over_scenario(read_campaign(find_campaign(options.space)), options.scenario)
    space = population(with_settings(space, options.set), options.population)
    space = space.shortened(duration=options.duration, draws=None)
    if options.seed is not None and space.draws is not None:
        space = replace(space, draws=replace(space.draws, seed=options.seed))
    tasks = make_tasks(space, list(space.cases()))
    digest = digest_of(tasks, git_commit(), [options.severity])
    folder.mkdir(parents=True, exist_ok=True)
    severity = Severity[options.severity.upper()]
    return Search(space, severity, folder / JOURNAL, mark_of(digest, has_baseline=False))


def _kept(search: Search, options: argparse.Namespace) -> list[Found]:
    return [one for one in search.found if one.minute.ratio > 0.0][: options.keep] or search.found[:1]


def _write(search: Search, found: Found, path: Path) -> Path:
    """Write a case as a scenario that `heave run` takes."""
    from heave_bringup.scenarios import write_scenario

    minute = found.minute
    title = (
        f"# Found by heave falsify: {minute.ratio:.3f} times uncompensated over the minute from {minute.start:g} s, "
        "without an alarm.\n"
    )
    write_scenario(path, title + search.task(found).text)
    return path


def _short(found: Found) -> str:
    """Return the first values of a case."""
    words = [
        f"{name.split('.', 1)[1]}={value:.3g}" if isinstance(value, float) else f"{name.split('.', 1)[1]}={value}"
        for name, value in found.values.items()
    ]
    return " ".join(words[:SHOWN_VALUES]) + (" ..." if len(words) > SHOWN_VALUES else "")


def _json(found: Found, file: Path) -> dict[str, object]:
    minute = found.minute
    return {
        "ratio": minute.ratio,
        "start_s": minute.start,
        "of_all": minute.of_all,
        "of_all_start_s": minute.of_all_start,
        "announced_by": list(minute.announced_by),
        "alarms": list(minute.alarms),
        "failure": minute.failure,
        "values": dict(found.values),
        "scenario": str(file),
    }
