"""Changes the modules that safety rests on, one small thing at a time, and counts the changes that no test notices.

    python -m tests.campaigns.mutants                          # make mutants
    python -m tests.campaigns.mutants --only guard --sample 50 --seed 3

Comparisons, conditions, arithmetic, numbers and statements are changed (`mutations`), in memory only. Every verdict
goes to the journal at once; what has a verdict for the same text of module and tests is not tried again. With
`--only-survivors` a change that was caught is not tried again either where tests were added since: they take none away.
Prints a table and what survived, and ends with status 1 where a module's tests notice less than 90 % of its changes.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import random
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from heave_bringup.progress import ProgressLine

from tests.campaigns.commit import commit_line
from tests.campaigns.mutants import compiled, mutations
from tests.campaigns.mutants.compiled import CompiledJudge
from tests.campaigns.mutants.judge import ROOT, Judge, Verdict
from tests.campaigns.mutants.mutations import Mutation
from tests.campaigns.mutants.subjects import SUBJECTS, Subject

LEAST = 0.9
"""Share of the changes of a module that its tests have to notice."""

Tried = list[tuple[Mutation, Verdict]]


class Digests(NamedTuple):
    """Of the text of a module, and of that and its tests."""

    module: str
    every: str


class Journal:
    """The verdicts so far, one a line of a file.

    Parameters
    ----------
    path : of the file; made with its folder where there is none
    keeps_caught : what was caught stays so, whatever has become of the tests
    """

    def __init__(self, path: Path, *, keeps_caught: bool = False) -> None:
        self._path, self._keeps_caught = path, keeps_caught
        path.parent.mkdir(parents=True, exist_ok=True)
        lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
        self._known: dict[tuple[str, int], Verdict] = {}
        for entry in map(json.loads, lines):
            verdict = Verdict(entry["outcome"], entry["by"])
            self._known[entry["digest"], entry["number"]] = verdict
            if verdict.is_caught:
                self._known[entry["module_digest"], entry["number"]] = verdict

    def get(self, digests: Digests, mutation: Mutation) -> Verdict | None:
        """Return the verdict on a `mutation` of the texts with these `digests`; None: it has none."""
        known = self._known.get((digests.every, mutation.number))
        if known is None and self._keeps_caught:
            return self._known.get((digests.module, mutation.number))
        return known

    def add(self, module: str, digests: Digests, mutation: Mutation, verdict: Verdict) -> None:
        """Note a `verdict` on a `mutation` of a `module`, whose texts have these `digests`."""
        entry: dict[str, Any] = {"module": module, "digest": digests.every, "module_digest": digests.module}
        entry |= {"number": mutation.number}
        entry |= {"change": str(mutation), "outcome": verdict.outcome, "by": verdict.by}
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(entry) + "\n")


def judge_of(subject: Subject) -> tuple[Judge | CompiledJudge, list[Mutation]]:
    """Return who judges a `subject`, and every mutation of it."""
    if subject.module.endswith(".cpp"):
        of_file = CompiledJudge(*subject)
        return of_file, compiled.mutations_of(of_file.source)
    judge = Judge(*subject)
    return judge, mutations.mutations_of(judge.source)


def digests_of(judge: Judge | CompiledJudge, subject: Subject) -> Digests:
    """Return the digests of what a `judge` has of a `subject`."""
    rules = "compiled.py" if subject.module.endswith(".cpp") else "mutations.py"
    texts = [judge.source, Path(__file__).with_name(rules).read_text(encoding="utf-8")]
    tests = [(ROOT / test).read_text(encoding="utf-8") for test in subject.tests]
    return Digests(_digest(texts), _digest([*texts, *tests]))


def _digest(texts: Iterable[str]) -> str:
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()[:16]


def try_subject(
    subject: Subject, chosen: Callable[[list[Mutation]], list[Mutation]], journal: Journal, until: float
) -> Iterator[tuple[int, Tried]]:
    """Judge the mutations of a `subject`, and yield again and again how many there are, and those with a verdict.

    Parameters
    ----------
    subject : module and tests
    chosen : returns those that are tried, in their order
    journal : of verdicts
    until : monotonic time from which on no further one is tried [s]
    """
    judge, every = judge_of(subject)
    digests = digests_of(judge, subject)
    tried: Tried = []
    has_learnt = False
    for mutation in chosen(every):
        verdict = journal.get(digests, mutation)
        if verdict is None:
            if time.monotonic() > until:
                break
            if not has_learnt:
                judge.learn()
                has_learnt = True
            verdict = judge.judge(mutation)
            journal.add(subject.module, digests, mutation, verdict)
        tried.append((mutation, verdict))
        yield len(every), tried


def table(results: dict[str, tuple[int, Tried]]) -> str:
    """Return the `results` as a table, and below it what survived; by what each subject is."""
    lines = [f"{'module':46}{'changes':>8}{'tried':>7}{'caught':>8}{'%':>7}"]
    survivors = []
    for name, (count, tried) in results.items():
        caught = sum(verdict.is_caught for _, verdict in tried)
        share = 100.0 * caught / len(tried)
        module = SUBJECTS[name].module
        is_compiled = module.endswith(".cpp")
        what = f"{name}: {module if is_compiled else module.split('.')[-1]}"
        lines.append(f"{what:46}{count:8}{len(tried):7}{caught:8}{share:7.1f}")
        file = module if is_compiled else f"{module.replace('.', '/')}.py"
        survivors += [f"{file}:{m}  ({v.outcome})" for m, v in sorted(tried, key=_line) if not v.is_caught]
    return "\n".join([*lines, "", *survivors])


def _line(entry: tuple[Mutation, Verdict]) -> int:
    return entry[0].line


def is_enough(tried: Iterable[tuple[Mutation, Verdict]]) -> bool:
    """Return whether the share of caught changes among those `tried` is high enough."""
    verdicts = [verdict.is_caught for _, verdict in tried]
    return sum(verdicts) >= LEAST * len(verdicts)


def main() -> int:
    """Run the campaign from the command line."""
    parser = argparse.ArgumentParser(prog="mutants", description=__doc__)
    parser.add_argument("--only", nargs="+", choices=SUBJECTS, default=list(SUBJECTS), help="subjects (default: all)")
    parser.add_argument("--sample", type=int, default=0, help="changes for each module, by chance (default: all)")
    parser.add_argument("--seed", type=int, default=0, help="of the sample (default 0)")
    parser.add_argument("--budget", type=float, default=240.0, help="time [minutes] (default 240)")
    parser.add_argument("--journal", type=Path, default=Path("runs/mutants.jsonl"), help="file of the verdicts")
    parser.add_argument("--only-survivors", action="store_true", help="what was caught is not tried again")
    options = parser.parse_args()

    def chosen(every: list[Mutation]) -> list[Mutation]:
        order = random.Random(options.seed).sample(every, len(every))
        return order[: options.sample] if options.sample else order

    progress, journal, results = ProgressLine(), Journal(options.journal, keeps_caught=options.only_survivors), {}
    until = time.monotonic() + 60.0 * options.budget
    for name in options.only:
        for count, tried in try_subject(SUBJECTS[name], chosen, journal, until):
            results[name] = (count, tried)
            progress.show(f"{name}: {len(tried)} of {min(options.sample or count, count)}")
    progress.close()
    sys.stdout.write(f"{commit_line()}\n{table(results)}\n")
    return 0 if all(is_enough(tried) for _, tried in results.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
