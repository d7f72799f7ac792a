"""The loop closed over a record: the controller reads what was read, and by how much the twins differ.

reading now = reading of the record + twin(boom tip, payout asked now) - twin(boom tip, recorded payout)

Errors of boom tip, disturbance and noise are in both twins and cancel to first order; the same orders as in the record
give its readings back to the last bit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from cable_sim_node.vertical.axial_line import AxialLine
from cable_sim_node.vertical.axial_stepper import AxialInput
from cable_sim_node.winch.component import VirtualWinch, WinchState
from cable_sim_node.winch.parameters import WinchParameters
from heave_node.interface.alarm import Alarm
from heave_node.numerics.arrays import Array
from winch_controller_node.interface.readings import Measurements, Outputs, ScalarReading, WinchReading
from winch_controller_node.node_parameters import WinchControllerParameters

from heave_studies.whatif.signals.record import Flags, SensorRecord
from heave_studies.whatif.signals.tip import Tip
from heave_studies.whatif.twin.core import Core
from heave_studies.whatif.twin.plant import Drive, PlantMotion, twin_stepper
from heave_studies.whatif.twin.winch import PastWinch, command_of


@dataclass(frozen=True)
class Past:
    """What a record has become: everything that another loop is closed over."""

    record: SensorRecord  # of the sensors
    line: AxialLine  # cable and unit as identified
    length: float  # of the cable at payout 0 [m]
    tip: Tip  # the boom tip
    winch: PastWinch  # what the drum did
    winch_parameters: WinchParameters  # what it is
    plant: PlantMotion  # motion of the twin under that
    encoder_scale: float = 1.0  # reading over truth [-]
    depth_scale: float = 1.0  # reading over truth [-]

    def drive(self, payout: Array, rate: Array) -> Drive:
        """Return what moves cable and unit under another `payout` and its `rate` at each tick (n,) [m], [m/s]."""
        return Drive(self.line, self.length, self.tip, payout, rate, self.record.tick_period)


@dataclass(frozen=True)
class Replayed:
    """What a loop has done over a record."""

    time: Array  # of each tick (n,) [s]
    payout: Array  # of the cable at each tick (n,) [m]
    rate: Array  # of the cable at each tick (n,) [m/s]
    set_point: Array  # mean payout that the controller worked about (n,) [m]
    unit: Array  # of the twin at each tick (n,) [m]
    tension: Array  # of the twin at each tick (n,) [N]
    modes: tuple[str, ...]  # of the controller in each tick
    alarms: tuple[tuple[float, Alarm], ...]  # time [s] and alarm
    limits_hit: Flags  # of the winch in each tick, sums of WinchLimit (n,)
    refused: tuple[str, ...] = ()  # requests of the operator that the controller did not take, in words


@dataclass(frozen=True)
class Asked:
    """What is to be tried in a record."""

    name: str  # of it, for tables
    controller: WinchControllerParameters  # parameters of the controller
    winch: WinchParameters | None = None  # parameters of the winch; None: as it is
    has_adviser: bool = True  # the loop identifies what is other than nominal, as on a ship


COLUMNS = 6
"""Columns of the table of a replay: payout, rate, set point, heave of the unit, tension, limits hit."""


class Replay:
    """A loop over a record; `step` does one tick.

    Parameters
    ----------
    past : the record and its twins; None of the twins is asked while the orders are those of the record
    asked : what is tried in it
    """

    def __init__(self, past: Past, asked: Asked) -> None:
        record = past.record
        dt, self._past, self._index = record.tick_period, past, 0
        self._core = Core(record, asked.controller, has_adviser=asked.has_adviser)
        self._winch = VirtualWinch(asked.winch or past.winch_parameters, tick_period=dt)
        self._is_other = asked.winch is not None and asked.winch != past.winch_parameters
        payout, rate = float(past.winch.payout[0]), float(past.winch.rate[0])
        start = (past.tip.heave[0], past.tip.rate[0], payout, rate)
        self._plant = twin_stepper(past.line, past.length, start, dt)
        # differences of the twins at each tick: heave, velocity and acceleration of the unit, tension, payout, its rate
        self._differences = np.zeros((record.ticks, 6))
        self._payout, self._rate = payout, rate
        self.refused = self._core.refused

    def step(self) -> tuple[Outputs, Array]:
        """Do one tick; return what the controller gave and the row of it, `COLUMNS` of them."""
        index, past = self._index, self._past
        tick = past.record.first + index
        given = past.record.measurements[index]
        outputs, order = self._core.step(index, self._as_read(given, index) if self._is_other else given)
        was = past.record.orders[index]
        self._is_other |= was is not None and order is not None and order != was
        unit, _, tension, _ = self._plant.state
        limits = self._winch.state.limits_hit if self._is_other else past.record.limits_hit[index]
        row = np.array([self._payout, self._rate, outputs.depth_set_point, unit, tension, int(limits)])
        if index + 1 < past.record.ticks:
            self._advance(self._winch.step(tick, command_of(order), tension), index + 1)
        self._index += 1
        return outputs, row

    def _advance(self, winch: WinchState, index: int) -> None:
        """Take the plant to the next tick, of an `index`, under what the winch has become, and note the differences."""
        past = self._past
        is_other = self._is_other
        extra = winch.payout - past.winch.modelled[index] if is_other else 0.0
        extra_rate = winch.payout_rate - past.winch.modelled_rate[index] if is_other else 0.0
        self._payout, self._rate = past.winch.payout[index] + extra, past.winch.rate[index] + extra_rate
        heave, heave_rate = float(past.tip.heave[index]), float(past.tip.rate[index])
        self._plant.advance(AxialInput(heave, heave_rate, float(self._payout), float(self._rate)))
        unit, velocity, tension, _ = self._plant.state
        row, dt = self._differences[index], past.record.tick_period
        row[0], row[1] = unit - past.plant.unit[index], velocity - past.plant.velocity[index]
        row[2] = (row[1] - self._differences[index - 1, 1]) / dt
        row[3] = tension - past.plant.tension[index]
        row[4], row[5] = extra, extra_rate

    def _as_read(self, given: Measurements, index: int) -> Measurements:
        """Return what would have been read in place of what was `given`."""
        past = self._past
        scalar = {
            sensor: tuple(self._moved(sensor, one, index) for one in readings)
            for sensor, readings in given.scalar.items()
        }
        winch, state = given.winch, self._winch.state
        if winch is not None:
            extra, extra_rate = self._differences[index, 4:] * past.encoder_scale
            winch = WinchReading(
                winch.time,
                winch.encoder_payout + extra,
                winch.encoder_payout_rate + extra_rate,
                state.brake,
                int(state.fault),
                state.command_sequence,
                int(state.limits_hit),
            )
        return replace(given, scalar=scalar, winch=winch)

    def _moved(self, sensor: str, reading: ScalarReading, index: int) -> ScalarReading:
        """Return a `reading` moved by the difference of the twins at its time."""
        column, factor = MOVED[sensor]
        factor = -self._past.depth_scale if sensor == "depth" else factor
        place = reading.time / self._past.record.tick_period - self._past.record.first
        low = min(max(int(place), 0), index)
        high = min(low + 1, index)
        share = min(max(place - low, 0.0), 1.0)
        difference = (1.0 - share) * self._differences[low, column] + share * self._differences[high, column]
        return ScalarReading(reading.time, reading.value + factor * difference)


MOVED = {"depth": (0, -1.0), "velocity": (1, 1.0), "imu": (2, 1.0), "load_cell": (3, 1.0)}
"""Column of the differences by which each sensor reads otherwise, and its sign: depth is positive down."""


def replay(past: Past, asked: Asked) -> Replayed:
    """Return what the loop that is `asked` for would have done over the whole of `past`."""
    loop, ticks = Replay(past, asked), past.record.ticks
    table = np.empty((ticks, COLUMNS))
    modes: list[str] = []
    alarms: list[tuple[float, Alarm]] = []
    for index in range(ticks):
        outputs, table[index] = loop.step()
        modes.append(outputs.mode)
        alarms += [(float(past.record.time[index]), alarm) for alarm in outputs.alarms]
    payout, rate, set_point, unit, tension, limits = table.T.copy()
    return Replayed(
        past.record.time,
        payout,
        rate,
        set_point,
        unit,
        tension,
        tuple(modes),
        tuple(alarms),
        limits.astype(int),
        tuple(loop.refused),
    )


def locked(record: SensorRecord, drive: Drive, motion: PlantMotion) -> Replayed:
    """Return what the winch at its mean payout would have been in a `record`: the `motion` under its `drive`."""
    ticks, set_point = record.ticks, drive.payout
    return Replayed(
        record.time,
        set_point,
        drive.rate,
        set_point,
        motion.unit,
        motion.tension,
        ("off",) * ticks,
        (),
        np.zeros(ticks, dtype=int),
    )
