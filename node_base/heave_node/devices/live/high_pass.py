"""Heave from a height or from a vertical velocity: what is slower than any sea is taken out as it comes.

z' = y' - 2 zeta w z - w^2 (integral of z), that is Z/Y = s^2 / (s^2 + 2 zeta w s + w^2), w = 2 pi / period, zeta = 0.7:
a constant height, and a constant error of the velocity, leave nothing. At a tenth of the period the phase leads by
2 zeta / 10 = 8 degrees, at a thirtieth by 3: the longer the period the better the heave, and the slower it settles.
"""

from __future__ import annotations

import math

DEFAULT_PERIOD = 300.0
"""Period of the filter, where a map says none [s]: a swell of 12 s leads by 3 degrees."""
_DAMPING = 0.7
_LONGEST_STEP = 5.0
"""Longest gap between samples; after a longer one the filter restarts [s]."""


class HighPass:
    """A running high-pass of the second order.

    Parameters
    ----------
    period : slower motion is taken out [s]

    Attributes
    ----------
    is_settled : it has run for a third of the period
    """

    def __init__(self, period: float) -> None:
        self._frequency = 2.0 * math.pi / period
        self._settling = period / 3.0
        self._begin()

    def _begin(self) -> None:
        self._first = self._last = math.nan
        self._before = self._value = self._integral = 0.0
        self.is_settled = False

    def add(self, time: float, height: float) -> float:
        """Return heave [m] at a `time` [s] from a `height` [m] about any datum."""
        step = self._step(time)
        change = height - self._before if step > 0.0 else 0.0
        self._before = height
        return self._advance(step, change)

    def add_rate(self, time: float, rate: float) -> float:
        """Return heave [m] at a `time` [s] from its `rate` [m/s]."""
        step = self._step(time)
        change = 0.5 * step * (rate + self._before)
        self._before = rate
        return self._advance(step, change)

    def _step(self, time: float) -> float:
        if math.isnan(self._last) or not -1.0 < time - self._last < _LONGEST_STEP:
            self._begin()
            self._first = self._last = time
        step = max(time - self._last, 0.0)
        self._last += step
        self.is_settled = time - self._first > self._settling
        return step

    def _advance(self, step: float, change: float) -> float:
        """Take a step [s] in which the motion changed by `change` [m]."""
        w = self._frequency
        before = self._value
        self._value += change - step * (2.0 * _DAMPING * w * before + w * w * self._integral)
        self._integral += 0.5 * step * (before + self._value)
        return self._value
