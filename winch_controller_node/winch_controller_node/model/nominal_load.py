"""The nominal unit under a locked drum, moved by the raw MRU: what load cell and depth sensor are compared with.

    a z'' + b z' + z = x0,    T = T0 + k (x0 - z)

No estimate, identified value or gain is in it. The motion is made in C++ (`heave_core`, nominal_load.cpp).
"""

from __future__ import annotations

import math
from dataclasses import replace

from heave_core.watch import NominalUnit
from heave_node.interface.codes import MruStatus
from heave_node.interface.sensors import MruReading

from winch_controller_node.model.blocks import CableModel
from winch_controller_node.model.simulated_unit import hanging_cable

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
    """

    def __init__(self, cable: CableModel, length: float, tick_period: float) -> None:
        self._nominal, self._length, self._dt = cable, length, tick_period
        self.cable = cable
        times = {"tick_period": tick_period, "blend": BLEND, "unread": UNREAD}
        self._core = NominalUnit({**times, "cable": hanging_cable(cable, tick_period)})
        self._at_tip, self._at = self._core.at_tip, length

    @property
    def time(self) -> float:
        """Time of the newest reading of the MRU [s]."""
        return float(self._at_tip[0])

    @property
    def heave(self) -> float:
        """Heave of the boom tip [m]; NaN: none was read."""
        return float(self._at_tip[1])

    @property
    def unit(self) -> float:
        """Heave of the unit [m]."""
        return float(self._at_tip[2])

    @property
    def is_known(self) -> bool:
        """Tell whether the MRU reads, and has done so long enough for the blend."""
        return bool(self._at_tip[3] > BLEND)

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
        self._core.take_cable(hanging_cable(self.cable, self._dt))

    def step(self, readings: tuple[MruReading, ...]) -> None:
        """Advance by a tick with `readings` of the MRU, at the boom tip, in it."""
        read = [one for one in readings if one.status == MruStatus.OK and _is_plausible(one)]
        if read:
            self._core.read(read[-1].time, read[-1].heave, read[-1].heave_rate)
        else:
            self._core.advance()
