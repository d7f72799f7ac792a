"""Landing, and the rolling window of the figures of merit, by ctypes, on the memory that C++ has."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from heave_core.kpi_table import KPI_DESIGN, KPI_ROW, KPI_STATE
from heave_core.landing_table import LANDING_DESIGN, LANDING_SEEN, LANDING_STATE
from heave_core.library import fill, library, new

FLAGS = 7
"""Numbers of LandingState in front of its event."""

OBSERVED = 7
"""Rows of LANDING_SEEN that are observed, before a mode is decided on."""


class TrendFound(NamedTuple):
    """Slope of a straight line through readings, its standard error, whether they are known, and the mean."""

    slope: float
    error: float
    is_known: float
    mean: float


class LandingWatch:
    """Trends of depth, tension and payout, and where the unit is.

    Parameters
    ----------
    design : values by the names of LANDING_DESIGN

    Attributes
    ----------
    design, state : structured arrays of one element
    flags : the first numbers of the state, in its order, on its memory
    """

    def __init__(self, design: Mapping[str, Any]) -> None:
        core = library()
        self.design, self.state = new(LANDING_DESIGN), new(LANDING_STATE)
        self._seen = np.zeros(len(LANDING_SEEN.rows))
        self.flags = self.state.view(np.uint8)[: 8 * (FLAGS + 1)].view(np.float64)
        self._state_at = self.state.ctypes.data
        self._at = self.design.ctypes.data, self._state_at, self._seen.ctypes.data
        self._core, self._depth = core, core.heave_core_landing_depth
        self._observe, self._judge = core.heave_core_landing_observe, core.heave_core_landing
        self.take_design(design)
        core.heave_core_landing_begin(self._state_at)

    def take_design(self, design: Mapping[str, Any]) -> None:
        """Go by another `design` from now on."""
        fill(self.design[0], design)

    def add_depth(self, time: float, depth: float) -> None:
        """Take in a reading of the `depth` [m], positive down, of a `time` [s]."""
        self._depth(self._state_at, time, depth)

    def observe(self, *seen: float) -> None:
        """Take in what is `seen` in a tick: the first OBSERVED rows of LANDING_SEEN."""
        self._seen[:OBSERVED] = seen
        self._observe(*self._at)

    def judge(self, filtered_tension: float, sees_landing: bool, has_depths: bool, compensates: bool) -> int:
        """Return what has happened in the tick that was observed last, a Landed, by the last rows of LANDING_SEEN."""
        self._seen[OBSERVED:] = filtered_tension, sees_landing, has_depths, compensates
        self._judge(*self._at)
        return int(self.flags[FLAGS])

    def trend(self, name: str, window: float) -> TrendFound:
        """Return what the trend of a `name` in LANDING_STATE shows over a `window` [s]."""
        design, found = self.design[0], np.zeros(4)
        given = float(design["least_readings"]), float(design["filled"])
        self._core.heave_core_trend(self.state[name].ctypes.data, window, *given, found.ctypes.data)
        return TrendFound(*found.tolist())


class KpiStatistics(NamedTuple):
    """Statistics over the window: the rows of KPI_WINDOW, with their meanings and units."""

    rows: float
    unit: float
    uncompensated: float
    tip: float
    outlet: float
    largest: float
    speed: float
    acceleration: float
    power: float
    mean_power: float
    least_tension: float
    largest_tension: float
    at_limit: float


class KpiRing:
    """The ticks of the rolling window.

    Parameters
    ----------
    design : values by the names of KPI_DESIGN
    """

    def __init__(self, design: Mapping[str, Any]) -> None:
        core = library()
        self._design, self._state = new(KPI_DESIGN), new(KPI_STATE)
        fill(self._design[0], design)
        self._rows = np.zeros((int(design["rows"]), len(KPI_ROW.rows)))
        self._row, self._window = np.zeros(len(KPI_ROW.rows)), np.zeros(len(KpiStatistics._fields))
        self._at = self._design.ctypes.data, self._state.ctypes.data, self._rows.ctypes.data
        self._row_at, self._window_at = self._row.ctypes.data, self._window.ctypes.data
        self._add, self._summarise = core.heave_core_kpi_add, core.heave_core_kpi

    def take_limits(self, speed: float, acceleration: float) -> None:
        """Count the winch as at its limit from a `speed` [m/s] or an `acceleration` [m/s^2] on."""
        self._design["speed"], self._design["acceleration"] = speed, acceleration

    def add(self, *row: float) -> None:
        """Take one tick in, by the rows of KPI_ROW; acceleration and limit follow from the rates."""
        self._row[:] = row
        self._add(*self._at, self._row_at)

    def statistics(self) -> KpiStatistics:
        """Return the statistics over what the window holds."""
        self._summarise(*self._at, self._window_at)
        return KpiStatistics._make(self._window.tolist())
