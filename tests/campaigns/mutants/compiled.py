"""Small changes of a C++ file of the core, each compiled in a second, and the tests that have to notice it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import pytest

from tests.campaigns.mutants.judge import LONGEST_TEST, ROOT, Pass, Verdict, in_a_fork
from tests.campaigns.mutants.mutations import Mutation

SOURCES = ROOT / "core" / "heave_core" / "src"

OPERATORS: dict[str, tuple[str, ...]] = {
    " < ": (" <= ", " >= "),
    " <= ": (" < ", " > "),
    " > ": (" >= ", " <= "),
    " >= ": (" > ", " < "),
    " == ": (" != ",),
    " != ": (" == ",),
    " && ": (" || ",),
    " || ": (" && ",),
    " + ": (" - ",),
    " - ": (" + ",),
    " * ": (" / ",),
    " / ": (" * ",),
    " += ": (" -= ",),
    " -= ": (" += ",),
    "std::min(": ("std::max(",),
    "std::max(": ("std::min(",),
}
"""What each operator or call becomes; the house writes operators between spaces."""

_OPERATOR = re.compile("|".join(map(re.escape, sorted(OPERATORS, key=len, reverse=True))))
_NUMBER = re.compile(r"(?<![\w.])\d+\.\d+(?![\w.])")
_NOT = re.compile(r"(?<=[(\s])!(?=[\w(])")
_STATEMENT = re.compile(r"^\s+[\w.>\[\]*-]+ (?:=|\+=|-=|\|=) [^;]*;$")


def mutations_of(source: str) -> list[Mutation]:
    """Return every mutation of a file by its `source`: in code, not in comments."""
    found: list[Mutation] = []
    for number, line in enumerate(source.splitlines(), start=1):
        code = line.partition("//")[0].rstrip()
        for changed in _changes(code):
            found.append(Mutation(len(found), number, number, code.strip(), changed.strip()))
    return found


def _changes(code: str) -> list[str]:
    """Return what a line of `code` may become."""
    found = []
    for match in _OPERATOR.finditer(code):
        found += [code[: match.start()] + other + code[match.end() :] for other in OPERATORS[match[0]]]
    for match in _NUMBER.finditer(code):
        other = "1.0" if float(match[0]) == 0.0 else repr(2.0 * float(match[0]))
        found.append(code[: match.start()] + other + code[match.end() :])
    found += [code[: match.start()] + code[match.end() :] for match in _NOT.finditer(code)]
    return [*found, ";"] if _STATEMENT.match(code) else found


class CompiledJudge:
    """Judges mutants of one file of the core.

    Parameters
    ----------
    file : its name
    tests : files of tests, from the root of the repository
    """

    def __init__(self, file: str, tests: Sequence[str]) -> None:
        self._tests = list(tests)
        self.path = SOURCES / file
        self.source = self.path.read_text(encoding="utf-8")
        self._made = tempfile.TemporaryDirectory(prefix="heave_mutants_")
        self._folder = Path(self._made.name)
        self._longest = 0.0

    def learn(self) -> None:
        """Compile the core and run the tests without a mutation; raises RuntimeError where they fail."""
        environment = os.environ | {"PYTHONPATH": str(ROOT / "core"), "PYTHONDONTWRITEBYTECODE": "1"}
        header = subprocess.run(
            [sys.executable, "-m", "heave_core.layout"], env=environment, check=True, capture_output=True, cwd=ROOT
        )
        (self._folder / "layout.h").write_bytes(header.stdout)
        (self._folder / "lib").mkdir(exist_ok=True)
        for path in sorted(SOURCES.glob("*.cpp")):
            self._compile(path, path.stem)
        self._link(self.path.stem)
        begun = time.monotonic()
        sound = in_a_fork(self._run, 600.0)
        self._longest = 2.0 * (LONGEST_TEST + time.monotonic() - begun)
        if not isinstance(sound, Pass) or sound.status != 0:
            raise RuntimeError(f"{self.path.name}: its tests fail without a mutation: {sound}")

    def judge(self, mutation: Mutation) -> Verdict:
        """Run the tests with a `mutation`, up to the first that fails."""
        lines = self.source.splitlines()
        lines[mutation.line - 1] = mutation.became
        mutant = self._folder / "mutant.cpp"
        mutant.write_text("\n".join(lines) + "\n", encoding="utf-8")
        try:
            self._compile(mutant, "mutant")
            self._link("mutant")
        except subprocess.CalledProcessError:
            return Verdict("caught", "compiler")
        found = in_a_fork(self._run, self._longest)
        if isinstance(found, Pass):
            return Verdict("survived") if found.status == 0 else Verdict("caught", found.failed or "import")
        return Verdict("hangs" if found is None else "caught", "" if found is None else "process")

    def _compile(self, source: Path, name: str) -> None:
        options = ["-std=c++17", "-O1", "-fPIC", "-ffp-contract=off", "-fno-exceptions", "-fno-rtti", "-w"]
        include = [f"-I{self._folder}", f"-I{SOURCES}"]
        command = ["g++", *options, *include, "-c", str(source), "-o", str(self._folder / f"{name}.o")]
        subprocess.run(command, check=True, capture_output=True)

    def _link(self, name: str) -> None:
        """Link the core with the object of a `name` in the place of the file's."""
        objects = [self._folder / f"{path.stem}.o" for path in SOURCES.glob("*.cpp") if path != self.path]
        library = self._folder / "lib" / "libheave_core.so"
        command = ["g++", "-shared", "-o", str(library), str(self._folder / f"{name}.o"), *map(str, objects)]
        subprocess.run(command, check=True, capture_output=True)

    def _run(self) -> Pass:
        """Run the tests on this library in this process, which ends after it."""
        os.chdir(ROOT)
        os.environ["AMENT_PREFIX_PATH"] = str(self._folder)
        options = ["-x", "-q", "-n0", "-p", "no:cacheprovider", "-m", "not long and not slow"]
        watch = _FirstFailure()
        watch.found.status = int(pytest.main([*options, "--hypothesis-profile=mutants", *self._tests], plugins=[watch]))
        return watch.found


class _FirstFailure:
    """Notes which test fails first."""

    def __init__(self) -> None:
        self.found = Pass(0)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed and not self.found.failed:
            self.found.failed = report.nodeid
