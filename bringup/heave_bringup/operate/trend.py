"""Trends for the terminal: the last minutes of a signal as one line of bars."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

BARS = "▁▂▃▄▅▆▇█"
"""Bars of a trend, from the lowest value to the highest."""


def sparkline(values: Sequence[float], low: float, high: float) -> str:
    """Return one bar per value.

    Parameters
    ----------
    values : of a signal; a gap where one is not finite
    low, high : ends of the scale; what lies beyond them is drawn at the end

    >>> sparkline([0.0, 1.0, math.nan, 2.0], 0.0, 2.0)
    '▁▅ █'
    """
    span = high - low
    text = ""
    for value in values:
        if not math.isfinite(value):
            text += " "
            continue
        share = (value - low) / span if span > 0.0 else 0.5
        text += BARS[min(max(int(share * len(BARS)), 0), len(BARS) - 1)]
    return text


class Trend:
    """A signal as it was, in equal steps of simulated time.

    Parameters
    ----------
    step : simulated time of one value [s]; of a quicker signal the newest value of each step is kept
    length : values that are kept
    """

    def __init__(self, step: float, length: int) -> None:
        self._step = step
        self._values: deque[float] = deque(maxlen=length)
        self._slot = -1

    def note(self, time: float, value: float) -> None:
        """Take the `value` at a simulated `time` [s]; a run that restarts begins a new trend."""
        slot = int(time / self._step)
        if slot < self._slot:
            self._values.clear()
        elif slot == self._slot:
            self._values[-1] = value
            return
        elif self._values:
            self._values.extend([math.nan] * min(slot - self._slot - 1, self._values.maxlen or 0))
        self._slot = slot
        self._values.append(value)

    def draw(self, width: int) -> str:
        """Return the last `width` values as bars, from their lowest to their highest."""
        values = list(self._values)[-width:]
        finite = [value for value in values if math.isfinite(value)]
        return sparkline(values, min(finite), max(finite)) if finite else ""

    @property
    def extent(self) -> tuple[float, float]:
        """Lowest and highest value that is kept; NaN where there is none."""
        finite = [value for value in self._values if math.isfinite(value)]
        return (min(finite), max(finite)) if finite else (math.nan, math.nan)
