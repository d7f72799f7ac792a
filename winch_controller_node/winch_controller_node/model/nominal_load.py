"""The nominal unit under a locked drum, moved by the raw MRU: what load cell and depth sensor are compared with.

    a z'' + b z' + z = x0,    T = T0 + k (x0 - z)

No estimate, identified value or gain is in it. Heave is blended with the integral of its rate: on a short cable the
noise of the heave alone would shake the unit.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from heave_node.interface.codes import MruStatus
from heave_node.interface.sensors import MruReading

from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.simulated_unit import SimulatedUnit

BLEND = 1.0
"""Time constant with which heave corrects the integral of its rate [s]."""

UNREAD = 0.5
"""Age of an MRU reading from which on the motion is not known [s]."""

FOLLOWED = 0.05
"""Change of the length from which on another cable is taken, relative."""

LARGEST_HEAVE, LARGEST_RATE = 15.0, 6.0
"""Beyond which a reading of the MRU is not taken [m], [m/s]."""

PLAUSIBLE_LOAD = 10.0
"""Largest reading of the load cell that is used, over the static tension."""


def _is_plausible(reading: MruReading) -> bool:
    is_rate = math.isnan(reading.heave_rate) or abs(reading.heave_rate) <= LARGEST_RATE
    return math.isfinite(reading.time) and abs(reading.heave) <= LARGEST_HEAVE and is_rate


class NominalLoad:
    """The nominal unit under a locked drum, moved by the raw MRU.

    Parameters
    ----------
    cable : nominal, at `length`
    length : of cable [m]
    tick_period : [s]

    Attributes
    ----------
    time : of the newest reading of the MRU [s]
    heave, unit : of boom tip and unit [m]
    """

    def __init__(self, cable: CableModel, length: float, tick_period: float) -> None:
        self._nominal, self._length, self._dt = cable, length, tick_period
        self.cable = cable
        self._unit = SimulatedUnit(cable, tick_period)
        self._at = length
        self.time, self.heave, self.unit = -math.inf, math.nan, 0.0
        self._base = (-math.inf, math.nan)
        self._rate = self._read_time = 0.0

    @property
    def is_known(self) -> bool:
        """Tell whether the MRU reads, and has done so long enough for the blend."""
        return self._read_time > BLEND

    @property
    def stretch(self) -> float:
        """By how much the cable is longer than at rest [m]; no less than slack."""
        return max(self.heave - self.unit, -self.cable.static_tension / self.cable.stiffness)

    @property
    def frequency(self) -> float:
        """Of the unit's free swing [rad/s]."""
        return 1.0 / math.sqrt(self.cable.natural_a)

    def pay_out(self, payout: float) -> None:
        """Hang the unit on the cable that a `payout` leaves [m]: its compliance goes with its length."""
        length = max(self._length + payout, 1.0)
        if abs(length / self._at - 1.0) < FOLLOWED:
            return
        self._at, ratio, nominal = length, length / self._length, self._nominal
        self.cable = replace(
            nominal,
            a=nominal.a * ratio,
            b=nominal.b * ratio,
            drag=nominal.drag * ratio,
            stiffness=nominal.stiffness / ratio,
        )
        self._unit.take_cable(self.cable, self._dt)

    def step(self, readings: tuple[MruReading, ...]) -> None:
        """Advance by a tick with `readings` of the MRU, at the boom tip, in it."""
        read = [one for one in readings if one.status == MruStatus.OK and _is_plausible(one)]
        if read:
            self._take(read[-1])
        else:
            self.time += self._dt
            self.heave = self._base[1] + self._rate * (self.time - self._base[0])
        if not self.time - self._base[0] < UNREAD:
            self._read_time = self._rate = 0.0
            self._base = (self.time, self.heave)
        self._read_time += self._dt if read or self._read_time else 0.0
        if math.isfinite(self.heave):
            self.unit = float(self._unit.state[0])
            self._unit.step(np.array([self.heave, self._rate]))

    def _take(self, reading: MruReading) -> None:
        """Blend heave and rate of a `reading` with what its rate has made of the ones before."""
        time, before = self._base
        heave, since = reading.heave, reading.time - time
        has_rate = math.isfinite(reading.heave_rate)
        rate = reading.heave_rate if has_rate else 0.0
        if not 0.0 <= since < UNREAD:
            self._read_time = 0.0
            if math.isnan(before):
                self._unit.continue_at(np.array([heave, 0.0]))
        elif has_rate:
            integral = before + 0.5 * since * (rate + self._rate)
            heave = integral + min(since / BLEND, 1.0) * (heave - integral)
        elif since > 0.0:
            rate = (heave - before) / since
        self.time, self.heave, self._rate = reading.time, heave, rate
        self._base = (self.time, self.heave)
