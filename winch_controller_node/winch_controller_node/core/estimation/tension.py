"""The top tension: low-passed, and its mean over waves, which is what stays of it under a brake.

Over waves the mean is the weight that the cable carries, for the mean acceleration of a unit that goes nowhere is 0:
it distinguishes one that stands from one that hangs, where a reading, or a low-pass of a second, shows the wave.
"""

from __future__ import annotations

import math
from typing import NamedTuple

MEMORY = 30.0
"""Time constant of the mean [s]: of a wave it leaves 1/(w T), as much as a plain mean over twice the time may. It holds
a wave and a half of the longest swell, of 20 s; the motion of the boom tip is averaged over it as well."""

FILTER_SHARE = 0.25
"""Time constant of the low-pass over that of the tension loop."""

MOVED = 0.01
"""Way of the mean payout from which on the tension is that of another place [m]."""


class TensionMean(NamedTuple):
    """A mean tension.

    Attributes
    ----------
    value : [N]; NaN where there is none
    sigma : standard deviation of the tension about it [N]
    time : for which the situation has been the same [s]
    """

    value: float = math.nan
    sigma: float = 0.0
    time: float = 0.0


NO_MEAN = TensionMean()
"""The mean before the first reading."""


class MeanTension:
    """Mean tension of one situation: the unit stands or hangs, and the mean payout stays where it is.

    Parameters
    ----------
    tick_period : [s]
    """

    def __init__(self, *, tick_period: float) -> None:
        self._dt = tick_period
        self._place: tuple[float, bool] | None = None
        self.restart()

    @property
    def mean(self) -> TensionMean:
        """The mean over what there is of this situation."""
        return TensionMean(self._value, math.sqrt(self._variance), self._count * self._dt)

    def restart(self) -> None:
        """Discard the past: the situation is another one."""
        self._count, self._value, self._variance = 0, math.nan, 0.0

    def add(self, tension: float, mean_payout: float, *, unit_stands: bool) -> None:
        """Take in a tick; the first ones weigh as in a plain average.

        Parameters
        ----------
        tension : measured [N]
        mean_payout : about which the winch works [m]
        unit_stands : the unit stands on the seabed
        """
        if self._place is None or unit_stands != self._place[1] or abs(mean_payout - self._place[0]) > MOVED:
            self._place = (mean_payout, unit_stands)
            self.restart()
        self._count += 1
        if self._count == 1:
            self._value = tension
        weight = max(1.0 / self._count, self._dt / MEMORY)
        self._value += weight * (tension - self._value)
        self._variance += weight * ((tension - self._value) ** 2 - self._variance)


class TensionFilter:
    """Low-pass of the load cell.

    Parameters
    ----------
    loop_time_constant : of the tension loop that it serves [s]
    tick_period : [s]

    Attributes
    ----------
    value : filtered tension [N]; NaN before the first reading
    """

    def __init__(self, loop_time_constant: float, *, tick_period: float) -> None:
        self._weight = tick_period / (FILTER_SHARE * loop_time_constant + tick_period)
        self.value = math.nan

    def add(self, tension: float) -> None:
        """Take in one reading of the `tension` [N]."""
        if not math.isfinite(self.value):
            self.value = tension
        self.value += self._weight * (tension - self.value)
