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
from typing import Any, NamedTuple

import numpy as np

from heave_core import layout
from heave_core.envelope_table import DESIGN, KEPT, READINGS, STATE
from heave_core.rows import Structure

NAME = "libheave_core.so"
"""Of the library."""

_POINTER, _COUNT, _NUMBER = ctypes.c_void_p, ctypes.c_int, ctypes.c_double

ARGUMENTS: Mapping[str, tuple[Any, ...]] = {
    "heave_core_begin": (_POINTER,),
    "heave_core_envelope": (_POINTER,) * 4,
    "heave_core_filter_begin": (_POINTER,) * 2,
    "heave_core_filter": (*(_POINTER,) * 3, _COUNT, *(_POINTER,) * 2),
    "heave_core_pass": (_POINTER,) * 11,
    "heave_core_servo": (*(_POINTER,) * 4, _COUNT, _POINTER),
    "heave_core_unit": (_POINTER, _POINTER, _NUMBER, _NUMBER, _POINTER),
    "heave_core_unit_motion": (_POINTER,) * 3,
    "heave_core_unit_continue": (_POINTER, _POINTER, _NUMBER, _NUMBER),
    "heave_core_look": (_POINTER,) * 7,
    "heave_core_look_again": (_POINTER,) * 6,
    "heave_core_look_begin_share": (_POINTER,) * 2,
    "heave_core_look_continue_shadow": (_POINTER, _POINTER, _NUMBER, _NUMBER),
    "heave_core_look_continue_hanging": (_POINTER, _POINTER, _NUMBER, _NUMBER),
    "heave_core_look_take_unit": (_POINTER, _POINTER, _NUMBER, _NUMBER),
    "heave_core_guard": (*(_POINTER,) * 5, _COUNT, _COUNT, _POINTER),
    "heave_core_guard_demand": (_POINTER,) * 3,
    "heave_core_guard_begin": (_POINTER,),
    "heave_core_guard_allow_resumption": (_POINTER,) * 2,
    "heave_core_guard_reset_mismatch": (_POINTER,),
    "heave_core_sigma": (_POINTER, _NUMBER, _NUMBER, _NUMBER),
    "heave_core_landing_begin": (_POINTER,),
    "heave_core_landing_depth": (_POINTER, _NUMBER, _NUMBER),
    "heave_core_landing_observe": (_POINTER,) * 3,
    "heave_core_landing": (_POINTER,) * 3,
    "heave_core_trend": (_POINTER, _NUMBER, _NUMBER, _NUMBER, _POINTER),
    "heave_core_kpi_add": (_POINTER,) * 4,
    "heave_core_kpi": (_POINTER,) * 4,
    "heave_core_drum_add": (_POINTER,) * 5,
    "heave_core_drum_reset": (*(_POINTER,) * 4, _NUMBER),
    "heave_core_drum_error": (_POINTER,) * 4,
    "heave_core_drum_ordered": (*(_POINTER,) * 4, _COUNT, _POINTER),
    "heave_core_link_command": (*(_POINTER,) * 3, _COUNT, _COUNT, _NUMBER),
    "heave_core_link_silence": (_POINTER, _POINTER, _COUNT, _NUMBER),
    "heave_core_watch_winch": (_POINTER,) * 6,
    "heave_core_approach_speed": (_NUMBER,) * 3,
    "heave_core_govern": (_POINTER,) * 3,
    "heave_core_restart_law": (_POINTER,),
    "heave_core_ask_law": (_POINTER,) * 4,
    "heave_core_follow_plan": (_POINTER,) * 4,
    "heave_core_bound_plan": (_POINTER,) * 4,
    "heave_core_pose": (_POINTER,) * 5,
    "heave_core_make": (_POINTER,) * 6,
    "heave_core_answer": (_POINTER,) * 8,
    "heave_core_act": (_POINTER,) * 8,
    "heave_core_act_tick": (_POINTER,),
    "heave_core_act_pose": (_POINTER,),
    "heave_core_act_answer": (_POINTER,),
    "heave_core_act_make": (_POINTER,),
    "heave_core_act_leave": (_POINTER,),
    "heave_core_place": (_POINTER, _NUMBER, _NUMBER, _NUMBER, _COUNT),
    "heave_core_load_begin": (_POINTER,) * 2,
    "heave_core_load": (_POINTER, _POINTER, _NUMBER, _NUMBER, _COUNT),
    "heave_core_proofs_begin": (_POINTER,) * 2,
    "heave_core_prove": (*(_POINTER,) * 3, _COUNT, *(_POINTER,) * 2),
    "heave_core_proofs_ask": (_POINTER, _COUNT),
    "heave_core_modes": (_POINTER,) * 3,
    "heave_core_modes_event": (_POINTER, _POINTER, _COUNT, _POINTER),
    "heave_core_modes_request": (_POINTER, _POINTER, _COUNT, _POINTER),
    "heave_core_modes_missing": (_POINTER, _POINTER, _COUNT, _POINTER),
    "heave_core_attempts_release": (_POINTER,) * 4,
    "heave_core_attempts_explain": (_POINTER,),
    "heave_core_attempts_largest": (_POINTER,) * 2,
    "heave_core_attempts_awaits": (_POINTER,) * 2,
    "heave_core_supervision_begin": (_POINTER,),
    "heave_core_supervision_reset_sea": (_POINTER,),
    "heave_core_supervise": (_POINTER,) * 2,
    "heave_core_advance_mean": (_POINTER,),
    "heave_core_is_moving": (_POINTER,),
    "heave_core_ticks_to_go": (_POINTER, _COUNT),
    "heave_core_advance_motion": (*(_POINTER,) * 3, _COUNT, _NUMBER, _COUNT),
    "heave_core_note_tension": (_POINTER, _NUMBER, _NUMBER),
    "heave_core_read_tip": (_POINTER,) * 2,
    "heave_core_follow_tip": (_POINTER,) * 2,
    "heave_core_sense_begin": (_POINTER,) * 2,
    "heave_core_sense": (_POINTER,) * 16,
    "heave_core_second": (*(_POINTER,) * 14, _NUMBER, _COUNT, _POINTER),
    "heave_core_restart_consistency": (_POINTER,),
    "heave_core_restart_tension": (_POINTER,),
    "heave_core_sea_begin": (_POINTER,),
    "heave_core_sea": (_POINTER, _NUMBER, _POINTER, _NUMBER, _NUMBER),
    "heave_core_sea_innovation": (_POINTER, _NUMBER, _POINTER, _NUMBER, _NUMBER),
    "heave_core_sea_height": (_POINTER,) * 2,
    "heave_core_sea_waves": (_POINTER,) * 2,
    "heave_core_restart_steps": (_POINTER,),
    "heave_core_rescale_encoder": (_POINTER, _NUMBER, _NUMBER),
    "heave_core_trust_encoder": (_POINTER,),
    "heave_core_gate": (_POINTER, _POINTER, _COUNT, _NUMBER, _NUMBER, _POINTER, _COUNT, _COUNT),
    "heave_core_gate_tick": (_POINTER, _POINTER, _COUNT, _NUMBER),
    "heave_core_gate_take_back": (_POINTER, _POINTER, _COUNT, _COUNT, _COUNT),
    "heave_core_gate_is_slow": (_POINTER, _POINTER, _COUNT),
    "heave_core_mru": (_POINTER, _POINTER, _NUMBER, _POINTER),
    "heave_core_mru_is_off": (_POINTER, _POINTER, _POINTER, _NUMBER),
    "heave_core_depth": (_POINTER, _POINTER, _NUMBER, _NUMBER, _NUMBER),
    "heave_core_encoder_pass": (_POINTER, _POINTER, _NUMBER, _NUMBER),
    "heave_core_encoder": (_POINTER, _POINTER, _NUMBER, _NUMBER, _NUMBER, _NUMBER, _COUNT),
    "heave_core_noise": (_POINTER, _POINTER, _COUNT, _NUMBER, _NUMBER),
    "heave_core_noise_is_worse": (_POINTER, _POINTER, _COUNT),
    "heave_core_consistency": (_POINTER,) * 3,
    "heave_core_tension": (_POINTER, _POINTER, _NUMBER, _NUMBER, _COUNT),
    "heave_core_lead_alone": (_POINTER, _POINTER, _NUMBER, _NUMBER, _COUNT, _POINTER),
}
"""Types of the arguments of each function."""

RESULTS: Mapping[str, Any] = {
    **dict.fromkeys(("heave_core_approach_speed", "heave_core_read_tip", "heave_core_follow_tip"), _NUMBER),
    **dict.fromkeys(("heave_core_ask_law", "heave_core_answer", "heave_core_act"), _COUNT),
    **dict.fromkeys(("heave_core_advance_mean", "heave_core_is_moving", "heave_core_ticks_to_go"), _COUNT),
    **dict.fromkeys(("heave_core_sea_height", "heave_core_sea_waves", "heave_core_depth"), _NUMBER),
    **dict.fromkeys(("heave_core_encoder", "heave_core_noise"), _NUMBER),
    **dict.fromkeys(("heave_core_advance_motion", "heave_core_sea", "heave_core_gate", "heave_core_mru"), _COUNT),
    **dict.fromkeys(("heave_core_gate_is_slow", "heave_core_mru_is_off", "heave_core_noise_is_worse"), _COUNT),
    **dict.fromkeys(("heave_core_consistency", "heave_core_modes", "heave_core_modes_event"), _COUNT),
    **dict.fromkeys(("heave_core_modes_request", "heave_core_modes_missing", "heave_core_attempts_awaits"), _COUNT),
    "heave_core_attempts_largest": _NUMBER,
    "heave_core_prove": _COUNT,
    **dict.fromkeys(("heave_core_drum_error", "heave_core_place"), _NUMBER),
    **dict.fromkeys(("heave_core_act_tick", "heave_core_act_answer", "heave_core_load"), _COUNT),
}
"""Types of what those functions return that return anything."""


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
    sizes = [dtype_of(structure).itemsize for structure in layout.RECORDS]
    found = [library.heave_core_size(place) for place in range(len(layout.RECORDS))]
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
    for name, arguments in ARGUMENTS.items():
        function = getattr(loaded, name)
        function.argtypes, function.restype = arguments, RESULTS.get(name)
    return loaded


READING_NAMES = tuple(row.name for row in READINGS.rows)
"""Names of what comes in at a tick, in their order."""


class EnvelopeOrder(NamedTuple):
    """What leaves in a tick, and why: the rows of ORDER in the envelope's table, with their meanings and units."""

    payout: float
    rate: float
    brake: float
    bits: float
    phase: float
    cause: float
    value: float
    limit: float
    rate_bound: float
    travel_bound: float
    move_rate: float
    travel_sent: float
    travel_count: float
    residual: float
    residual_limit: float
    harm: float
    speed: float
    load_step: float
    lowest: float
    highest: float


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
    records : the arrays by the names of `Acting` in act.h

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
            raise ValueError(
                f"winch.command_delay = {delay:g} s: at ticks of {period:g} s at most {longest:g} s are kept"
            )
        fill(self.design[0], design)

    def begin(self) -> None:
        """Begin: the brake is on, and nothing was read yet."""
        self._library.heave_core_begin(self._addresses[1])

    def step(self, readings: tuple[float, ...]) -> EnvelopeOrder:
        """Do a tick with `readings`, in the order of READING_NAMES; return what leaves."""
        self.readings[:] = readings
        return self.go()

    def go(self) -> EnvelopeOrder:
        """Do a tick with the readings that are there; return what leaves."""
        self._call(*self._addresses)
        return self.last

    @property
    def last(self) -> EnvelopeOrder:
        """What has left in the last tick."""
        return EnvelopeOrder._make(self.order.tolist())
