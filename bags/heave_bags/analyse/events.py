"""What held when in a run: modes, limits, faults and alarms as intervals of time."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain, pairwise
from typing import Any

import numpy as np
from heave_node.interface import topics
from heave_node.interface.alarm import Severity, alarms_in, kind_of
from heave_node.interface.codes import (
    ALARMS,
    COMPENSATION_LOST,
    MODE,
    OPERATOR,
    REQUESTED,
    SENSOR,
    WINCH_MODEL_UPDATED,
    SensorLevel,
    WinchFault,
    WinchLimit,
    time_key,
    timed_words,
    without_figures,
)
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray

from heave_bags.analyse.reading.fields import Fields
from heave_bags.signals import RunSignals, Signal

REPEATED = 1.0
"""Time for which a message of /diagnostics holds, until the next [s]."""
TICKS = 0.11
"""Time after which what an alarm is about stands in the controller's state at the latest: two ticks [s]."""

HOLDS_TENSION = "constant_tension"
LOST = f"{COMPENSATION_LOST} ({Severity.HIGH.word})"
"""Head of the line about compensation that ended unrequested, as the controller's table of alarms has it."""
COMPENSATES = ("compensating", HOLDS_TENSION)
"""Modes of the controller in which the winch does its work."""
OFF = "off"
"""Mode of a controller whose law never moves the winch."""
EMERGENCY_STOP = "emergency_stop"
"""Mode after an operator's emergency stop, or the winch's own."""


MODE_PART = f"{topics.CONTROLLER_STATE.publisher}: {MODE}"
"""Part of /diagnostics in which the controller reports its mode and why."""
ALARMS_PART = f"{topics.CONTROLLER_STATE.publisher}: {ALARMS}"
"""Part in which the controller reports what it has identified, and its faults."""
SENSOR_PARTS = f"{topics.CONTROLLER_STATE.publisher}: {SENSOR} "
"""Prefix of the parts in which it reports the state of each sensor; their faults are among its alarms, too."""
SENSOR_CODES = {SensorLevel.SUSPECT: "SENSOR_DOUBTFUL", SensorLevel.LOST: "SENSOR_LOST"}
"""Codes of its alarms about a sensor that it holds so."""
RESTORED = ("_RESTORED", "_RECOVERED")
"""Ends of the codes of events that end an alarm whose code begins with the same word."""
OPERATOR_PART = f": {OPERATOR}"
"""End of the name of the part in which a node reports what an operator has requested of it."""


@dataclass(frozen=True)
class Interval:
    """Something, its `name`, that held from `start` to `end` [s]: a mode, an alarm of a `level`, a limit."""

    start: float
    end: float
    name: str
    level: int = 0  # 0 plain, 1 warning, 2 error
    reason: str = ""  # reason of a mode, in the controller's words


def words(code: WinchFault | WinchLimit | SensorLevel) -> str:
    """Return a code as words: its name."""
    return str(code.name).lower().replace("_", " ")


def modes(state: Fields) -> list[Interval]:
    """Return the modes of the controller from the columns of its `state`."""
    names, reasons = state.texts("mode"), state.texts("reason")
    if names is None or not names.size:
        return []
    found = _unchanged(state.time, names)
    if reasons is None:
        return found
    rows = np.searchsorted(state.time, [interval.start for interval in found])
    return [replace(interval, reason=str(reasons[row])) for interval, row in zip(found, rows, strict=True)]


def waits(state: Fields) -> list[Interval]:
    """Return when the controller did not compensate, and why, from the columns of its `state`.

    A reason whose figures alone change, as of a countdown, is one; it is reported as it was last.
    """
    names, reasons = state.texts("mode"), state.texts("reason")
    if names is None or reasons is None or not names.size:
        return []
    kinds = np.array([f"{name}: {without_figures(str(reason))}" for name, reason in zip(names, reasons, strict=True)])
    stretches = _unchanged(state.time, kinds)
    rows = [*(np.searchsorted(state.time, [interval.end for interval in stretches[:-1]]) - 1), len(names) - 1]
    found = [
        replace(interval, name=str(names[row]), reason=str(reasons[row]))
        for interval, row in zip(stretches, rows, strict=True)
    ]
    return [interval for interval in found if interval.name not in COMPENSATES]


def take_modes(signals: RunSignals, time: Array, modes: NDArray[Any]) -> None:
    """Fill in the `signals` of a run when its controller worked, held a tension and changed its mode, by its `modes`,
    names, at each `time` [s].

    Nothing is filled in under law off, which has one mode alone.
    """
    if modes.size < 2 or np.all(modes == OFF):
        return
    signals.compensating = Signal(time, np.isin(modes, COMPENSATES).astype(float))
    signals.holds_tension = Signal(time, (modes == HOLDS_TENSION).astype(float))
    signals.mode_changes = Signal(time, np.append(0.0, modes[1:] != modes[:-1]))


def is_loss(before: str, mode: str, reason: str) -> bool:
    """Return whether compensation was lost by a change from the mode `before` to `mode`: it ended, and nobody had asked
    for that by the `reason` that the controller gave.
    """
    return before in COMPENSATES and mode not in COMPENSATES and not reason.endswith(REQUESTED)


def loss_words(time: float, mode: str, reason: str) -> str:
    """Return the line about a loss of compensation at a `time` [s] into a `mode` for a `reason`."""
    return f"{time_key(time)}: {LOST}: mode {mode}{f': {reason}' if reason else ''}"


def losses(found: Sequence[Interval]) -> list[Interval]:
    """Return the modes, of those `found` one after another, into which compensation was lost."""
    return [mode for before, mode in pairwise(found) if is_loss(before.name, mode.name, mode.reason)]


def winch_limits(winch: Fields) -> list[Interval]:
    """Return when which limit of the winch acted, and when its brake was on."""
    flags = winch.codes("limits_hit")
    found: list[Interval] = []
    for limit in WinchLimit:
        if limit:
            found += _flagged(winch.time, (flags & limit) != 0, words(limit))
    return [*found, *_flagged(winch.time, winch.codes("brake") != 0, "brake")]


def winch_faults(winch: Fields) -> list[Interval]:
    """Return when the winch had stopped by itself, by the code of its alarm."""
    codes = winch.codes("fault")
    found: list[Interval] = []
    for fault in WinchFault:
        if fault:
            code = f"WINCH_{fault.name}{'_FAULT' if fault is WinchFault.DRIVE else ''}"
            found += _flagged(winch.time, codes == fault, code, level=2)
    return found


def sensor_alarms(state: Fields) -> list[Interval]:
    """Return when the controller held a sensor as `suspect` or `lost`, by the code of that, from its `state`."""
    found: list[Interval] = []
    for index in state.indices("sensors[].level"):
        levels, names = state.codes(f"sensors[{index}].level"), state.texts(f"sensors[{index}].sensor")
        for level, code in SENSOR_CODES.items():
            where = levels == level
            if where.any() and names is not None:
                found += _flagged(state.time, where, f"{code}, {str(names[where][0]).upper()}", level=int(level))
    return found


def diagnostic_alarms(
    diagnostics: Fields, holding: Sequence[Interval] = (), *, has_modes: bool = False
) -> list[Interval]:
    """Return the warnings and errors of /diagnostics, by its columns, each from when it was raised to its end.

    One whose figures alone change, as of a countdown, is one. What the controller raises lasts as long as what it is
    about is reported, and is at one time where nothing reports that.

    Parameters
    ----------
    diagnostics : columns of the topic
    holding : what is known to the tick: `sensor_alarms`, `winch_faults`, and why the controller did not compensate
        (`waits`). A sensor or fault that no alarm names is returned, too; a sensor is a warning then where there are
        others: the controller knew why, as when the computer stood still
    has_modes : the controller's modes are known to the tick, and not reported here
    """
    lasting: dict[tuple[str, int], tuple[str, list[float]]] = {}
    raised: list[Interval] = []
    for index in diagnostics.indices("status[].level"):
        levels = diagnostics.codes(f"status[{index}].level")
        names, messages = (diagnostics.texts(f"status[{index}].{part}") for part in ("name", "message"))
        for row in np.flatnonzero(levels >= 1):
            label = ": ".join(str(texts[row]) for texts in (names, messages) if texts is not None)
            name = "" if names is None else str(names[row])
            if has_modes and name == MODE_PART:
                continue
            time, level = float(diagnostics.time[row]), min(int(levels[row]), 2)
            if name == ALARMS_PART and (reported := timed_words("" if messages is None else str(messages[row]))):
                raised += [one for at, text in reported for one in _raised(at, text, level)]
                continue
            is_reported_once = name.endswith(f": {ALARMS}")
            kind = label if is_reported_once else f"{name}: {kind_of('' if messages is None else str(messages[row]))}"
            _, times = lasting.setdefault((kind, _level(label, level)), (label, []))
            times.append(time)
    parts = [one for (_, level), (label, times) in lasting.items() for one in _joined(times, label, level)]
    since = [replace(one, start=one.start - REPEATED) for one in parts]  # for so long, reported a second later
    raised = _spans(sorted(raised, key=lambda one: one.start), (holding, since))
    shown = raised + [one for one in parts if not _is_told(one, raised)]
    others = [one for one in holding if one.level and not _is_told(one, shown)]
    return shown + [replace(one, level=1) if raised and one.name.startswith(SENSOR.upper()) else one for one in others]


def _raised(time: float, text: str, level: int) -> list[Interval]:
    """Return what the controller raised at a `time` [s], a `text` of one alarm or more: each, or the text itself."""
    texts = [f"{one.code} ({one.severity.word}): {one.text}" for one in alarms_in(text)] or [text]
    return [Interval(time, time, f"{ALARMS_PART}: {one}", _level(one, level)) for one in texts]


def _spans(raised: Sequence[Interval], known: Sequence[Sequence[Interval]]) -> list[Interval]:
    """Return the alarms that were `raised`, in order, each to the end of what it is about, by the first of what is
    `known` that shows it, else until it is reported as restored.

    One that is raised again meanwhile in the same words is one.
    """
    found: dict[str, Interval] = {}
    spans: list[Interval] = []
    in_order = [sorted(holding, key=lambda held: held.start) for holding in known]
    for one in raised:
        kind = without_figures(one.name.partition(". ")[0])
        if kind in found and one.start < found[kind].end:
            continue
        ends = (end for holding in in_order if (end := _end_of(one, holding)) > one.start)
        restored = (later.start for later in raised if one.level and later.start > one.start and _restores(later, one))
        found[kind] = replace(one, end=next(chain(ends, restored), one.start))
        spans.append(found[kind])
    return spans


def _end_of(raised: Interval, holding: Sequence[Interval]) -> float:
    """Return the end of what an alarm was `raised` about [s], by what was `holding`, in order; its start if none was.

    A reason may go on in the next mode.
    """
    end = raised.start
    for held in holding:
        if held.start - TICKS <= end <= held.end and _is_about(raised, held):
            end = held.end
    return end


def _codes(one: Interval) -> list[str]:
    return [alarm.code for alarm in alarms_in(one.name)] or [one.name]


def _is_about(raised: Interval, held: Interval) -> bool:
    """Return whether what was `raised` is a sensor, a part of diagnostics or a reason of the mode that is `held` so."""
    return any(code in _codes(held) or f"{code}: " in held.reason for code in _codes(raised))


def _restores(later: Interval, one: Interval) -> bool:
    """Return whether an event, `later`, says that what an alarm, `one`, was about is well again: ADVISER_RESTORED."""
    (end, _, part), (kind, _, of) = (_codes(each)[0].partition(", ") for each in (later, one))
    return end.endswith(RESTORED) and (end.partition("_")[0], part) == (kind.partition("_")[0], of)


def _is_told(held: Interval, raised: Sequence[Interval]) -> bool:
    """Return whether an alarm `raised` beside what is `held` so, within a second, has its code or names its sensor."""
    beside = (one for one in raised if one.start - REPEATED <= held.end and held.start - REPEATED <= one.end)
    told = {code.partition(", ")[2] or code for one in beside if one.level for code in _codes(one)}
    return any((code.partition(", ")[2] or code) in told for code in _codes(held))


def _level(text: str, level: int) -> int:
    """Return the level of the gravest alarm in a `text`, 2 where it is critical or high, 0 of an event; of a text
    without alarms the `level` of its part.
    """
    gravest = max((alarm.severity for alarm in alarms_in(text)), default=None)
    return level if gravest is None else 2 if gravest >= Severity.HIGH else int(gravest > Severity.EVENT)


def operator_requests(diagnostics: Fields) -> list[Interval]:
    """Return what an operator has requested, from the columns of /diagnostics: factor, speed, depth, faults."""
    found: list[Interval] = []
    for index in diagnostics.indices("status[].level"):
        names, messages = (diagnostics.texts(f"status[{index}].{part}") for part in ("name", "message"))
        if names is None or messages is None:
            continue
        reported = [
            timed_words(message) for name, message in zip(names, messages, strict=True) if name.endswith(OPERATOR_PART)
        ]
        found += [Interval(time, time, words) for one in reported for time, words in one]
    return sorted(found, key=lambda one: one.start)


def identified_limits(alarms: Sequence[Interval], quantity: str) -> list[tuple[float, float]]:
    """Return from when [s] on the controller has used which limit of the winch that it had learnt, by the `alarms` of a
    run that report it.

    The `quantity` is speed [m/s] or acceleration [m/s^2].
    """
    found = []
    for alarm in sorted(alarms, key=lambda one: one.start):
        updates = [one.text for one in alarms_in(alarm.name) if one.code == WINCH_MODEL_UPDATED]
        reported = [value for text in updates for value in re.findall(rf"\b{quantity} limit [a-z ]*([\d.]+) m/s", text)]
        found += [(alarm.start, float(value)) for value in reported]
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
