"""What a procedure may order: no more than the nominal winch of its scenario can do, by the limits that it states."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from heave_node.loads.strength import Strength
from heave_node.numerics.arrays import Array
from heave_node.parameters import ParameterError

from heave_devices.bench.set_signal import SetSignal

_STEP = 0.1
"""Time between the moments at which a set signal is looked at [s]."""
_AT_ONCE = 1000
"""Moments that are looked at together."""
_ROUNDING = 1e-6
"""Share by which 100 % may be exceeded."""


@dataclass(frozen=True)
class Limits:
    """What a nominal winch can do; percentages of a procedure are of its speed and its acceleration."""

    speed: float = math.nan  # [m/s]
    acceleration: float = math.nan  # [m/s^2]
    # lower and upper end of its range, from where a test begins [m]
    payout: tuple[float, float] = (-math.inf, math.inf)
    strengths: Sequence[Strength] = ()  # of the parts that carry the load, as far as they are stated

    def refuse(self, signal: SetSignal, load: float, acceleration: float, where: str) -> None:
        """Raise ParameterError, naming `where` it stands, for what the winch cannot do.

        It is ordered to follow a `signal`, under a `load` [N], at an `acceleration` [m/s^2]; NaN: none is ordered.
        """
        more = 1.0 + _ROUNDING
        if acceleration > more * self.acceleration:
            raise ParameterError(f"{where}: {acceleration:g} m/s^2 is beyond the winch's {self.acceleration:g} m/s^2")
        lowest, highest = self.payout
        for speed, least, most in _extremes(signal):
            if speed > more * self.speed:
                raise ParameterError(
                    f"{where}: {signal.words}: needs {speed:.3g} m/s, beyond the winch's {self.speed:g} m/s"
                )
            if least < more * lowest or most > more * highest:
                raise ParameterError(
                    f"{where}: {signal.words}: needs a payout of {least:.3g} to {most:.3g} m, beyond the winch's "
                    f"{lowest:g} to {highest:g} m"
                )
        if load < 0.0:
            raise ParameterError(f"{where}: load = {load:g} N must not be below 0")
        broken = next((part for part in self.strengths if part.under(load).is_overloaded), None)
        if broken is not None:
            raise ParameterError(
                f"{where}: load = {1e-3 * load:g} kN is beyond the {broken.kind}, {1e-3 * broken.capacity:g} kN"
            )


def _extremes(signal: SetSignal) -> Iterator[tuple[float, float, float]]:
    """Yield largest speed [m/s], least and most payout [m] of each part of a set signal, one after the other."""
    first, moved = 0.0, 0.0
    while first < signal.duration:
        time: Array = first + _STEP * np.arange(_AT_ONCE, dtype=np.float64)
        rate = signal.rate(time[time < signal.duration])
        payout = moved + _STEP * np.cumsum(rate)
        yield float(np.abs(rate).max()), float(payout.min()), float(payout.max())
        first, moved = first + _STEP * _AT_ONCE, float(payout[-1])
