"""What is watched, by ctypes: landing, figures of merit, drum, winch and its link; and the drum that is simulated."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from heave_core import watch_table as table
from heave_core.library import dtype_of, fill, library, named, new
from heave_core.watch_table import (
    KPI_DESIGN,
    KPI_ROW,
    KPI_STATE,
    KPI_WINDOW,
    LANDING_DESIGN,
    LANDING_STATE,
    SERVO_RUN,
)

Array = NDArray[np.float64]

FLAGS = 1 + [row.name for row in LANDING_STATE.rows].index("event")
"""Numbers of LandingState up to its event."""


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
        self.design, self.state = new(LANDING_DESIGN), new(LANDING_STATE)
        self.flags = self.state.view(np.uint8)[: 8 * FLAGS].view(np.float64)
        self.take_design(design)
        library().heave_core_landing_begin(self.state.ctypes.data)

    def take_design(self, design: Mapping[str, Any]) -> None:
        """Go by another `design` from now on."""
        fill(self.design[0], design)


KpiStatistics = named(KPI_WINDOW)
"""Statistics over the window."""


class KpiRing:
    """The ticks of the rolling window.

    Parameters
    ----------
    design : values by the names of KPI_DESIGN

    Attributes
    ----------
    records : its arrays by the names of ACTING in `heave_core.law`
    """

    def __init__(self, design: Mapping[str, Any]) -> None:
        self._design, self._state = new(KPI_DESIGN), new(KPI_STATE)
        fill(self._design[0], design)
        self._rows = np.zeros((int(design["rows"]), len(KPI_ROW.rows)))
        self._window = np.zeros(len(KPI_WINDOW.rows))
        self._at = self._design.ctypes.data, self._state.ctypes.data, self._rows.ctypes.data
        self.records = {"kpi": self._design, "kpi_state": self._state, "kpi_rows": self._rows}
        self._window_at, self._summarise = self._window.ctypes.data, library().heave_core_kpi

    def take_limits(self, speed: float, acceleration: float) -> None:
        """Count the winch as at its limit from a `speed` [m/s] or an `acceleration` [m/s^2] on."""
        self._design["speed"], self._design["acceleration"] = speed, acceleration

    def statistics(self) -> Any:
        """Return the statistics over what the window holds."""
        self._summarise(*self._at, self._window_at)
        return KpiStatistics._make(self._window.tolist())


WORK = 7
"""Numbers to work on, for each row that a drum watch keeps."""


class DrumOrders:
    """Orders and encoder readings of the last seconds.

    Parameters
    ----------
    values : by the names of DRUM_WATCH_DESIGN
    design, state : arrays of one of these structures; None: its own

    Attributes
    ----------
    design, state : structured arrays of one element
    room : rows that are kept, and what they are worked on with
    at : addresses of all four
    """

    def __init__(self, values: Mapping[str, Any], design: Any = None, state: Any = None) -> None:
        core, kept = library(), int(values["kept"])
        self.design = new(table.DRUM_WATCH_DESIGN) if design is None else design
        self.state = new(table.DRUM_WATCH_STATE) if state is None else state
        fill(self.design[0], values)
        self.room = {"drum_rows": np.zeros(kept, dtype_of(table.DRUM_ROW)), "drum_work": np.zeros(WORK * kept)}
        self._row = np.zeros(len(table.DRUM_ROW.rows))
        self.at = [one.ctypes.data for one in (self.design, self.state, *self.room.values())]
        self._row_at = self._row.ctypes.data
        self._add, self._reset = core.heave_core_drum_add, core.heave_core_drum_reset

    def add(self, *row: float) -> None:
        """Take a tick in, by the rows of DRUM_ROW."""
        self._row[:] = row
        self._add(*self.at, self._row_at)

    def reset(self, payout: float) -> None:
        """Restart with the drum at rest at a `payout` [m]."""
        self._reset(*self.at, payout)

    def restart(self) -> None:
        """Compare from now on."""
        self.state["readings"] = 0


class Link:
    """How late commands are, and who was silent.

    Parameters
    ----------
    values : by the names of LINK_DESIGN
    design, state : arrays of one of these structures; None: its own

    Attributes
    ----------
    state : structured array of one element
    minute : by how much the commands of the last minute were late, in a ring [s]
    kept : that and the window after it
    """

    def __init__(self, values: Mapping[str, Any], design: Any = None, state: Any = None) -> None:
        count = int(values["minute"])
        self._design = new(table.LINK_DESIGN) if design is None else design
        self.state = new(table.LINK_STATE) if state is None else state
        fill(self._design[0], values)
        self.kept = np.zeros(count + int(values["window"]))
        self.minute = self.kept[:count]
        self.at = [one.ctypes.data for one in (self._design, self.state, self.kept)]
        self._silence = library().heave_core_link_silence

    def silence(self, untaken: float, *, has_state: bool) -> None:
        """Take in whether the winch has reported in a tick, and for how long commands were `untaken` [s]."""
        self._silence(*self.at[:2], has_state, untaken)


class WinchRecord:
    """Drum, link, and whether authority is cut for them.

    Parameters
    ----------
    values : by the names of WINCH_WATCH_DESIGN

    Attributes
    ----------
    design, state : structured arrays of one element
    drum, link : on their memory
    records : its arrays by the names of WATCHING in `heave_core.law`
    """

    def __init__(self, values: Mapping[str, Any]) -> None:
        self.design, self.state = new(table.WINCH_WATCH_DESIGN), new(table.WINCH_WATCH_STATE)
        fill(self.design[0], values)
        self.drum = DrumOrders(values["drum"], self.design["drum"], self.state["drum"])
        self.link = Link(values["link"], self.design["link"], self.state["link"])
        self.records = {
            "winch_watch": self.design,
            "winch_state": self.state,
            **self.drum.room,
            "minute": self.link.kept,
        }


class LoadRecord:
    """Tension, rope, and the time at the winch's limits.

    Parameters
    ----------
    values : by the names of LOAD_WATCH_DESIGN

    Attributes
    ----------
    records : its arrays by the names of ACTING in `heave_core.law`
    state : structured array of one element
    """

    def __init__(self, values: Mapping[str, Any]) -> None:
        design, self.state = new(table.LOAD_WATCH_DESIGN), new(table.LOAD_WATCH_STATE)
        fill(design[0], values)
        self.records = {"load": design, "load_state": self.state}
        library().heave_core_load_begin(design.ctypes.data, self.state.ctypes.data)


POSITION_STEP = 0.005
"""Step of the position loop [s]; without one each piece of a tick is exact."""

START_STEPS = 3
"""Gauss-Newton steps to payout and rate at the start of a record."""

RATE_STEP = 1e-3
"""Step of the sensitivity to the rate at the start [m/s]."""

EDGE = 1e-9
"""Part of a tick that counts as none."""

NO_POWER_LIMIT = 1e9
"""Power that no winch has [W]."""

WEAK_SLOPE = 1e-6
"""Effect of the rate at the start on the payout that counts as none, as at the limit of the speed [s]."""


class Drum(NamedTuple):
    """A speed servo behind a transport delay, by the rows of SERVO in `watch_table`, with their units and meanings."""

    lag: float
    delay: float
    gain: float = 1.0
    deadband: float = 0.0
    speed_out: float = math.inf
    speed_in: float = math.inf
    acceleration_out: float = 1e9
    acceleration_in: float = 1e9
    backlash: float = 0.0
    reach: float = 1.0
    hauling: float = 1.0
    creep: float = 0.0
    power: float = NO_POWER_LIMIT


def run_of(position_gain: float, dt: float, sent: int = 0, ticks: int = 0) -> NDArray[Any]:
    """Return an array of one ServoRun.

    Parameters
    ----------
    position_gain : of the servo's position loop [1/s]; 0: none
    dt : tick period [s]
    sent, ticks : set-points of the record, and ticks at its end for which readings are made
    """
    run: NDArray[Any] = new(SERVO_RUN)
    of_it = (POSITION_STEP, EDGE, NO_POWER_LIMIT, RATE_STEP, WEAK_SLOPE)
    run[0] = (sent, ticks, 0, START_STEPS, dt, position_gain, *of_it)
    return run


def sent_points(payouts: Array, rates: Array, late: Array, tensions: Array) -> Array:
    """Return what was sent as a table, (4, n), by ticks, oldest first.

    Parameters
    ----------
    payouts, rates : set-points [m], [m/s]
    late : by how much later than the delay each of them took effect [ticks]
    tensions : at the top at the end of each tick [N]; NaN where unknown: there the power limits nothing
    """
    return np.array([payouts, rates, late, tensions], dtype=float)


def drum_records(sent: Array, drums: Array, starts: Array, position_gain: float, count: int, dt: float) -> Array:
    """Return the encoder's reading of each drum at the end of each of the last `count` ticks, shape (m, count) [m].

    Parameters
    ----------
    sent : see `sent_points`, of at least count + delay/dt + 1 ticks
    drums : fields of `Drum`, shape (m, 13)
    starts : payout and rate at the start of the `count` ticks, shape (m, 2) [m], [m/s]
    position_gain : of the servo's position loop [1/s]; 0: none
    count : ticks
    dt : tick period [s]

    Raises ValueError for arrays of another shape, and for fewer set-points than ticks.
    """
    if sent.shape[0] != 4 or sent.shape[1] < count or drums.shape[1] != len(Drum._fields) or starts.shape[1] != 2:
        raise ValueError(f"drum: set-points {sent.shape} for {count} ticks, drums {drums.shape}, starts {starts.shape}")
    out, run = np.empty((len(drums), count)), run_of(position_gain, dt, sent.shape[1], count)
    # held here until the call is over
    arrays = (run, sent, np.ascontiguousarray(drums), np.ascontiguousarray(starts))
    library().heave_core_servo(*(one.ctypes.data for one in arrays), len(drums), out.ctypes.data)
    return out
