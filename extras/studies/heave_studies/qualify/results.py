"""Run the tests of the claims by pytest, and read what they compared from its JUnit file."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from heave_bringup.progress import ProgressLine

from heave_studies.qualify.claims import TREE

PROPERTY, CASES = "comparison", "cases"
"""Properties of a case in the JUnit file, by `tests/comparisons.py`: a comparison as JSON, the cases of its test."""
JUNIT, LOG = "tests.xml", "tests.log"
PASSED, FAILED, SKIPPED, NOT_RUN = "passed", "FAILED", "skipped", "not run"
PATIENCE = 120.0
"""Wall time after an interrupt for the test that runs, and for the JUnit file [s]."""


@dataclass(frozen=True)
class Verdict:
    """What a case of a test, or all cases of a claim's tests, came to."""

    test: str  # `file::function[case]`; of a claim empty
    outcome: str  # PASSED, FAILED, SKIPPED or NOT_RUN; of a claim the worst of its cases
    message: str  # of a failure, or why it was skipped
    comparisons: tuple[Mapping[str, Any], ...]  # as `tests/comparisons.py` records them
    total: int = 0  # number of cases that the test of a case has, run or not

    @property
    def worst(self) -> Mapping[str, Any] | None:
        """The comparison that used most of its tolerance; None where none was recorded."""
        return max(self.comparisons, key=lambda one: float(one["used"]), default=None)


def run_tests(tests: Sequence[str], folder: Path, *, quick: bool, processes: int) -> None:
    """Run `tests`, each `file::function`, with their results in a `folder` (JUNIT, LOG).

    `quick` leaves out those that are marked slow or long; `processes` above 1 are those of pytest-xdist.

    Raises KeyboardInterrupt after Ctrl-C; what is done is in the folder then.
    """
    command = [sys.executable, "-m", "pytest", *tests, "-v", "--color=no", "-p", "tests.comparisons"]
    command += ["-o", "addopts=--import-mode=importlib", "-p", "no:cacheprovider", "-o", "junit_family=xunit1"]
    command += [f"--junitxml={folder.resolve() / JUNIT}", *(["-m", "not slow and not long"] if quick else [])]
    command += ["-n", str(processes), "--dist", "loadfile"] if processes > 1 else []
    (folder / JUNIT).unlink(missing_ok=True)
    with ProgressLine() as line, (folder / LOG).open("w", 1, encoding="utf-8") as log:
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
        child = subprocess.Popen(command, cwd=TREE, text=True, start_new_session=True, **pipes)  # type: ignore[call-overload]
        assert child.stdout is not None
        try:
            for words in child.stdout:
                log.write(words)
                if share := re.search(r"::(\w+).*\[\s*(\d+)%\]|\[\s*(\d+)%\].*::(\w+)", words):
                    line.show(share[1] or share[4], int(share[2] or share[3]) / 100.0)
            child.wait()
        except KeyboardInterrupt:
            child.send_signal(signal.SIGINT)
            line.tell("interrupted: waiting for the results of the tests that are done")
            with suppress(subprocess.TimeoutExpired):
                log.write(child.communicate(timeout=PATIENCE)[0])
            raise
        finally:
            child.kill()


def read_cases(folder: Path) -> tuple[Verdict, ...]:
    """Return the cases that were run, from the JUnit file in a `folder`; none where there is no whole file."""
    try:
        found = ElementTree.parse(folder / JUNIT).iter("testcase")
        return tuple(_case(one) for one in found if one.get("name"))  # one that an interrupt ended has none
    except (OSError, ElementTree.ParseError):
        return ()


def _case(element: ElementTree.Element) -> Verdict:
    test = f"{element.get('classname', '').replace('.', '/')}.py::{element.get('name')}"
    part = next((one for kind in ("failure", "error", "skipped") for one in element.iter(kind)), None)
    outcome = PASSED if part is None else SKIPPED if part.tag == "skipped" else FAILED
    message = "" if part is None else " ".join(part.get("message", "").split())[:200]
    notes = [(one.get("name"), one.get("value", "")) for one in element.iter("property")]
    compared = tuple(json.loads(value) for name, value in notes if name == PROPERTY)
    return Verdict(test, outcome, message, compared, int(dict(notes).get(CASES, 0)))


def verdict_of(tests: Sequence[str], cases: Sequence[Verdict]) -> Verdict:
    """Return what the `tests` of a claim came to, of all `cases` that were run: the worst of them."""
    mine = [[case for case in cases if case.test.partition("[")[0] == test] for test in tests]
    flat = [case for of in mine for case in of]
    outcomes = {case.outcome for case in flat} | (
        set() if all(of and len(of) >= of[0].total for of in mine) else {NOT_RUN}
    )
    outcome = next((one for one in (FAILED, NOT_RUN, SKIPPED) if one in outcomes), PASSED)
    message = next((case.message for case in flat if case.outcome == outcome), "")
    return Verdict("", outcome, message, tuple(one for case in flat for one in case.comparisons))
