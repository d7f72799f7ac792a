"""What holds for the tests of every package: the same examples in every run, and packages before tests.

Hypothesis tries the same examples each time, so that a change is judged by what it changed; another search is
`pytest --hypothesis-profile=search`. Of the tests of whole loops with many cases the ordinary suite takes a sample: the
cases that `tests/long_cases.txt` lists are marked `long`.
"""

import importlib
from collections import Counter
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


LONG_CASES = frozenset((Path(__file__).parent / "tests" / "long_cases.txt").read_text(encoding="utf-8").splitlines())
"""Tests, by node id, that `make test` leaves to `make validate`."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark long cases, and begin with the files that have most slow tests.

    A processor that gets one of those last works on alone.
    """
    for item in items:
        if item.nodeid in LONG_CASES:
            item.add_marker(pytest.mark.long)
    slow = Counter(item.path for item in items if item.get_closest_marker("slow"))
    items.sort(key=lambda item: -slow[item.path])
