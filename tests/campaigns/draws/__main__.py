"""The promise as a distribution, on draws that nobody tuned to.

    python -m tests.campaigns.draws --kind few --draws 512
    python -m tests.campaigns.draws --kind stacked --draws 40 --seed 20261126 --workers 1
    python -m tests.campaigns.draws --print runs/draws/few-20261126-0123456789ab.jsonl --against BEFORE.jsonl
    python -m tests.campaigns.draws --kind stacked --draws 64 --without "sensor noise"

few: one or two things differ from the nominal. stacked: three to five. seas: another sea alone. lifts: another lift, of
which the controller knows all. In a third of the draws of few and stacked an operation is under way as well: a move, an
operator's speed, changes of the factor, a stop and a restart, a sea that grows or slews. What can differ stands in
`table.py`. A draw is fixed by kind, seed and index: two versions of the controller meet the same cases. The seed is
that of the day where none is named.

Each case is 390 s of the loop in one process. What was run stands in a journal: the same command goes on where it was
ended, --print prints its figures again, --against compares it draw by draw with that of another version. The worst
minute over off begins 30 s after compensation did; 30 s after a fault begins or ends, and a requested stop, are not
judged.

Ends with status 1 where the promise is broken. few, seas, lifts: at most 1.05 in 97 %, at most 1.2 in 99.5 %, none
lost, healthy parts blamed and never begun without a true reason in 1 % each. stacked: at most 1.05 in 85 %, 1.5 in
97 %, and never without an alarm. Efficiency at least 0.95 of that of an informed controller (--informed).
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from datetime import datetime, timezone
from multiprocessing import TimeoutError as LateError
from pathlib import Path

from heave_bags.record.provenance import git_commit

from tests.campaigns.draws.ablation import ALL
from tests.campaigns.draws.cases import KINDS, draw
from tests.campaigns.draws.figures import Drawn, as_values, broken, comparison, figures_of, line, table, worst_first
from tests.campaigns.draws.journal import Heading, Journal, sources_digest
from tests.campaigns.draws.workers import Task, run_tasks
from tests.campaigns.journal import ROOT, JournalError

FOLDER = Path("runs") / "draws"
"""Folder of journals."""

SHOWN = 5
"""Number of the worst draws that are printed at the end."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the campaign; return 1 where the promise is broken, 130 where it was ended by Ctrl-C."""
    options = _parser().parse_args(arguments)
    try:
        journal = _journal(options)
        before = Journal(options.against) if options.against else None
        if before is not None and before.heading.draws != journal.heading.draws:
            raise JournalError(f"--against {options.against}: is of other draws: {before.heading}")
    except JournalError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    out = sys.stderr if options.json else sys.stdout
    heading = journal.heading
    out.write(f"commit {heading.commit or 'unknown'}, sources {heading.sources}, seed {heading.day}")
    out.write(f", latency {heading.latency or 'as it is'}")
    out.write(f", without {heading.without}\n" if heading.without else "\n")
    wanted = options.only or (sorted(journal.outcomes) if options.print else range(options.draws))
    status = 0
    try:
        for index in [] if options.print else _run(wanted, options.workers, journal):
            out.write(line(draw(heading.kind, heading.day, index), journal.outcomes[index]) + "\n")
            out.flush()
    except KeyboardInterrupt:
        status = 130
    except LateError:
        out.write("a worker has ended without an answer: run the same command again to go on\n")
        status = 2
    drawn = [
        (draw(heading.kind, heading.day, index), journal.outcomes[index])
        for index in wanted
        if index in journal.outcomes
    ]
    if not drawn:
        return status or 2
    if status:
        return status
    if before is not None and not options.json:
        out.write("\n" + comparison(drawn, before.outcomes) + "\n")
    return _report(heading, drawn, is_json=options.json, is_loud=options.alarms)


def _report(heading: Heading, drawn: Sequence[Drawn], *, is_json: bool, is_loud: bool) -> int:
    """Print the figures of what was `drawn`; return 1 where the promise is broken."""
    figures = figures_of(drawn)
    breaches = broken(heading.kind, figures)
    if is_json:
        values = {"commit": heading.commit, "sources": heading.sources, "seed": heading.day, "latency": heading.latency}
        sys.stdout.write(json.dumps({**values, **as_values(heading.kind, figures)}) + "\n")
        return 1 if breaches else 0
    shown = drawn if is_loud else worst_first(drawn)[:SHOWN]
    lines = ["", f"the worst {len(shown)}:" if not is_loud else "all:"]
    for case, found in shown:
        lines.append(line(case, found))
        lines += [f"      {at:.1f} s: {words}" for at, words in found.alarms] if is_loud else []
    lines += [f"not begun: {line(*one)}" for one in drawn if one[1].reason]
    verdict = [f"  BROKEN: {words}" for words in breaches] or ["  kept"]
    sys.stdout.write("\n".join([*lines, "", table(heading.kind, figures), *verdict]) + "\n")
    return 1 if breaches else 0


def _journal(options: argparse.Namespace) -> Journal:
    """Return the journal that the `options` ask for."""
    if options.print:
        return Journal(options.print)
    heading = Heading(
        git_commit(ROOT),
        sources_digest(),
        options.kind,
        options.seed,
        options.latency or "",
        options.told,
        options.without or "",
    )
    path = options.journal or FOLDER / heading.file_name
    if options.fresh:
        path.unlink(missing_ok=True)
    return Journal(path, heading)


def _run(wanted: Sequence[int], workers: int, journal: Journal) -> Iterator[int]:
    """Run those of the `wanted` draws that the `journal` has not, and return their numbers as they are done."""
    heading = journal.heading
    tasks = [
        Task(draw(heading.kind, heading.day, index), heading.is_informed)
        for index in wanted
        if index not in journal.outcomes
    ]
    for case, found in run_tasks(tasks, workers, heading.latency, heading.without):
        journal.add(case, found)
        yield case.index


def _numbers(text: str) -> list[int]:
    return [int(number) for number in text.split(",")]


def _latency(text: str) -> str:
    return f"{float(text):g}"


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    today = int(datetime.now(timezone.utc).strftime("%Y%m%d"))
    parser.add_argument("--kind", choices=tuple(KINDS), default="few")
    parser.add_argument("--draws", type=int, default=512, metavar="N", help="so many, from 0 on (default 512)")
    parser.add_argument("--seed", type=int, default=today, metavar="DAY", help="of the draws (default: of today)")
    parser.add_argument("--only", type=_numbers, metavar="I,J", help="these draws")
    parser.add_argument("--workers", type=int, default=2, metavar="N", help="processes (default 2)")
    parser.add_argument(
        "--latency",
        type=_latency,
        metavar="S",
        help="time until what is found takes effect [s]",
    )
    parser.add_argument("--without", choices=tuple(ALL), help="a part of the controller that is switched off")
    parser.add_argument("--told", action="store_true", help="also run those that can be with a controller that is told")
    parser.add_argument("--alarms", action="store_true", help="print all draws and all alarms at the end")
    parser.add_argument(
        "--journal", type=Path, metavar="FILE", help=f"journal (default: one in {FOLDER} for this code)"
    )
    parser.add_argument("--fresh", action="store_true", help="begin the journal anew")
    parser.add_argument("--print", type=Path, metavar="FILE", help="run nothing: print the figures of this journal")
    parser.add_argument("--against", type=Path, metavar="FILE", help="compare with this journal, draw by draw")
    parser.add_argument("--json", action="store_true", help="figures as JSON on standard output, progress on the other")
    return parser


if __name__ == "__main__":
    sys.exit(main())
