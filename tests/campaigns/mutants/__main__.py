"""Changes the modules that safety rests on, one small thing at a time, and counts the changes that no test notices.

    python -m tests.campaigns.mutants                          # make mutants
    python -m tests.campaigns.mutants --only guard --sample 50 --seed 3

Comparisons, conditions, arithmetic, numbers and statements are changed (`mutations`), in memory only. Every verdict
goes to the journal at once; what has a verdict for the same text of module and tests is not tried again. Prints a table
and what survived, and ends with status 1 where a module's tests notice less than 90 % of its changes.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import random
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from heave_bringup.progress import ProgressLine

from tests.campaigns.in_process import commit_line
from tests.campaigns.mutants import compiled, mutations
from tests.campaigns.mutants.compiled import CompiledJudge
from tests.campaigns.mutants.judge import ROOT, Judge, Verdict
from tests.campaigns.mutants.mutations import Mutation
from tests.campaigns.mutants.subjects import SUBJECTS, Subject

LEAST = 0.9
"""Share of the changes of a module that its tests have to notice."""

Tried = list[tuple[Mutation, Verdict]]


class Journal:
    """The verdicts so far, one a line of a file.

    Parameters
    ----------
    path : of the file; made with its folder where there is none
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        path.parent.mkdir(parents=True, exist_ok=True)
        lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
        entries = map(json.loads, lines)
        self._known = {(one["digest"], one["number"]): Verdict(one["outcome"], one["by"]) for one in entries}

    def get(self, digest: str, mutation: Mutation) -> Verdict | None:
        """Return the verdict on a `mutation` of texts with a `digest`; None: it has none."""
        return self._known.get((digest, mutation.number))

    def add(self, module: str, digest: str, mutation: Mutation, verdict: Verdict) -> None:
        """Note a `verdict` on a `mutation` of a `module`, whose texts have a `digest`."""
        entry = {"module": module, "digest": digest, "number": mutation.number, "change": str(mutation)}
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps({**entry, "outcome": verdict.outcome, "by": verdict.by}) + "\n")


def judge_of(subject: Subject) -> tuple[Judge | CompiledJudge, list[Mutation]]:
    """Return who judges a `subject`, and every mutation of it."""
    if subject.module.endswith(".cpp"):
        of_file = CompiledJudge(*subject)
        return of_file, compiled.mutations_of(of_file.source)
    judge = Judge(*subject)
    return judge, mutations.mutations_of(judge.source)


def digest_of(judge: Judge | CompiledJudge, subject: Subject) -> str:
    """Return a digest of the text of a `subject`, of its tests, and of the rules by which it is changed."""
    rules = "compiled.py" if subject.module.endswith(".cpp") else "mutations.py"
    tests = [(ROOT / test).read_text(encoding="utf-8") for test in subject.tests]
    texts = [judge.source, Path(__file__).with_name(rules).read_text(encoding="utf-8"), *tests]
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()[:16]


def try_subject(
    subject: Subject, chosen: Callable[[list[Mutation]], list[Mutation]], journal: Journal
) -> Iterator[tuple[int, Tried]]:
    """Judge the mutations of a `subject`, and yield again and again how many there are, and those with a verdict.

    Parameters
    ----------
    subject : module and tests
    chosen : returns those that are tried, in their order
    journal : of verdicts
    """
    judge, every = judge_of(subject)
    digest = digest_of(judge, subject)
    tried: Tried = []
    has_learnt = False
    for mutation in chosen(every):
        verdict = journal.get(digest, mutation)
        if verdict is None:
            if not has_learnt:
                judge.learn()
                has_learnt = True
            verdict = judge.judge(mutation)
            journal.add(subject.module, digest, mutation, verdict)
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
    parser.add_argument("--journal", type=Path, default=Path("runs/mutants.jsonl"), help="file of the verdicts")
    options = parser.parse_args()

    def chosen(every: list[Mutation]) -> list[Mutation]:
        order = random.Random(options.seed).sample(every, len(every))
        return order[: options.sample] if options.sample else order

    progress, journal, results = ProgressLine(), Journal(options.journal), {}
    for name in options.only:
        for count, tried in try_subject(SUBJECTS[name], chosen, journal):
            results[name] = (count, tried)
            progress.show(f"{name}: {len(tried)} of {min(options.sample or count, count)}")
    progress.close()
    sys.stdout.write(f"{commit_line()}\n{table(results)}\n")
    return 0 if all(is_enough(tried) for _, tried in results.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
