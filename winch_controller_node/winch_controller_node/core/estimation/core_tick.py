"""The rows of a tick: readings delivered, and what the core has found in them."""

from __future__ import annotations

from struct import Struct
from typing import Any

import numpy as np
from heave_core.filter_table import MEASUREMENTS, READING, SAID
from heave_core.law import SENSING, Control
from heave_core.library import new
from heave_core.sense_table import DELIVERED, OBSERVED, TICK

from winch_controller_node.core.estimation.sense_design import SENSOR
from winch_controller_node.interface.readings import Measurements
from winch_controller_node.interface.sensors import SCALAR_SENSORS

MRU, SCALARS = float(SENSOR["mru"]), {name: float(SENSOR[name]) for name in SCALAR_SENSORS}
"""Numbers of the sensors in the core."""

ROW = 8 * len(DELIVERED.rows)
"""Bytes of a row of DELIVERED."""

PACK, PACK_SCALAR = Struct(f"{len(DELIVERED.rows)}d").pack_into, Struct("3d").pack_into
"""Put a reading with the number of its sensor into a row; one of a single value leaves the others open."""

ROOM = 16
"""Readings of a tick for which there is room at first."""

BESIDE = (
    *("sense", "look", "sense_state", "look_state"),
    *("found", "observed", "taken", "said", "by_measurement", "depths", "tick"),
)
"""What a filter beside the active one takes in of a tick."""


class CoreTick:
    """The rows of a tick on memory that the core reads and writes.

    `control` : of the tick

    Attributes
    ----------
    said : innovation, its standard deviation, its normalised square, and whether it was accepted, by measurement
    observed : readings of the tick, by the columns of OBSERVED
    depths : depth readings of the tick: stamp [s] and depth [m]
    memory : array of one TICK; tick : its numbers; record : the same by name
    """

    def __init__(self, control: Control) -> None:
        self.control, self.memory = control, new(TICK)
        self.tick, self.record = self.memory.view(np.float64), self.memory[0]
        self.said = np.zeros((MEASUREMENTS, len(SAID.rows)))
        self._make_room(ROOM)

    def _make_room(self, readings: int) -> None:
        """Have place for so many `readings` that are delivered in a tick."""
        most = 2 * readings + 2
        self._delivered, self.depths = np.zeros((readings, len(DELIVERED.rows))), np.zeros((readings, 2))
        found, self.observed, taken = (np.zeros((most, len(kind.rows))) for kind in (OBSERVED, OBSERVED, READING))
        rows = {"delivered": self._delivered, "found": found, "observed": self.observed, "taken": taken}
        said = {"said": np.zeros((most, len(SAID.rows))), "by_measurement": self.said}
        self.control.take(SENSING, **rows, **said, depths=self.depths, tick=self.memory)
        self._beside: tuple[int, ...] = ()

    def beside(self, design: int, state: int, motion: int) -> tuple[int, ...]:
        """Return the addresses of what a filter beside takes in of the tick.

        `design`, `state`, `motion` : addresses of its design and state, and of the mean payout's motion
        """
        if not self._beside:
            self._beside = tuple([self.control.address(SENSING, name) for name in BESIDE])
        sense, look, sense_state, look_state, *rows = self._beside
        return (sense, design, look, motion, sense_state, state, look_state, *rows)

    def deliver(self, measurements: Measurements) -> int:
        """Fill in the `measurements` of a tick; return how many readings they are."""
        count = len(measurements.mru) + sum(map(len, measurements.scalar.values()))
        if count > len(self._delivered):
            self._make_room(2 * count)
        return put_readings(self._delivered, measurements)


def put_readings(rows: Any, measurements: Measurements) -> int:
    """Put `measurements` into `rows` of DELIVERED, those of the MRU first; return how many readings they are."""
    at = 0
    for one in measurements.mru:
        PACK(rows, at, MRU, *one)
        at += ROW
    for name, readings in measurements.scalar.items():
        number = SCALARS[name]
        for reading in readings:
            PACK_SCALAR(rows, at, number, *reading)
            at += ROW
    return at // ROW
