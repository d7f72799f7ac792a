"""Every fault in every mode: what the drum, the unit and the alarms do.

    python -m tests.campaigns.fault_matrix --cases 1000 --seed 20261201 --workers 2
    python -m tests.campaigns.fault_matrix --cases 200 --only "encoder freeze"

Drawn are: a kind of fault of a device (sensors, winch, orders on their way to the drive, clocks, nodes that end or
stall, an adviser that lies), its size and length; the moment at which it begins (standby, entry, compensating, a move,
fade_out, stopping, emergency_stop, manual, a landing, constant tension, lifting off); scenario, law and sea; and, in
half of the loops, one thing that is other than assumed. A case is fixed by seed and index; the seed is that of the day
where none is named. All kinds come equally often, and all moments. Four faults begin in copies of one loop.

Of each case: time to the alarm that names the part at fault, healthy parts that are blamed, time to rest, travel of the
drum until then over the heave of the rolling minute and 0.3 m, rate and travel over the envelope, motion of the unit
from 10 s after the fault over that of the locked one, tension. Where the unit moves more than it may, or the drum goes
further, the same run is done without the fault, with an emergency stop where the drum was stopped at once: what
a load does that is let go is no fault's. What was run stands in a journal in `runs/fault_matrix`:
the same command on the same sources goes on where it was ended, and only prints where all is there. Not here, for they
need more than a process: links of a network, a PLC, a recorder.

Ends with status 1 where the promise is broken: drum within the envelope in all cases, travel in 99.9 %, unit at most
1.3 times the locked one in 99 %, part named in 97 % of the faults that show, a healthy part blamed in 1 % at most.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import sys
from collections.abc import Sequence
from dataclasses import asdict
from datetime import datetime, timezone
from pathlib import Path

from heave_bags.record.provenance import git_commit

from tests.campaigns.fault_matrix.cases import BRANCHES, cell
from tests.campaigns.fault_matrix.faults import KINDS
from tests.campaigns.fault_matrix.figures import BARS, COLUMNS, GROUPS, Ran, broken, kept, line, rows_by, worst
from tests.campaigns.fault_matrix.moments import MOMENTS
from tests.campaigns.fault_matrix.page import ROOT, add
from tests.campaigns.fault_matrix.run import AFTER, outcome_of, run_in_processes

FOLDER = Path("runs") / "fault_matrix"
"""Folder of journals."""

PACKAGES = ("core", "node_base", "wave_vessel_node", "cable_sim_node", "winch_controller_node", "bringup/heave_bringup")
"""Places of the code that an outcome depends on, beside this package."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the campaign; return 1 where the promise is broken, 130 where it was ended by Ctrl-C."""
    options = _parser().parse_args(arguments)
    wanted = [cell(options.seed, index, options.branches) for index in range(options.cases)]
    wanted = [one for one in wanted if options.only is None or options.only in (one.fault.name, one.base.moment)]
    how = {name: getattr(options, name) for name in ("seed", "branches", "after")}
    journal = FOLDER / f"{'-'.join(f'{value:.10g}' for value in how.values())}-{sources_digest()}.jsonl"
    known = read_journal(journal)
    try:
        with journal.open("a", encoding="utf-8") as file:
            left = [one for one in wanted if one.words not in known]
            for one, found in run_in_processes(left, options.after, options.workers):
                known[one.words] = asdict(found)
                # a line of its own, also after one that was not finished
                file.write("\n" + json.dumps([one.words, known[one.words]]) + "\n")
                file.flush()
                print(line(one, found), flush=True)  # noqa: T201
    except KeyboardInterrupt:
        return 130
    ran = [(one, outcome_of(known[one.words])) for one in wanted]
    print(report(ran))  # noqa: T201
    if options.results:
        add(options.results, {"commit": git_commit(ROOT), **how}, ran)
    return 1 if broken(ran) else 0


def read_journal(path: Path) -> dict[str, dict[str, object]]:
    """Return what a journal has of each case, by its words; the journal is made where there is none."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.touch()
    lines = path.read_text(encoding="utf-8").splitlines()
    # a line without its end was being written when the campaign was ended
    return dict(json.loads(text) for text in lines if text.endswith("}]"))


def sources_digest() -> str:
    """Return a digest of the sources that outcomes depend on, by which two commits with changes are distinguished."""
    digest = hashlib.sha256()
    folders = [*(ROOT / package for package in PACKAGES), Path(__file__).parent]
    for path in (path for folder in folders for path in sorted(folder.rglob("*"))):
        if path.suffix in (".py", ".cpp", ".h", ".yaml") and "test" not in path.parts:
            digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


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
    parser.add_argument("--after", type=float, default=AFTER, metavar="S", help=f"time watched (default {AFTER:g} s)")
    parser.add_argument("--only", choices=names, metavar="KIND", help="of these, those of a kind of fault or a moment")
    parser.add_argument("--workers", type=int, default=1, metavar="N", help="processes (default 1)")
    parser.add_argument("--results", type=Path, metavar="FILE", help="add the results to this file, see `page`")
    return parser


if __name__ == "__main__":
    sys.exit(main())
