"""The way of commands from their sender to the drive: late, with jitter, and lost where it is cut."""

from __future__ import annotations

import math
from typing import NamedTuple

from heave_node.interface.faults import FaultSchedule
from heave_node.numerics.randomness import random_stream

from cable_sim_node.winch.parameters import WinchParameters

_TICK_ROUNDING = 1e-6
"""An event this near to a tick [ticks] is at the tick: delay/tick_period is a rounded quotient."""


class WinchCommand(NamedTuple):
    """What the winch shall do from the start of its tick on, until the next command."""

    sequence: int  # counts commands from 1
    payout: float = 0.0  # set-point [m]
    payout_rate: float = 0.0  # set-point [m/s]
    brake: bool = False  # stop within the limits, then hold with the brake
    mean_payout: float = math.nan  # that the sender works about; the drive does not go by it; NaN: none stated [m]

    def is_finite(self) -> bool:
        """Return whether both set-points are finite numbers."""
        return math.isfinite(self.payout) and math.isfinite(self.payout_rate)


class CommandLine:
    """The commands that are on their way.

    Parameters
    ----------
    parameters : with delay and jitter
    faults : of the winch: `gap` loses commands, `delay` and `jitter` hold them back
    tick_period : [s]
    seed : of the jitter
    """

    def __init__(self, parameters: WinchParameters, faults: FaultSchedule, *, tick_period: float, seed: int) -> None:
        self._delay, self._jitter = parameters.command_delay, parameters.command_jitter
        self._faults = faults
        self._tick_period = tick_period
        self._random = random_stream(seed, "virtual_winch/jitter")
        self._newest_sent: WinchCommand | None = None
        self._under_way: list[tuple[float, WinchCommand]] = []

    def send(self, tick: int, command: WinchCommand | None) -> None:
        """Put the command of a `tick` on its way; the same one again, or none, changes nothing."""
        time = tick * self._tick_period
        if command is None or command == self._newest_sent or self._faults.is_active("gap", time):
            return
        self._newest_sent = command
        effect = tick + (self._delay + self._faults.lateness(time)) / self._tick_period
        if self._jitter > 0.0:
            before = self._under_way[-1][0] if self._under_way else 0.0
            jitter = self._jitter * self._random.uniform(-1.0, 1.0)
            effect = max(effect + jitter / self._tick_period, float(tick), before)
        self._under_way.append((round_to_tick(effect), command))
        self._under_way.sort(key=lambda entry: entry[0])

    @property
    def next_effect(self) -> float:
        """When the next command takes effect [ticks]; infinity: none is on its way."""
        return self._under_way[0][0] if self._under_way else math.inf

    def take(self, now: float) -> WinchCommand | None:
        """Return the next command that takes effect by `now` [ticks], and take it off the line; None: there is none."""
        return self._under_way.pop(0)[1] if self.next_effect <= now else None


def round_to_tick(time: float) -> float:
    """Return `time` [ticks], or the tick it is at but for rounding."""
    nearest = float(round(time))
    return nearest if abs(time - nearest) < _TICK_ROUNDING else time
