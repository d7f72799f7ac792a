"""How the hot loops of the line are compiled: cached on disk, division by zero gives inf or NaN as in numpy."""

from __future__ import annotations

from typing import Any

from numba import njit

_WITHOUT_ENTRANCES: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}

kernel = njit(cache=True, error_model="numpy")
"""A function that Python or other kernels call."""

inner_kernel = njit(cache=True, error_model="numpy", **_WITHOUT_ENTRANCES)
"""A function that kernels alone may call; from Python it would crash.

The way in from Python, which takes all arrays of a line apart, costs as much to compile as the function itself.
"""
