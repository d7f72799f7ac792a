"""A pytest plugin: what each test compares within a tolerance goes into its JUnit result, as property `comparison`.

Each `assert VALUE == pytest.approx(REFERENCE, ...)` and `numpy.testing.assert_allclose(VALUE, REFERENCE, ...)` is
recorded as it is evaluated, so that no error and no tolerance is written by hand. Of the values that one statement
compares, in arrays, loops and examples, the one that uses most of its tolerance is kept.
"""

from __future__ import annotations

import ast
import cmath
import json
import math
import os
import signal
import sys
from collections import Counter
from collections.abc import Iterator
from functools import cache
from numbers import Complex
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import pytest
from heave_node.ros.transport.parents_death import end_with
from heave_studies.qualify.results import CASES, PROPERTY

LIBRARIES = ("_pytest", "numpy", "contextlib.py", Path(__file__).name)
"""Parts of paths of code that compares for a test."""

worst: dict[tuple[str, int], dict[str, Any]] = {}
"""The comparison that used most of its tolerance, by file and line, of the test that runs."""


def note(reference: float, error: float, tolerance: float, count: int, *, is_relative: bool) -> None:
    """Record what the statement of a test that is being evaluated compares.

    Parameters
    ----------
    reference, error, tolerance : sizes of the reference, of the difference and of the largest one accepted [one unit]
    count : number of values, of which this one uses most of its tolerance
    is_relative : whether the test states the tolerance as a share of the reference
    """
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and any(name in frame.f_code.co_filename for name in LIBRARIES):
        frame = frame.f_back
    place = (frame.f_code.co_filename, frame.f_lineno) if frame else ("", 0)
    if not (of := compared(place[0]).get(place[1], "")):
        return
    used = 0.0 if error == 0.0 else error / max(tolerance, sys.float_info.min)
    used = math.inf if math.isnan(used) else used
    new = {"of": of, "used": used, "relative": bool(is_relative), "reference": reference, "error": error}
    before = worst.get(place, {"used": -1.0, "count": 0})
    kept = before if before["used"] >= used else {**new, "tolerance": tolerance}
    worst[place] = {**kept, "count": before["count"] + count}


@cache
def compared(file: str) -> dict[int, str]:
    """Return the source of what each statement of a Python `file` compares within a tolerance, by each of its lines."""
    path = Path(file)
    found: dict[int, str] = {}
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if path.is_file() else ():
        if isinstance(node, ast.Assert) and isinstance(node.test, ast.Compare) and isinstance(node.test.ops[0], ast.Eq):
            left = node.test.left
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("assert_allclose") and node.args:
            left = node.args[0]
        else:
            continue
        found |= dict.fromkeys(range(node.lineno, (node.end_lineno or node.lineno) + 1), ast.unparse(left))
    return found


Approx: type[Any] = type(pytest.approx(1.0))
"""Pytest's comparison of one number; those of arrays and lists call it for each."""


def equal(self: Any, actual: Any, of: Any = Approx.__eq__) -> bool:
    """Compare as pytest does (`of`) a number or an array `actual` with the expected one (`self`), and record it."""
    if isinstance(actual, Complex) and isinstance(self.expected, Complex) and not cmath.isnan(self.expected):
        error = 0.0 if actual == self.expected else float(abs(actual - self.expected))
        size, tolerance = float(abs(self.expected)), float(self.tolerance)
        note(size, error, tolerance, 1, is_relative=tolerance > float(self.abs or 0.0))
    return bool(of(self, actual))


def all_close(actual: Any, desired: Any, rtol: float = 1e-7, atol: float = 0.0, **options: Any) -> None:
    """Compare as numpy does (`numpy.testing.assert_allclose`, arguments as there), and record it."""
    sizes = np.abs(np.atleast_1d(desired)).astype(float)
    errors = np.abs(np.atleast_1d(actual) - np.atleast_1d(desired)).astype(float)
    errors[np.broadcast_to(np.isnan(sizes), errors.shape) & np.isnan(np.atleast_1d(actual))] = 0.0  # as numpy does
    if errors.size:
        sizes = np.broadcast_to(sizes, errors.shape)
        tolerances = atol + rtol * sizes
        at = int(np.argmax(np.nan_to_num(errors / np.maximum(tolerances, sys.float_info.min), nan=np.inf)))
        numbers = (float(values.flat[at]) for values in (sizes, errors, tolerances))
        note(*numbers, errors.size, is_relative=atol == 0.0)
    _all_close(actual, desired, rtol=rtol, atol=atol, **options)


_all_close = np.testing.assert_allclose


def pytest_configure() -> None:
    """Record from now on; end with the command that runs the tests, and by an interrupt also in the background."""
    end_with(os.getppid())
    signal.signal(signal.SIGINT, signal.default_int_handler)
    Approx.__eq__ = equal  # type: ignore[method-assign]
    np.testing.assert_allclose = all_close


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Give each test the number of cases that it has, before any of the `items` is left out."""
    cases = Counter(item.nodeid.partition("[")[0] for item in items)
    for item in items:
        item.user_properties.append((CASES, str(cases[item.nodeid.partition("[")[0]])))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Run the test `item`, and give its result what it compared, also where it fails."""
    worst.clear()
    try:
        return (yield)
    finally:
        item.user_properties += [(PROPERTY, json.dumps(one)) for one in worst.values()]
