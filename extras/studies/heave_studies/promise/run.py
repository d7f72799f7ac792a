"""A case is run, without ROS, and judged; what its controller found and reported is read from its alarms."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_node.interface.alarm import ReadAlarm, Severity, alarms_in
from heave_node.kpi import WORSE_FLOOR, WORSE_WINDOW, efficiency, sigma, window_ratios
from heave_node.numerics.arrays import Array
from winch_controller_node.core.supervision.modes import ModeError
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.readings import Outputs

from heave_studies.promise.cases import DURATION, Case
from heave_studies.promise.deviation import TROUBLE
from heave_studies.promise.table import FACTOR
from heave_studies.study.cost import JUDGE, LOOP, START, Meter

Alarm = tuple[float, str]
"""Time [s] and line."""

WINCH, ENCODER, DRUM = "winch", "encoder", "drum"
PARTS = ("mru", "depth", ENCODER, "load_cell", "cable")
"""Parts that an alarm may blame by itself."""
LOAD = ("CABLE_SLACK", "TENSION_HIGH", "TENSION_TRAVEL", "TENSION_LIMIT_LOW")
"""Alarms of the load of a cable, which is as it should be."""
NO_BLAME = (*LOAD, "LOWERING_BLIND", *(code for code in ALARMS if code.startswith("NOT_DESIGNABLE")))
NO_WARNING = ("AUTHORITY_LIMITED", "PROGRAMME_REJECTED", "PREVIEW_REJECTED")
"""Alarms above an event that are no trouble of a part."""
IDENTIFIED = ("WINCH_MODEL_UPDATED", "IDENTIFIED")
"""How the codes of events begin that name a part which is not as stated."""


@dataclass(frozen=True)
class Finding:
    """A part that is blamed."""

    time: float  # [s]
    parts: tuple[str, ...]  # one of these is at fault
    words: str  # of the alarm


def changes_in(text: str) -> list[tuple[str, float]]:
    """Return what the text of an updated model names, with the values that were identified."""
    return [(name, float(value)) for name, value in re.findall(r"([a-z][a-z ]*?) (-?[\d.]+)[^,(]*\(was", text)]


def blamed_by(alarm: ReadAlarm, *, noise: bool = True) -> tuple[str, ...]:
    """Return the parts of which an `alarm` blames one; empty: none. Whether too much `noise` is blame is a choice."""
    if alarm.code == "WINCH_MODEL_UPDATED":
        return (WINCH, ENCODER) if [name for name, _ in changes_in(alarm.text)] == ["gain by the encoder"] else (WINCH,)
    part = next((row.part for row in ALARMS.of_code(alarm.code)), "")
    is_event = alarm.severity is Severity.EVENT and not alarm.code.startswith(IDENTIFIED)
    if is_event or part not in PARTS or alarm.code in NO_BLAME:
        return ()
    is_noise = alarm.code.startswith("SENSOR_DOUBTFUL") and alarm.text.startswith("noise of ")
    return () if is_noise and not noise else (part,)


def findings_of(alarms: Sequence[Alarm]) -> list[Finding]:
    """Return what the `alarms` of a run blame."""
    read = [(time, words, one) for time, words in alarms for one in alarms_in(words)]
    return [Finding(time, parts, words) for time, words, one in read if (parts := blamed_by(one))]


def warnings_of(alarms: Sequence[Alarm]) -> list[float]:
    """Return the times [s] of the `alarms` that report trouble; events, moves and limited authority do not."""
    read = [(time, one) for time, words in alarms for one in alarms_in(words)]
    troubles = [time for time, one in read if one.severity > Severity.EVENT and one.code not in NO_WARNING]
    return sorted(troubles + [time for time, one in read if one.code.startswith(IDENTIFIED)])


ALARMED = 1.5
"""Ratio to off that is not reached without an alarm."""

MOVE_LAG = 0.35
"""Delay and time constant of the winch of all scenarios [s]."""

LOOK = 20
"""Ticks from one look to the next at why there is no compensation."""

LOST_TIME = 60.0
"""Compensation is lost that is not active for so long at the end [s]."""


@dataclass(frozen=True)
class Outcome:
    """What a case came to."""

    # largest ratio of the unit to the uncompensated one over a minute; NaN: no minute could be judged [-]
    worst: float = math.nan
    at: float = math.nan  # where that minute begins [s]
    worst_of_all: float = math.nan  # the same with the allowed times [-]
    begin: float = math.nan  # when compensation began [s]; NaN: never
    reason: str = ""  # why it never began, or too late to be judged; empty: it was judged
    has_true_reason: bool = False  # a sensor that the reason names gave nothing to read
    given_up: int = 0  # how often compensation was faded out that nobody had asked to end
    # compensation was not active at the end, though nobody had asked for that and all could be read
    is_lost: bool = False
    right: tuple[str, ...] = ()  # findings that blame what differs
    wrong: tuple[str, ...] = ()  # findings that blame what does not
    is_alarmed: bool | None = None  # there was an alarm before the ratio reached `ALARMED`; None: it never did
    efficiency: float = 0.0  # of the unit, from 30 s after the beginning on; 0: it never began [-]
    refused: tuple[str, ...] = ()  # what an operator asked for in vain
    failure: str = ""  # why the case could not be run; empty: it could
    alarms: tuple[tuple[float, str], ...] = field(default=())  # all of them, with their times [s]
    cost: Mapping[str, float] = field(default_factory=dict)  # processor time by part [s]


def run_case(case: Case, duration: float = DURATION) -> Outcome:
    """Run a case for a `duration` [s], and judge it."""
    meter = Meter()
    try:
        with meter.of(START):
            scenario = case.load(duration)
            loop = ClosedLoop(loop_parameters(scenario))
        meter.watch(loop)
        operator = Operator(loop, case.actions, scenario.run.tick_period)
        obstacles: list[str] = []

        def on_tick(tick: int, outputs: Outputs) -> None:
            operator.act(tick)
            if outputs.mode != "compensating" and tick % LOOK == 0:
                obstacles.append(why_waiting(loop.controller))

        with meter.of(LOOP):
            record = loop.run(on_tick)
    except Exception as error:  # one case that cannot be run must not end the others; it stands in the table
        return Outcome(failure=f"{type(error).__name__}: {' '.join(str(error).split())}")
    stiffness = scenario.parameters["cable_sim"].cable.axial_stiffness
    with meter.of(JUDGE):
        found = judged(case, record, stiffness, next((words for words in reversed(obstacles) if words), ""))
    return replace(found, refused=tuple(operator.refused), cost=meter.seconds)


def why_waiting(controller: Any) -> str:
    """Return in words why the `controller` does not compensate; empty: nothing stands against it."""
    return str(controller.modes.obstacle)


def judged(case: Case, record: LoopRecord, stiffness: float = math.inf, obstacle: str = "") -> Outcome:
    """Return what the `record` of a case came to.

    Parameters
    ----------
    case, record : of the run
    stiffness : EA of the cable [N]
    obstacle : what stood against compensation last, in words
    """
    counts_otherwise = bool({ENCODER, DRUM} & set(case.parts))
    unit = heave_of(record, stiffness, counts_otherwise=counts_otherwise)
    time, off = record.column("time"), record.column("uncompensated")
    compensates = np.array([mode == "compensating" for mode in record.modes])
    begin = float(time[np.argmax(compensates)]) if np.any(compensates) else math.nan
    starts, ratios = window_ratios(time, unit, off, begin + TROUBLE, floor=WORSE_FLOOR)
    counts = counted(starts, case.excused)
    alarms = tuple((float(at), str(alarm)) for at, alarm in record.alarms)
    found = findings_of(alarms)
    right = [f"{one.time:.0f} s: {one.words}" for one in found if set(one.parts) & set(case.parts)]
    wrong = [f"{one.time:.0f} s: {one.words}" for one in found if not set(one.parts) & set(case.parts)]
    outcome = Outcome(
        begin=begin,
        given_up=_given_up(case, time, record.modes),
        is_lost=_is_lost(case, time, compensates),
        right=tuple(dict.fromkeys(right)),
        wrong=tuple(dict.fromkeys(wrong)),
        alarms=alarms,
    )
    if not np.any(counts):
        reason = f"{'never began' if math.isnan(begin) else f'began at {begin:.0f} s'}: {obstacle or 'unknown'}"
        is_true = any(sensor in reason for sensor, *_ in case.lost)
        return replace(outcome, reason=reason, has_true_reason=is_true)
    after = time >= begin + TROUBLE
    worst = int(np.argmax(np.where(counts, ratios, -1.0)))
    return replace(
        outcome,
        worst=float(ratios[worst]),
        at=float(starts[worst]),
        worst_of_all=float(np.max(ratios)),
        is_alarmed=_is_alarmed(starts[counts], ratios[counts], begin, alarms),
        efficiency=efficiency(sigma(unit[after]), sigma(off[after])),
    )


def heave_of(record: LoopRecord, stiffness: float, *, counts_otherwise: bool = False) -> Array:
    """Return the heave of the unit about the depth at which it is to be, with what no move can help left out [m].

    The drum is behind its set-point by its lag, and cable that is paid out is stretched by the tension at the top: both
    would count as heave while the winch moves on.

    Parameters
    ----------
    record : of the run
    stiffness : EA of the cable [N]
    counts_otherwise : drum or encoder count other metres than the unit moves: how many is fitted, for a wrong depth is
        no heave
    """
    time, unit, planned = record.column("time"), record.column("unit"), record.column("depth_set_point")
    moved = np.interp(time - MOVE_LAG, time, planned)
    if np.ptp(moved) == 0.0:
        return unit + moved
    stretch = 1.0 + float(np.mean(record.column("top_tension"))) / stiffness
    if counts_otherwise:
        stretch = -float(np.polyfit(moved, unit, 1)[0])
    return unit + stretch * moved


def counted(starts: Array, excused: Sequence[tuple[float, float]]) -> Array:
    """Return which minutes count that begin at `starts` [s]: none that reaches into a time, from and to, `excused`."""
    counts = np.ones(starts.size, dtype=bool)
    for first, last in excused:
        counts &= (starts + WORSE_WINDOW <= first) | (starts >= last)
    return counts


def _is_alarmed(starts: Array, ratios: Array, begin: float, alarms: Sequence[tuple[float, str]]) -> bool | None:
    """Tell whether there was an alarm in compensation before a minute with the ratio `ALARMED` was over."""
    reached = np.flatnonzero(ratios >= ALARMED)
    if not reached.size:
        return None
    end = float(starts[reached[0]]) + WORSE_WINDOW
    return any(begin <= at <= end for at in warnings_of(alarms))


def _given_up(case: Case, time: Array, modes: Sequence[str]) -> int:
    """Return how often compensation was faded out, but for what was requested."""
    fades = np.array([mode == "fade_out" for mode in modes])
    entered = time[1:][fades[1:] & ~fades[:-1]]
    return int(np.count_nonzero([not any(a <= at <= b for a, b in _requested(case)) for at in entered]))


def _requested(case: Case) -> list[tuple[float, float]]:
    """Return the times, from and to [s], in which an operator has the loop stopped."""
    return list(case.excused) if "stop and restart" in case.deviations else []


def _is_lost(case: Case, time: Array, compensates: Array) -> bool:
    if not np.any(compensates):
        return False
    end = float(time[-1])
    has_nothing_to_read = any(sensor in ("mru", "encoder") and to > end - LOST_TIME for sensor, _, to in case.lost)
    return not has_nothing_to_read and not np.any(compensates[time > end - LOST_TIME])


class Operator:
    """Does in a running loop what an operator is drawn to do.

    Parameters
    ----------
    loop : that runs
    actions : time [s], what, value, in order of time
    tick_period : [s]

    Attributes
    ----------
    refused : what could not be done, in words
    """

    def __init__(self, loop: ClosedLoop, actions: tuple[tuple[float, str, float], ...], tick_period: float) -> None:
        self._loop, self._dt = loop, tick_period
        self._due = list(actions)
        self._speed = 0.0
        self.refused: list[str] = []

    def act(self, tick: int) -> None:
        """Do what is due after a `tick`; a speed is asked for again in every tick, as a joystick does."""
        controller = self._loop.controller
        try:
            while self._due and self._due[0][0] <= tick * self._dt:
                _, what, value = self._due.pop(0)
                if what == FACTOR:
                    controller.set_factor(value)
                else:
                    self._speed = value
            if self._speed:
                controller.operate(self._speed)
        except ModeError as error:
            self._speed = 0.0
            self.refused.append(f"{tick * self._dt:.0f} s: {error}")
