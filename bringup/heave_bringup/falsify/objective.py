"""How bad a case is: the worst minute of compensation that no alarm announced. Pure components, no ROS."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from heave_bags.analyse.events import COMPENSATES
from heave_node import kpi
from heave_node.interface.alarm import Severity
from heave_node.numerics.arrays import Array

from heave_bringup.campaign.runs import Task
from heave_bringup.closed_loop import ClosedLoop, LoopRecord, loop_parameters
from heave_bringup.run.loop_signals import run_signals

ANNOUNCED = kpi.WORSE_WINDOW
"""A minute is announced by an alarm that came in it, or within so long before it [s]."""


@dataclass(frozen=True)
class Minute:
    """The worst minute of a case.

    Attributes
    ----------
    ratio : s(z) / s(z_off); 0: every minute was announced
    start : of it [s]; NaN: there is none
    alarms : codes that came in the whole run, each once
    failure : why the case could not be run; "": it could
    """

    ratio: float
    start: float = math.nan
    alarms: tuple[str, ...] = ()
    failure: str = ""


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
    alarms = tuple(dict.fromkeys(alarm.code for _, alarm in record.alarms))
    ratios = np.where(silent(record, starts, least), ratios, 0.0)
    if not ratios.size or not ratios.max() > 0.0:
        return Minute(0.0, alarms=alarms)
    worst = int(ratios.argmax())
    return Minute(float(ratios[worst]), float(starts[worst]), alarms)


def silent(record: LoopRecord, starts: Array, least: Severity) -> Array:
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

    def any_in(events: Array, before: float) -> Array:
        events = np.sort(events)
        first, after = np.searchsorted(events, [starts - before, starts + kpi.WORSE_WINDOW])
        return np.asarray(after > first)

    return np.asarray(~any_in(rests, 0.0) & ~any_in(loud, ANNOUNCED))
