"""`heave qualify`: the evidence for this release as one folder, from the tests' own results."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

SUMMARY = "Run the tests that the models rest on; write the evidence for this release as one folder (HTML, PDF, JUnit)."
EXAMPLES = ("heave qualify --quick", "heave qualify --output evidence_1.0")

PAGE = "evidence.html"
PROCESSES, QUICK = 10, 2
"""Processes that the hashes come from, of a whole run and with --quick."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's own arguments to `parser`."""
    parser.add_argument("--output", type=Path, metavar="DIR", default=Path("evidence"), help="default: evidence")
    parser.add_argument("--quick", action="store_true", help="without slow tests and without sensitivity")
    parser.add_argument("--processes", type=int, metavar="N", help="worker processes (default: one per processor)")


def execute(options: argparse.Namespace) -> None:
    """Run the tests, write the folder and print what each model came to, as `options` say."""
    from heave_bags.errors import BagError
    from heave_bags.report.paper import save_pdf
    from heave_bringup.errors import InterruptedCommandError, VerdictError
    from heave_bringup.output import make_table, write_result
    from heave_node.parameters import ParameterError

    from heave_studies.qualify.cases import write_cases
    from heave_studies.qualify.claims import read_models
    from heave_studies.qualify.determinism import differences, run_hashes
    from heave_studies.qualify.page import package_list, render
    from heave_studies.qualify.results import FAILED, LOG, NOT_RUN, PASSED, read_cases, run_tests, verdict_of
    from heave_studies.qualify.sensitivity import what_matters

    processes = (os.cpu_count() or 1) if options.processes is None else options.processes
    if processes < 1:
        raise ParameterError(f"--processes {processes}: must be at least 1")
    models, folder = read_models(), options.output
    tests = list(dict.fromkeys(test for model in models for claim in model.claims for test in claim.tests))
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "versions.txt").write_text(package_list(), encoding="utf-8")
    write_cases(folder / "cases")
    hashes, sensitivity, is_interrupted = [], "<p>Not run.</p>", False
    try:
        run_tests(tests, folder, quick=options.quick, processes=processes)
        hashes = run_hashes(folder, QUICK if options.quick else PROCESSES)
        sensitivity = sensitivity if options.quick else what_matters(folder / "sensitivity", processes)
    except KeyboardInterrupt:
        is_interrupted = True
    cases = read_cases(folder)
    verdicts = [(model, [verdict_of(claim.tests, cases) for claim in model.claims]) for model in models]
    claims = [(model, *pair) for model, of in verdicts for pair in zip(model.claims, of, strict=True)]
    failures = [f"{model.name}: {claim.claim}" for model, claim, one in claims if one.outcome == FAILED]
    failures += differences(hashes) + ([] if cases or is_interrupted else [f"no test was run: see {folder / LOG}"])
    count = {name: sum(one.outcome == name for _, _, one in claims) for name in (PASSED, NOT_RUN)}
    notes = [f"{len(claims)} claims: {count[PASSED]} passed, {count[NOT_RUN]} not run"]
    notes += ["--quick: slow tests and sensitivity were not run"] if options.quick else []
    notes += ["interrupted: what was not run says so"] if is_interrupted else []
    page = folder / PAGE
    page.write_text(render(verdicts, cases, hashes, sensitivity, notes, failures), encoding="utf-8")
    if is_interrupted:
        raise InterruptedCommandError(f"interrupted; {page} has what is done")
    try:
        save_pdf(page, page.with_suffix(".pdf"))
    except BagError as error:
        notes.append(f"no PDF: {error}")
    rows = [[model.name, str(len(of)), str(sum(one.outcome == PASSED for one in of))] for model, of in verdicts]
    result = [{"model": m.key, "claim": c.claim, "outcome": v.outcome, "worst": v.worst} for m, c, v in claims]
    words, table = "\n".join([*notes, f"page      {page}"]), make_table(("model", "claims", "passed"), rows)
    write_result(options, [table, words], {"page": str(page), "failures": failures, "claims": result})
    if failures:
        raise VerdictError(failures, str(page))
