"""What holds for the tests of every package: the same examples in every run, and packages before tests.

Hypothesis tries the same examples each time, so that a change is judged by what it changed; another search is
`pytest --hypothesis-profile=search`. Of the tests of whole loops with many cases the ordinary suite takes a sample: the
cases that `tests/long_cases.txt` lists are marked `long`. Files begin in the order of what they cost the last time.
"""

import ctypes
import importlib
import os
from collections import Counter, defaultdict
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.register_profile("search", derandomize=False, deadline=None)
settings.load_profile("repeatable")

# Pytest's importlib mode names a test after its folders (`cable_sim_node.test.test_x`) and would put a namespace
# package of the folder in the place of the package of that name.
for package in ("cable_sim_node", "wave_vessel_node", "winch_controller_node"):
    with suppress(ModuleNotFoundError):  # colcon tests a package where only those that it depends on are at hand
        importlib.import_module(package)


CLONE_NEWNS, MS_REC, MS_PRIVATE = 0x20000, 0x4000, 0x40000
"""Flags of unshare(2) and mount(2)."""


def take_own_shared_memory() -> None:
    """Give this process and those that it starts a /dev/shm of their own, where its user may mount.

    The middleware waits for ever for a lock in shared memory that a killed process held. The suite's nodes use none;
    nodes of strangers do, and what one worker kills could stop those of the other one.
    """
    libc = ctypes.CDLL(None)
    if libc.unshare(CLONE_NEWNS) == 0 and libc.mount(None, b"/", None, MS_REC | MS_PRIVATE, None) == 0:
        libc.mount(b"tmpfs", b"/dev/shm", b"tmpfs", 0, None)


if "PYTEST_XDIST_WORKER" in os.environ:
    take_own_shared_memory()


LONG_CASES = frozenset((Path(__file__).parent / "tests" / "long_cases.txt").read_text(encoding="utf-8").splitlines())
"""Tests, by node id, that `make test` leaves to `make validate`."""


COSTS = "heave/seconds_by_file"
"""Name in the cache of pytest: what each file of tests took when it was run last [s]."""
SLOW = 20.0
"""What a slow test of a file that was not run yet is taken to cost [s]."""

seconds: defaultdict[str, float] = defaultdict(float)
"""What each file has taken so far in this run [s]."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark long cases, and begin with the files that take longest.

    A processor that gets one of those last works on alone.
    """
    for item in items:
        if item.nodeid in LONG_CASES:
            item.add_marker(pytest.mark.long)
    cache = getattr(config, "cache", None)  # none with -p no:cacheprovider
    known = {} if cache is None else cache.get(COSTS, {})
    slow = Counter(file_of(item.nodeid) for item in items if item.get_closest_marker("slow"))
    items.sort(key=lambda item: -known.get(file_of(item.nodeid), SLOW * slow[file_of(item.nodeid)]))


def file_of(test: str) -> str:
    """Return the file of a test by its node id."""
    return test.partition("::")[0]


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Note what a test took, its fixtures included."""
    seconds[file_of(report.nodeid)] += report.duration


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Keep what files took for the order of the next run; a part of a file says nothing of the whole."""
    cache = getattr(session.config, "cache", None)
    if hasattr(session.config, "workerinput") or cache is None:
        return
    is_whole = not any("::" in argument for argument in session.config.args) and not session.config.option.keyword
    if is_whole:
        cache.set(COSTS, {**cache.get(COSTS, {}), **seconds})
