"""The winch of a problem without a cable model: a drive with an encoder, or the suite's virtual winch."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from cable_sim_node.winch.command_line import WinchCommand
from cable_sim_node.winch.component import VirtualWinch
from cable_sim_node.winch.drives.interface import Drive, DriveCommand
from cable_sim_node.winch.parameters import WinchParameters

from heave_bringup.benchmark.interface import WINCH_OK, Command, WinchReading


@dataclass(frozen=True)
class RopeMotion:
    """True payout [m], its rate [m/s] and acceleration [m/s^2]; limits that acted."""

    payout: float = 0.0
    rate: float = 0.0
    acceleration: float = 0.0
    limits: int = 0


class Winch(Protocol):
    """A winch that is commanded once per sample time."""

    @property
    def motion(self) -> RopeMotion:
        """Motion of the rope now."""
        ...

    def reading(self) -> WinchReading:
        """Return what the winch reports of itself now."""
        ...

    def step(self, tick: int, command: Command, tension: float) -> None:
        """Take the command of `tick` and go to the next one under a tension [N]."""
        ...


class DrivenWinch:
    """A drive on its own: no delay, no watchdog, no faults.

    Parameters
    ----------
    drive : the drive
    encoder_step : resolution of the encoder [m]; 0 is none
    sample_time : [s]
    """

    def __init__(self, drive: Drive, *, encoder_step: float, sample_time: float) -> None:
        self._drive = drive
        self._step = encoder_step
        self._dt = sample_time
        self._last = 0.0
        self._rate = 0.0
        self._taken = 0

    @property
    def motion(self) -> RopeMotion:
        """Motion of the rope now."""
        state = self._drive.state
        return RopeMotion(state.payout, state.payout_rate, state.payout_acceleration, int(state.limits))

    def reading(self) -> WinchReading:
        """Return the reading now; with a perfect encoder the rate is that of the drum, else a difference."""
        state = self._drive.state
        rate = state.payout_rate if self._step == 0.0 else self._rate
        payout, instruments = self._quantised(state.payout), self._drive.instruments()
        return WinchReading(payout, rate, state.brake, WINCH_OK, int(state.limits), self._taken, instruments)

    def step(self, tick: int, command: Command, tension: float) -> None:
        """See `Winch.step`. A set-point that is not a number stops the drum with the brake."""
        self._taken = tick + 1
        good = math.isfinite(command.payout_rate) and math.isfinite(command.payout)
        order = DriveCommand(command.payout_rate, command.payout, command.brake) if good else DriveCommand(brake=True)
        self._drive.step(order, self._dt, tension)
        now = self._quantised(self._drive.state.payout)
        self._rate, self._last = (now - self._last) / self._dt, now

    def _quantised(self, payout: float) -> float:
        return payout if self._step == 0.0 else self._step * round(payout / self._step)


class VirtualWinchUnderTest:
    """The suite's virtual winch with its delay, watchdog and encoder.

    Parameters
    ----------
    parameters : the winch
    sample_time : [s]
    """

    def __init__(self, parameters: WinchParameters, *, sample_time: float) -> None:
        self._winch = VirtualWinch(parameters, tick_period=sample_time)

    @property
    def motion(self) -> RopeMotion:
        """Motion of the rope now."""
        state = self._winch.state
        return RopeMotion(state.payout, state.payout_rate, state.payout_acceleration, int(state.limits_hit))

    def reading(self) -> WinchReading:
        """Return the reading now."""
        state = self._winch.state
        return WinchReading(
            state.encoder_payout,
            state.encoder_payout_rate,
            state.brake,
            int(state.fault),
            int(state.limits_hit),
            state.command_sequence,
        )

    def step(self, tick: int, command: Command, tension: float) -> None:
        """See `Winch.step`."""
        order = WinchCommand(tick + 1, command.payout, command.payout_rate, command.brake)
        self._winch.step(tick, order, tension)
