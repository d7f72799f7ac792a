"""What held when in a run: modes, limits, faults and alarms as intervals of time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from heave_node.interface.codes import SensorLevel, WinchFault, WinchLimit
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray

from heave_bags.analyse.fields import Fields

REPEATED = 1.0
"""Time for which a message of /diagnostics holds, until the next [s]."""


COMPENSATES = ("compensating", "constant_tension")
"""Modes of the controller in which the winch does its work."""
OFF = "off"
"""Mode of a controller whose law never moves the winch."""


@dataclass(frozen=True)
class Interval:
    """Something, its `name`, that held from `start` to `end` [s]: a mode, an alarm of a `level`, a limit."""

    start: float
    end: float
    name: str
    level: int = 0
    """0 plain, 1 warning, 2 error."""


def words(code: WinchFault | WinchLimit | SensorLevel) -> str:
    """Return a code as words: its name."""
    return str(code.name).lower().replace("_", " ")


def modes(state: Fields) -> list[Interval]:
    """Return the modes of the controller from the columns of its `state`."""
    names = state.texts("mode")
    return _unchanged(state.time, names) if names is not None and names.size else []


def winch_limits(winch: Fields) -> list[Interval]:
    """Return when which limit of the winch acted, and when its brake was on."""
    flags = winch.codes("limits_hit")
    found: list[Interval] = []
    for limit in WinchLimit:
        if limit:
            found += _flagged(winch.time, (flags & limit) != 0, words(limit))
    return [*found, *_flagged(winch.time, winch.codes("brake") != 0, "brake")]


def winch_faults(winch: Fields) -> list[Interval]:
    """Return when the winch had stopped by itself, and why."""
    codes = winch.codes("fault")
    found: list[Interval] = []
    for fault in WinchFault:
        if fault:
            found += _flagged(winch.time, codes == fault, f"winch: {words(fault)}", level=2)
    return found


def sensor_alarms(state: Fields) -> list[Interval]:
    """Return when the controller held a sensor for suspect or lost, from the columns of its `state`."""
    found: list[Interval] = []
    for index in state.indices("sensors[].level"):
        levels, names = state.codes(f"sensors[{index}].level"), state.texts(f"sensors[{index}].sensor")
        for level in (SensorLevel.SUSPECT, SensorLevel.LOST):
            where = levels == level
            if where.any() and names is not None:
                found += _flagged(state.time, where, f"{names[where][0]} {words(level)}", level=int(level))
    return found


def diagnostic_alarms(diagnostics: Fields) -> list[Interval]:
    """Return the warnings and errors of /diagnostics."""
    alarms: dict[tuple[str, int], list[float]] = {}
    for index in diagnostics.indices("status[].level"):
        levels = diagnostics.codes(f"status[{index}].level")
        names, messages = (diagnostics.texts(f"status[{index}].{part}") for part in ("name", "message"))
        for row in np.flatnonzero(levels >= 1):
            label = ": ".join(str(texts[row]) for texts in (names, messages) if texts is not None)
            alarms.setdefault((label, min(int(levels[row]), 2)), []).append(float(diagnostics.time[row]))
    found: list[Interval] = []
    for (label, level), times in alarms.items():
        found += _joined(times, label, level)
    return found


def _unchanged(time: Array, names: NDArray[Any]) -> list[Interval]:
    """Return the intervals in which a text stays the same."""
    changes = np.flatnonzero(names[1:] != names[:-1]) + 1
    bounds = [0, *changes.tolist(), len(names)]
    ends = [*(float(time[index]) for index in changes), float(time[-1])]
    return [Interval(float(time[first]), end, str(names[first])) for first, end in zip(bounds[:-1], ends, strict=True)]


def _flagged(time: Array, flags: NDArray[np.bool_], name: str, *, level: int = 0) -> list[Interval]:
    """Return the intervals in which a flag is set; one sample counts until the next."""
    if not flags.any():
        return []
    padded = np.concatenate(([False], flags, [False]))
    edges = np.flatnonzero(padded[1:] != padded[:-1])
    last = time.size - 1
    return [
        Interval(float(time[first]), float(time[min(after, last)]), name, level)
        for first, after in zip(edges[::2], edges[1::2], strict=True)
    ]


def _joined(times: Sequence[float], name: str, level: int) -> list[Interval]:
    joined: list[Interval] = []
    for time in sorted(times):
        if joined and time <= joined[-1].end + 0.5 * REPEATED:
            joined[-1] = Interval(joined[-1].start, time + REPEATED, name, level)
        else:
            joined.append(Interval(time, time + REPEATED, name, level))
    return joined
