"""Every fault in every mode: what the drum, the unit and the alarms do.

    python -m tests.campaigns.fault_matrix --cases 1000 --seed 20261201 --workers 2
    python -m tests.campaigns.fault_matrix --cases 200 --only "encoder freeze"
    python -m tests.campaigns.fault_matrix --print runs/fault_matrix/20261201-0123456789ab.jsonl

Drawn are: a kind of fault of a device (sensors, winch, orders on their way to the drive, clocks, nodes that end or
stall, an adviser that lies), its size and length; the moment at which it begins (standby, entry, compensating, a move,
fade_out, stopping, emergency_stop, manual, a landing, constant tension, lifting off); scenario, law and sea; and, in
half of the loops, one thing that is other than assumed. A case is fixed by seed and index; the seed is that of the day
where none is named. All kinds come equally often, and all moments. Four faults begin in copies of one loop.

Of each case: time to the alarm that names the part at fault, healthy parts that are blamed, time to rest, travel of the
drum until then over the heave of the rolling minute and 0.3 m, rate and travel over the envelope, motion of the unit
from 10 s after the fault over that of the locked one, tension. What was run stands in a journal: the same command goes
on where it was ended. Not here, for they need more than a process: links of a network, a PLC, a recorder.

Ends with status 1 where the promise is broken: drum within the envelope in all cases, travel in 99.9 %, unit at most
1.3 times the locked one in 99 %, part named in 97 % of the faults that show, a healthy part blamed in 1 % at most.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
import os
import signal
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from datetime import datetime, timezone
from functools import partial
from itertools import groupby
from pathlib import Path

from heave_bags.record.provenance import git_commit

from tests.campaigns.fault_matrix.cases import BRANCHES, Cell, cell
from tests.campaigns.fault_matrix.faults import KINDS
from tests.campaigns.fault_matrix.figures import BARS, COLUMNS, GROUPS, Ran, broken, kept, line, rows_by, worst
from tests.campaigns.fault_matrix.moments import MOMENTS
from tests.campaigns.fault_matrix.page import add
from tests.campaigns.fault_matrix.run import AFTER, Outcome, outcome_of, run_cells
from tests.campaigns.journal import ROOT, JournalError, JournalFile, sources_digest

FOLDER = Path("runs") / "fault_matrix"
"""Folder of journals."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the campaign; return 1 where the promise is broken, 130 where it was ended by Ctrl-C."""
    options = _parser().parse_args(arguments)
    try:
        journal = _journal(options)
    except JournalError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    seed, branches, after = (journal.heading[name] for name in ("seed", "branches", "after"))
    indices = sorted(journal.entries) if options.print else range(options.cases)
    wanted = [cell(seed, index, branches) for index in indices]
    wanted = [one for one in wanted if options.only is None or options.only in (one.fault.name, one.base.moment)]
    try:
        if not options.print:
            _run(wanted, options.workers, journal, after)
    except KeyboardInterrupt:
        return 130
    ran = [(one, _outcome(journal, one)) for one in wanted if journal.entries.get(one.index, ("",))[0] == one.words]
    sys.stdout.write(report(ran) + "\n")
    if options.results:
        add(options.results, journal.heading, ran)
    return 1 if broken(ran) else 0


def _outcome(journal: JournalFile, one: Cell) -> Outcome:
    return outcome_of(journal.entries[one.index][1])


def _journal(options: argparse.Namespace) -> JournalFile:
    if options.print:
        return JournalFile(options.print)
    digest = sources_digest(sorted(Path(__file__).parent.glob("*.py")))
    how = {name: getattr(options, name) for name in ("seed", "branches", "after")}
    path = options.journal or FOLDER / f"{'-'.join(f'{value:g}' for value in how.values())}-{digest}.jsonl"
    if options.fresh:
        path.unlink(missing_ok=True)
    return JournalFile(path, {"commit": git_commit(ROOT), "sources": digest, **how})


def _run(wanted: Sequence[Cell], workers: int, journal: JournalFile, after: float) -> None:
    """Run those of the `wanted` cases that the `journal` has not."""
    missing = [one for one in wanted if journal.entries.get(one.index, ("",))[0] != one.words]
    for one, found in _outcomes(missing, workers, after):
        journal.add(one.index, one.words, asdict(found))
        sys.stdout.write(line(one, found) + "\n")
        sys.stdout.flush()


def _outcomes(cells: Sequence[Cell], workers: int, after: float) -> Iterator[Ran]:
    if workers == 1:
        yield from run_cells(cells, after)
        return
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    loops = [list(group) for _, group in groupby(cells, key=lambda one: one.base.number)]
    with multiprocessing.get_context("spawn").Pool(workers, initializer=_begin) as pool:
        for group in pool.imap_unordered(partial(_run_loop, after=after), loops):
            yield from group


def _begin() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _run_loop(cells: Sequence[Cell], after: float) -> list[Ran]:
    return list(run_cells(cells, after))


def report(ran: Sequence[Ran]) -> str:
    """Return what all cases came to, in lines."""
    lines = ["", f"{len(ran)} cases, {sum(bool(found.failure) for _, found in ran)} could not be run"]
    for bar in BARS:
        good, asked = kept(bar, ran)
        share = 100.0 * good / asked if asked else math.nan
        lines.append(f"{bar.name}: {good} of {asked} = {share:.1f} %, promised {100 * bar.share:g} %")
    for group in GROUPS:
        rows = [[group, *COLUMNS], *rows_by(group, ran)]
        widths = [max(len(row[place]) for row in rows) for place in range(len(rows[0]))]
        lines += ["", *("  ".join(word.ljust(width) for word, width in zip(row, widths, strict=True)) for row in rows)]
    lines += ["", "the worst:", *(line(*one) + f"\n      {', '.join(one[1].alarms)}" for one in worst(ran))]
    return "\n".join([*lines, "", *(f"BROKEN: {words}" for words in broken(ran))])


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    today = int(datetime.now(timezone.utc).strftime("%Y%m%d"))
    names = [kind.name for kind in KINDS] + [moment.name for moment in MOMENTS]
    parser.add_argument("--cases", type=int, default=200, metavar="N", help="so many, from 0 on (default 200)")
    parser.add_argument("--seed", type=int, default=today, metavar="S", help="of the cases (default: of today)")
    parser.add_argument("--branches", type=int, default=BRANCHES, metavar="N", help="faults in copies of one loop")
    parser.add_argument(
        "--after", type=float, default=AFTER, metavar="S", help=f"time from the fault on (default {AFTER:g} s)"
    )
    parser.add_argument("--only", choices=names, metavar="KIND", help="of these, those of a kind of fault or a moment")
    parser.add_argument("--workers", type=int, default=1, metavar="N", help="processes (default 1)")
    parser.add_argument(
        "--journal", type=Path, metavar="FILE", help=f"journal (default: one in {FOLDER} for this code)"
    )
    parser.add_argument("--fresh", action="store_true", help="begin the journal anew")
    parser.add_argument("--print", type=Path, metavar="FILE", help="run nothing: print the figures of this journal")
    parser.add_argument("--results", type=Path, metavar="FILE", help="add the results to this file, see `page`")
    return parser


if __name__ == "__main__":
    sys.exit(main())
