"""The worst minute of compensation that no alarm announced. No ROS."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from heave_bags.analyse.events import COMPENSATES
from heave_bags.signals import RunSignals
from heave_bringup.closed_loop import LoopRecord
from heave_node import kpi
from heave_node.interface.alarm import Severity
from heave_node.numerics.arrays import Array
from numpy.typing import NDArray

ANNOUNCED = kpi.WORSE_WINDOW
"""A minute is announced by an alarm that came in it, or within so long before it [s]."""
LEAST = Severity.MEDIUM
"""Severity from which on an alarm announces."""


class Minute(NamedTuple):
    """A minute of a run."""

    ratio: float  # s(z) / s(z_off) [-]; NaN: no minute counts
    start: float = math.nan  # of it [s]


NO_MINUTE = Minute(math.nan)


def silent_minute(record: LoopRecord, signals: RunSignals, transient: float) -> Minute:
    """Return the worst minute of a run in which compensation was active throughout and that no alarm announced.

    Parameters
    ----------
    record, signals : of the run
    transient : time before which no minute begins [s]
    """
    heave, off = signals.unit_heave, signals.uncompensated_heave
    starts, ratios = kpi.window_ratios(heave.time, heave.value, off.at(heave), transient, floor=kpi.WORSE_FLOOR)
    counts = silent(record, starts) & np.isfinite(ratios)
    if not counts.any():
        return NO_MINUTE
    worst = int(np.where(counts, ratios, -1.0).argmax())
    return Minute(float(ratios[worst]), float(starts[worst]))


def silent(record: LoopRecord, starts: Array) -> NDArray[np.bool_]:
    """Return which minutes of a `record`, by their `starts` [s], were of compensation and not announced, shape (n,)."""
    time = record.column("time")
    rests = time[~np.isin(record.modes, COMPENSATES)]
    loud = np.array([at for at, alarm in record.alarms if alarm.severity >= LEAST])

    def any_in(events: Array, before: float) -> NDArray[np.bool_]:
        events = np.sort(events)
        first, after = np.searchsorted(events, [starts - before, starts + kpi.WORSE_WINDOW])
        return np.asarray(after > first)

    return np.asarray(~any_in(rests, 0.0) & ~any_in(loud, ANNOUNCED))
