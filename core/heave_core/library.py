"""The library of the core by ctypes, and its structures as numpy arrays on the same memory.

The library must have the layout of this Python: its number is asked for before anything else. Calls release the lock.
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections import namedtuple
from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from heave_core import layout
from heave_core.envelope_table import DESIGN, KEPT, ORDER, READINGS, STATE
from heave_core.rows import Structure

NAME = "libheave_core.so"
"""Of the library."""

_TYPES = {"double": ctypes.c_double, "int": ctypes.c_int, "long long": ctypes.c_longlong, "void": None}
"""Of numbers and results; all else is a pointer."""


class LibraryError(RuntimeError):
    """The library is not there, or does not go with this Python; the message says what to do."""


@lru_cache
def dtype_of(structure: Structure) -> np.dtype[Any]:
    """Return a structure as a numpy structured type, aligned as C++ aligns it."""
    fields: list[Any] = [
        (row.name, dtype_of(row.kind) if isinstance(row.kind, Structure) else row.kind, row.shape)
        for row in structure.rows
    ]
    return np.dtype(fields, align=True)


def new(structure: Structure) -> Any:
    """Return an empty array of one `structure`, on whose memory C++ works."""
    return np.zeros(1, dtype_of(structure))


def named(structure: Structure) -> Any:
    """Return the class of named tuples whose fields are the rows of a `structure`, a row of which is on one array."""
    return namedtuple(structure.name, [row.name for row in structure.rows])  # type: ignore[misc]


def _prefixes() -> Iterator[Path]:
    """Yield where a library may be installed: with this Python, or in a sourced workspace."""
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if prefix:
            yield Path(prefix)
    yield Path(sys.prefix)


def _check(library: Any, path: Path) -> None:
    """Refuse a library with another layout, in one line."""
    library.heave_core_layout.restype = library.heave_core_size.restype = ctypes.c_longlong
    sizes = [dtype_of(structure).itemsize for structure in layout.STRUCTURES]
    found = [library.heave_core_size(place) for place in range(len(layout.STRUCTURES))]
    number = library.heave_core_layout()
    if number != layout.layout_number() or found != sizes:
        raise LibraryError(
            f"{path} has layout {number:x} with sizes {found}; this heave_core needs {layout.layout_number():x} with "
            f"{sizes}: build it again (make install, or colcon build)"
        )


@lru_cache
def library() -> Any:
    """Return the library, loaded once.

    Raises LibraryError where it is not found, or was built from another layout.
    """
    places = [prefix / "lib" / NAME for prefix in _prefixes()]
    path = next((place for place in places if place.is_file()), None)
    if path is None:
        raise LibraryError(
            f"{NAME} is not below {', '.join(map(str, _prefixes()))}: install heave again (make install)"
        )
    loaded = ctypes.CDLL(str(path))
    _check(loaded, path)
    for result, name, arguments in layout.interface():
        function = getattr(loaded, name)
        function.argtypes, function.restype = [_TYPES.get(one, ctypes.c_void_p) for one in arguments], _TYPES[result]
    return loaded


READING_NAMES = tuple(row.name for row in READINGS.rows)
"""Names of what comes in at a tick, in their order."""

EnvelopeOrder = named(ORDER)
"""What leaves in a tick, and why."""


def fill(record: Any, values: Mapping[str, Any]) -> None:
    """Put `values` by name into a structured `record`; a mapping goes into a structure, a list of them into several.

    Every field must be given.
    """
    missing = set(record.dtype.names) - set(values) - {"pad"}
    unknown = set(values) - set(record.dtype.names)
    if missing or unknown:
        raise ValueError(f"layout: missing {sorted(missing)}, unknown {sorted(unknown)}")
    for name, value in values.items():
        if isinstance(value, Mapping):
            fill(record[name], value)
        elif isinstance(value, list):
            for place, one in zip(record[name], value, strict=True):
                fill(place, one)
        else:
            record[name] = value


class Envelope:
    """The envelope with its memory.

    Parameters
    ----------
    design : values by the names of DESIGN in `heave_core.envelope_table`, groups as mappings

    Attributes
    ----------
    design, state : structured arrays of one element, on the memory that C++ reads and writes
    readings, order : what comes in and what leaves, in the order of READINGS and ORDER, on that memory too
    records : the arrays by the names of ACTING in `heave_core.law`

    Raises LibraryError, and ValueError for a delay of the winch that is longer than what is kept.
    """

    def __init__(self, design: Mapping[str, Any]) -> None:
        self._library = library()
        self.design = new(DESIGN)
        self.state = new(STATE)
        self.readings = np.zeros(len(READING_NAMES))
        self.order = np.zeros(len(EnvelopeOrder._fields))
        self._call = self._library.heave_core_envelope
        self.take_design(design)
        self._addresses = [array.ctypes.data for array in (self.design, self.state, self.readings, self.order)]
        self.records = {"envelope": self.design, "envelope_state": self.state}
        self.records |= {"readings": self.readings, "order": self.order}
        self.begin()

    def take_design(self, design: Mapping[str, Any]) -> None:
        """Go by another `design` from now on."""
        delay, period = design["winch"]["delay"], design["tick_period"]
        longest = (KEPT - 2) * period
        if delay > longest:
            raise ValueError(f"winch.command_delay = {delay:g} s: ticks of {period:g} s keep at most {longest:g} s")
        fill(self.design[0], design)

    def begin(self) -> None:
        """Begin: the brake is on, and nothing was read yet."""
        self._library.heave_core_begin(self._addresses[1])

    def step(self, readings: tuple[float, ...]) -> Any:
        """Do a tick with `readings`, in the order of READING_NAMES; return what leaves."""
        self.readings[:] = readings
        return self.go()

    def go(self) -> Any:
        """Do a tick with the readings that are there; return what leaves."""
        self._call(*self._addresses)
        return self.last

    @property
    def last(self) -> Any:
        """What has left in the last tick."""
        return EnvelopeOrder._make(self.order.tolist())
