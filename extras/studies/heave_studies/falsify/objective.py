"""How bad a case is: the worst minute of compensation that no alarm announced, and the worst of all. No ROS."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from heave_bags.analyse.events import COMPENSATES
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.run.loop_signals import run_signals
from heave_node import kpi
from heave_node.interface.alarm import Severity
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray

from heave_studies.campaign.runs import Task

ANNOUNCED = kpi.WORSE_WINDOW
"""A minute is announced by an alarm that came in it, or within so long before it [s]."""


@dataclass(frozen=True)
class Minute:
    """The worst minute of a case."""

    ratio: float  # s(z) / s(z_off) [-]; 0: every minute was announced
    start: float = math.nan  # of it [s]; NaN: there is none
    alarms: tuple[str, ...] = ()  # codes that came in the whole run, each once
    failure: str = ""  # why the case could not be run; "": it could
    # s(z) / s(z_off) of the worst of all minutes after the transient, announced or not [-]: `worst_minute` of a bag
    of_all: float = 0.0
    of_all_start: float = math.nan  # of that one [s]; NaN: there is none
    announced_by: tuple[str, ...] = ()  # codes that announced that one, each once

    @property
    def of_all_words(self) -> str:
        """The worst of all minutes, and why it does not count where it does not."""
        if self.of_all_start == self.start:
            return "the same"
        why = (
            f"announced by {', '.join(self.announced_by)}"
            if self.announced_by
            else "compensation was not active throughout"
        )
        return f"{self.of_all:.3f} from {self.of_all_start:.0f} s on, {why}"


def worst_minute(task: Task, least: Severity) -> Minute:
    """Run a case and return its worst minute in which compensation was active and nothing was announced.

    Parameters
    ----------
    task : the case
    least : severity from which on an alarm announces
    """
    parameters = loop_parameters(task.scenario)
    try:
        record = ClosedLoop(parameters).run()
        signals = run_signals(record, parameters)
    except Exception as error:  # one case that cannot be run must not end the search; it is kept with its words
        return Minute(0.0, failure=" ".join(str(error).split()) or type(error).__name__)
    heave, off = signals.unit_heave, signals.uncompensated_heave
    starts, ratios = kpi.window_ratios(
        heave.time, heave.value, off.at(heave), task.scenario.run.transient, floor=kpi.WORSE_FLOOR
    )
    return judged(record, starts, ratios, least)


def judged(record: LoopRecord, starts: Array, ratios: Array, least: Severity) -> Minute:
    """Return the worst silent minute of a run, and the worst of all.

    Parameters
    ----------
    record : of the run
    starts : of the minutes [s], shape (n,)
    ratios : s(z) / s(z_off) over each, shape (n,)
    least : severity from which on an alarm announces
    """
    alarms = tuple(dict.fromkeys(alarm.code for _, alarm in record.alarms))
    if not ratios.size:
        return Minute(0.0, alarms=alarms)
    ratios = np.where(ratios > 0.0, ratios, 0.0)  # one without a number is none
    quiet = np.where(silent(record, starts, least), ratios, 0.0)
    worst, most = int(quiet.argmax()), int(ratios.argmax())
    start, begin = (float(starts[one]) for one in (worst, most))
    loud = dict.fromkeys(
        alarm.code
        for at, alarm in record.alarms
        if alarm.severity >= least and begin - ANNOUNCED <= at < begin + kpi.WORSE_WINDOW
    )
    return Minute(
        float(quiet[worst]),
        start if quiet[worst] > 0.0 else math.nan,
        alarms,
        of_all=float(ratios[most]),
        of_all_start=begin,
        announced_by=tuple(loud),
    )


def silent(record: LoopRecord, starts: Array, least: Severity) -> NDArray[np.bool_]:
    """Return which minutes were of compensation throughout and not announced, shape (n,) of bool.

    Parameters
    ----------
    record : of the run
    starts : of the minutes [s], shape (n,)
    least : severity from which on an alarm announces
    """
    time = record.column("time")
    rests = time[~np.isin(record.modes, COMPENSATES)]
    loud = np.array([at for at, alarm in record.alarms if alarm.severity >= least])

    def any_in(events: Array, before: float) -> NDArray[np.bool_]:
        events = np.sort(events)
        first, after = np.searchsorted(events, [starts - before, starts + kpi.WORSE_WINDOW])
        return np.asarray(after > first)

    return np.asarray(~any_in(rests, 0.0) & ~any_in(loud, ANNOUNCED))
