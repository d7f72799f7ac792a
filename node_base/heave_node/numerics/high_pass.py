"""A running high-pass of the second order: what is slower than any sea is taken out as it comes.

z' = y' - 2 zeta w z - w^2 (integral of z), that is Z/Y = s^2 / (s^2 + 2 zeta w s + w^2), w = 2 pi / period, solved by
trapezoids (the bilinear transform): a constant height, and a constant error of a rate, leave nothing. At a tenth of the
period the phase leads by about 2 zeta / 10, at a thirtieth by a third of that: the longer the period the better the
motion, and the slower it settles.
"""

from __future__ import annotations

import math

LONGEST_STEP = 5.0
"""Longest gap between samples; after a longer one the filter restarts [s]."""
LARGEST_RETURN = 1.0
"""A sample that is older than the newest by less is late, and no restart of a clock [s]."""


class HighPass:
    """The filter, sample by sample.

    Parameters
    ----------
    period : slower motion is taken out [s]
    damping : zeta
    starts_whole : the first value, and that after a gap, passes whole, as of a motion about zero; False: it is the
        datum of those that follow, and 0 passes

    Attributes
    ----------
    is_settled : it has run for a third of the period
    """

    def __init__(self, period: float, damping: float = 0.7, *, starts_whole: bool = False) -> None:
        frequency = 2.0 * math.pi / period
        self._stiffness, self._damping = frequency**2, 2.0 * damping * frequency
        self._settling = period / 3.0
        self._starts_whole = starts_whole
        self._begin(0.0)

    def _begin(self, first: float) -> None:
        """Start with `first` passed [m], and with nothing taken off its rate."""
        self._first = self._last = math.nan
        self._value, self._integral = first, -self._damping / self._stiffness * first
        self._before = 0.0
        self.is_settled = False

    def add(self, time: float, value: float) -> float:
        """Return what passes of a `value` [m] at a `time` [s]; a late sample changes nothing."""
        step = self._step(time, value, value)
        return self._advance(step, value - self._before, value) if step > 0.0 else self._value

    def add_rate(self, time: float, rate: float) -> float:
        """Return what passes [m] of a motion whose `rate` [m/s] is known alone, at a `time` [s]."""
        step = self._step(time, rate, 0.0)
        return self._advance(step, 0.5 * step * (rate + self._before), rate) if step > 0.0 else self._value

    @property
    def rate_taken_off(self) -> float:
        """What the filter takes off the rate of the motion [m/s]."""
        return self._damping * self._value + self._stiffness * self._integral

    def _step(self, time: float, read: float, value: float) -> float:
        """Return the step since the newest sample [s]; after a gap the filter starts, and there is none.

        Parameters
        ----------
        time : of a sample [s]
        read : what it reads: the motion, or its rate
        value : of the motion, from which the filter starts after a gap [m]
        """
        if math.isnan(self._last) or not -LARGEST_RETURN < time - self._last < LONGEST_STEP:
            self._begin(value if self._starts_whole else 0.0)
            self._first = self._last = time
            self._before = read
        step = max(time - self._last, 0.0)
        self._last += step
        self.is_settled = time - self._first > self._settling
        return step

    def _advance(self, step: float, change: float, read: float) -> float:
        """Return what passes at the end of a `step` [s] in which the motion changed by `change` [m], up to `read`.

        The trapezoids are solved for the mean z of the step.
        """
        across = 2.0 + self._damping * step + 0.5 * self._stiffness * step * step
        mean = (change + 2.0 * self._value - step * self._stiffness * self._integral) / across
        self._value = 2.0 * mean - self._value
        self._integral += step * mean
        self._before = read
        return self._value
