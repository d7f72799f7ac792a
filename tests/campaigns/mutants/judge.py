"""Runs the tests of a module with one mutation in it: each in a fork of a process that has loaded everything else.

The file on disk is never changed. The first pass, without a mutation, says which test reaches which line; a mutation
is then given to the tests that reach its line first, and to all the others after them.
"""

from __future__ import annotations

import ast
import importlib
import importlib.abc
import importlib.util
import os
import resource
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import CodeType, FrameType, ModuleType
from typing import Any

import pytest
from heave_node.ros.transport.parents_death import end_with
from hypothesis import Phase, settings

from tests.campaigns import in_process
from tests.campaigns.mutants.mutations import Mutation, mutated

ROOT = Path(__file__).parents[3]
OWN = (
    *("heave_node", "wave_vessel_node", "cable_sim_node", "winch_controller_node", "heave_bags", "heave_bringup"),
    *("heave_devices", "heave_studies", "heave_statics", "heave_panel", "heave_fmu"),
)
MEMORY = 6 << 30
"""Bytes that the tests of a mutant may ask for."""
LONGEST_TEST = 5.0
"""A test fails after five times its time without a mutation, and so much more [s]."""

settings.register_profile("mutants", derandomize=True, deadline=None, phases=(Phase.explicit, Phase.generate))


@dataclass
class Pass:
    """What became of the tests."""

    status: int  # of pytest
    failed: str = ""  # the first test that failed; "": none did
    # lines of the module by test, where they were asked for
    reached: dict[str, set[int]] = field(default_factory=lambda: defaultdict(set))
    seconds: dict[str, float] = field(default_factory=dict)  # by test
    loaded: list[str] = field(default_factory=list)  # modules that were imported and know nothing of the mutated one


@dataclass(frozen=True)
class Verdict:
    """What became of a mutant: `outcome` is caught, hangs, survived or unreached; `by` names the test."""

    outcome: str
    by: str = ""

    @property
    def is_caught(self) -> bool:
        """Return whether a test noticed it."""
        return self.outcome in ("caught", "hangs")


class Judge:
    """Judges mutants of one module.

    Parameters
    ----------
    module : its name
    tests : files of tests, from the root of the repository
    """

    def __init__(self, module: str, tests: Sequence[str]) -> None:
        self._module = module
        self._tests = list(tests)
        spec = importlib.util.find_spec(module)
        assert spec is not None and spec.origin is not None
        _reset_own()  # a parent package was loaded to find it
        self.path = Path(spec.origin)
        self.source = self.path.read_text(encoding="utf-8")
        self._sound = Pass(0)
        self._longest = 0.0

    def learn(self) -> None:
        """Run the tests without a mutation; raises RuntimeError where they fail."""
        begun = time.monotonic()
        sound = in_a_fork(lambda: self._run(None), 600.0)
        self._longest = 2.0 * (LONGEST_TEST + time.monotonic() - begun)
        if not isinstance(sound, Pass) or sound.status != 0:
            raise RuntimeError(f"{self._module}: its tests fail without a mutation: {sound}")
        self._sound = sound
        for name in sound.loaded:
            with suppress(Exception):  # modules that cannot be loaded by their name are loaded by who needs them
                importlib.import_module(name)
        if self._module in sys.modules:  # one of them knows it nevertheless
            _reset_own()

    def judge(self, mutation: Mutation) -> Verdict:
        """Run the tests with a `mutation`, up to the first that fails."""
        lines = range(mutation.line, mutation.last_line + 1)
        if not any(reached.intersection(lines) for reached in self._sound.reached.values()):
            return Verdict("unreached")
        found = in_a_fork(lambda: self._run(mutation), self._longest)
        if isinstance(found, Pass):
            return Verdict("survived") if found.status == 0 else Verdict("caught", found.failed or "import")
        return Verdict("hangs" if found is None else "caught", "" if found is None else "process")

    def _run(self, mutation: Mutation | None) -> Pass:
        """Run the tests in this process, which ends after it."""
        os.chdir(ROOT)
        if mutation is not None:
            code = compile(mutated(self.source, mutation.number), str(self.path), "exec")
            sys.meta_path.insert(0, _Loader(self._module, self.path, code))
        options = ["-x", "-q", "-p", "no:cacheprovider", "-m", "not long and not slow", "--hypothesis-profile=mutants"]
        options += [f"--timeout={LONGEST_TEST + 5.0 * max(self._sound.seconds.values(), default=20.0)}"]
        watch = _Watch(self._sound, mutation, str(self.path))
        watch.found.status = int(pytest.main([*options, *self._tests], plugins=[watch]))
        if mutation is None:
            unsafe = _importers(self._module)
            watch.found.loaded = [name for name in sys.modules if name not in unsafe]
        return watch.found


def _reset_own() -> None:
    for name in [name for name in sys.modules if name.split(".")[0] in OWN]:
        del sys.modules[name]


def _importers(module: str) -> set[str]:
    """Return the loaded modules that import `module`, themselves or through others, it among them; and all tests."""
    imports: dict[str, set[str]] = defaultdict(set)
    for name, loaded in list(sys.modules.items()):
        if name.split(".")[0] in OWN and getattr(loaded, "__file__", None):
            for node in ast.walk(ast.parse(Path(str(loaded.__file__)).read_text(encoding="utf-8"))):
                if isinstance(node, ast.Import):
                    imports[name] |= {alias.name for alias in node.names}
                elif isinstance(node, ast.ImportFrom):
                    imports[name] |= {str(node.module), *(f"{node.module}.{alias.name}" for alias in node.names)}
    found, more = {module}, {module}
    while more:
        more = {name for name, known in imports.items() if known & found} - found
        found |= more
    return found | {name for name in sys.modules if _is_of_tests(name)}


def _is_of_tests(name: str) -> bool:
    """Return whether the module of a `name` is a test, or helps tests: it may hold what the mutated module defines."""
    is_helper = name.startswith("tests.") and not name.startswith("tests.campaigns")
    return is_helper or ".test." in name or name.rsplit(".", maxsplit=1)[-1].startswith(("test_", "conftest"))


class _Loader(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds one module, and runs other code than that of its file."""

    def __init__(self, module: str, path: Path, code: CodeType) -> None:
        self._module, self._path, self._code = module, path, code

    def find_spec(self, fullname: str, path: Any, target: Any = None) -> ModuleSpec | None:
        if fullname != self._module:
            return None
        return importlib.util.spec_from_file_location(fullname, self._path, loader=self)

    def exec_module(self, module: ModuleType) -> None:
        exec(self._code, module.__dict__)


class _Watch:
    """Puts the tests in order, and notes what they reach and which one fails."""

    def __init__(self, sound: Pass, mutation: Mutation | None, file: str) -> None:
        self.found = Pass(0)
        self._sound, self._mutation, self._file = sound, mutation, file

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        mutation = self._mutation
        if mutation is None:
            return
        lines = range(mutation.line, mutation.last_line + 1)
        reached, seconds = self._sound.reached, self._sound.seconds
        items.sort(
            key=lambda item: (
                not reached.get(item.nodeid, set()).intersection(lines),
                seconds.get(item.nodeid, 0.0),
            )
        )

    @pytest.hookimpl(wrapper=True)
    def pytest_collection(self) -> Generator[None, object, object]:
        with self._traced(""):  # what runs when the module is imported
            return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        with self._traced(item.nodeid):
            return (yield)

    @contextmanager
    def _traced(self, test: str) -> Iterator[None]:
        if self._mutation is not None:
            yield
            return
        begun = time.monotonic()
        sys.settrace(_tracer(self.found.reached[test], self._file))
        try:
            yield
        finally:
            sys.settrace(None)
            self.found.seconds[test] = time.monotonic() - begun

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed and not self.found.failed:
            self.found.failed = report.nodeid


def _tracer(lines: set[int], file: str) -> Callable[[FrameType, str, Any], Any]:
    """Return a trace function that adds the lines of a `file` that run to `lines`."""

    def of_line(frame: FrameType, _event: str, _argument: Any) -> Any:
        lines.add(frame.f_lineno)
        return of_line

    return lambda frame, event, argument: of_line(frame, event, argument) if frame.f_code.co_filename == file else None


def in_a_fork(task: Callable[[], Any], longest: float) -> Any:
    """Return what a task gives in a quiet process of its own; see `tests.campaigns.in_process.in_a_fork`."""
    parent = os.getpid()

    def quietly() -> Any:
        end_with(parent)
        resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))
        nowhere = os.open(os.devnull, os.O_RDWR)
        for number in (0, 1, 2):
            os.dup2(nowhere, number)
        return task()

    return in_process.in_a_fork(quietly, longest)
