"""The thin Python side of a compiled drive: steps, books and what they have in common."""

from __future__ import annotations

import abc
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from cable_sim_node.winch.drives.interface import DriveCommand, DriveState, check_step
from heave_node.interface.codes import WinchLimit

from heave_drives.kernels.mechanics import FROM_LOAD, LOST, PAYOUT, RATE, STAGES, SUPPLIED, Order


@dataclass(frozen=True)
class DriveEnergy:
    """Energy since the start [J]: what went in is what was lost and what is stored."""

    supplied: float  # by the ship's supply, net [J]
    from_load: float  # by the rope, the integral of tension times payout rate [J]
    lost: float  # as heat, in motor, fluid, friction and brake [J]
    stored: float  # kinetic, in compressed fluid and gas [J]; less what was stored at the start

    @property
    def imbalance(self) -> float:
        """Energy that the books miss [J]; 0 but for the error of the integration."""
        return self.supplied + self.from_load - self.lost - self.stored


class CompiledDrive(abc.ABC):
    """A drive that a compiled function integrates with equal substeps (classical Runge-Kutta, fourth order).

    Parameters
    ----------
    size : length of the state
    substep : over the shortest time constant; it sets the error
    position_gain : from payout error to speed [1/s]
    """

    def __init__(self, size: int, substep: float, position_gain: float) -> None:
        self._x = np.zeros(size)
        self._work = np.zeros((STAGES, size))
        self._substep = substep
        self._position_gain = position_gain
        self._stored_at_start = 0.0
        self.state = DriveState(0.0, 0.0, 0.0, 0.0, 0.0, WinchLimit.NONE, False)

    @property
    def energy(self) -> DriveEnergy:
        """The books since the start."""
        x = self._x
        stored = self._stored() - self._stored_at_start
        return DriveEnergy(float(x[SUPPLIED]), float(x[FROM_LOAD]), float(x[LOST]), stored)

    def step(self, command: DriveCommand, duration: float, tension: float) -> DriveState:
        """See `Drive.step`."""
        check_step(command, duration, tension)
        tension = float(tension)
        substeps = max(1, math.ceil(duration * self._fastest_rate(abs(tension)) / self._substep - 1e-9))
        supplied = float(self._x[SUPPLIED])
        order = Order(float(command.payout_rate), float(command.payout), self._position_gain, command.brake)
        acceleration, limits = self._advance(order, tension, substeps, duration / substeps)
        rate = float(self._x[RATE])
        self.state = DriveState(
            payout=float(self._x[PAYOUT]),
            payout_rate=rate,
            payout_acceleration=acceleration,
            power=-tension * rate,
            supply_power=(float(self._x[SUPPLIED]) - supplied) / duration,
            limits=WinchLimit(limits),
            brake=command.brake and rate == 0.0,
        )
        return self.state

    @abc.abstractmethod
    def instruments(self) -> Mapping[str, float]:
        """Return what the drive's own instruments read."""

    @abc.abstractmethod
    def _advance(self, order: Order, tension: float, substeps: int, h: float) -> tuple[float, int]:
        """Integrate; return the last acceleration [m/s^2] and the limits that acted."""

    @abc.abstractmethod
    def _fastest_rate(self, tension: float) -> float:
        """Return the reciprocal of the shortest time constant under a tension of this size [1/s]."""

    @abc.abstractmethod
    def _stored(self) -> float:
        """Return the energy stored now [J]."""
