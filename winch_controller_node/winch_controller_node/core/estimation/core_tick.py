"""The call of the core that makes a tick: what was delivered goes in by rows, and a row comes out."""

from __future__ import annotations

import math

import numpy as np
from heave_core.filter_table import MEASUREMENTS, READING, SAID
from heave_core.library import library, new
from heave_core.sense_table import DELIVERED, LOOK_AT, OBSERVED, TICK
from heave_node.interface.codes import WinchFault

from winch_controller_node.core.estimation.sense_design import SENSOR
from winch_controller_node.interface.readings import Measurements, WinchReading
from winch_controller_node.interface.sensors import SCALAR_SENSORS

Addresses = tuple[int, int]
"""Of what a part of the core goes by, and of its state."""

NO_WINCH = (0.0, math.nan, 0.0, 0.0)
"""What is known of a winch that has not reported."""

DEPTHS = 5
"""Place of the depths in what a tick works with."""

ROOM = 16
"""Readings of a tick for which there is room at first."""


class CoreTick:
    """The rows of a tick, in and out, on memory that the core reads and writes.

    Attributes
    ----------
    said : innovation, its standard deviation, its normalised square, and whether it was accepted, by measurement
    observed : readings of the tick, by the columns of OBSERVED
    depths : depth readings of the tick: stamp [s] and depth [m]
    delivered : address of the rows of DELIVERED of the tick, and how many they are
    """

    def __init__(self) -> None:
        self._given, self._tick = new(LOOK_AT), new(TICK)
        self._given_row, self._tick_row = self._given.view(np.float64), self._tick.view(np.float64)
        self.said = np.zeros((MEASUREMENTS, len(SAID.rows)))
        self._call, self._parts = library().heave_core_sense, (0,) * 5
        self.delivered = (0, 0)
        self._make_room(ROOM)

    def _make_room(self, readings: int) -> None:
        """Have place for so many `readings` that are delivered in a tick."""
        most = 2 * readings + 2
        self._delivered, self.depths = np.zeros((readings, len(DELIVERED.rows))), np.zeros((readings, 2))
        found, self.observed, taken = (np.zeros((most, len(kind.rows))) for kind in (OBSERVED, OBSERVED, READING))
        work = (found, self.observed, taken, np.zeros((most, len(SAID.rows))), self.said, self.depths, self._tick)
        self._work, self._room = work, tuple(array.ctypes.data for array in work)
        self._in = self._given.ctypes.data, self._delivered.ctypes.data

    @property
    def address(self) -> int:
        """Address of the core's Tick."""
        return int(self._tick.ctypes.data)

    def depths_address(self) -> int:
        """Return where the depths read in the tick are."""
        return self._room[DEPTHS]

    def step(
        self,
        number: int,
        measurements: Measurements,
        winch: WinchReading | None,
        command: tuple[float, float],
        *,
        unit_stands: bool,
        sense: Addresses,
        filtered: Addresses,
        look: Addresses,
        motion: int,
    ) -> list[float]:
        """Make a tick; return the numbers of TICK.

        Parameters
        ----------
        number : of the tick
        measurements : delivered at it
        winch : its report, as far as it may be used
        command : active until now: what compensates, and what moves the mean payout
        unit_stands : on the seabed: readings of what rides on the unit say nothing of the hanging cable
        sense, filtered, look : gates, filter, simulated units
        motion : address of the mean payout's
        """
        count = self._deliver(measurements)
        of_winch = NO_WINCH
        if winch is not None:
            is_driven = not winch.brake and winch.fault == WinchFault.NONE
            of_winch = (1.0, winch.time, winch.encoder_payout, is_driven)
        self._given_row[:] = (number, *command, unit_stands, count, *of_winch)
        self._parts = (sense[0], look[0], motion, sense[1], look[1])
        self._call(sense[0], filtered[0], look[0], motion, sense[1], filtered[1], look[1], *self._in, *self._room)
        row: list[float] = self._tick_row.tolist()
        return row

    def beside(self, design: int, state: int) -> tuple[int, ...]:
        """Return what a filter beside takes in of the tick; its `design` and `state` are at these addresses."""
        sense, look, motion, sense_state, look_state = self._parts
        return (sense, design, look, motion, sense_state, state, look_state, *self._room)

    def _deliver(self, measurements: Measurements) -> int:
        """Fill in what was delivered; return how many readings that are."""
        rows = rows_of(measurements)
        if len(rows) > len(self._delivered):
            self._make_room(2 * len(rows))
        if rows:
            self._delivered[: len(rows)] = rows
        self.delivered = self._in[1], len(rows)
        return len(rows)


def rows_of(measurements: Measurements) -> list[tuple[float, ...]]:
    """Return `measurements` by the rows of DELIVERED, those of the MRU first."""
    mru = SENSOR["mru"]
    rows: list[tuple[float, ...]] = [
        (mru, one.time, one.heave, one.heave_rate, one.roll, one.pitch, one.status, *one[-2:])
        for one in measurements.mru
    ]
    for name in SCALAR_SENSORS:
        for time, value in measurements.of(name):
            rows.append((SENSOR[name], time, value, 0.0, 0.0, 0.0, 0.0, math.nan, math.nan))
    return rows
