"""The noise of a sensor by itself, from its readings alone: no model is needed, and other sensors have no part in it.

A third difference of readings takes away what is smooth and leaves white noise, sqrt(20) times as large; the median of
its magnitude does not see spikes.
"""

from __future__ import annotations

import math
from collections import deque
from statistics import median

READINGS = 100
"""Readings that the noise is judged by, once there are so many."""

FEWEST = 30
"""Readings from which on it is judged."""

UNKNOWN = 5.0
"""Noise until then, over the assumed one: a sensor noisier than assumed must not be taken for one with an error."""

WORSE = 2.0
"""Ratio to the assumed noise, or to that last reported, from which on noise is reported, once seen for READINGS."""

UPDATED = 10
"""Readings from one judgement to the next."""

MEDIAN_OF_MAGNITUDE = 0.6745 * math.sqrt(20.0)
"""Median of the magnitude of the third difference of white noise, over its standard deviation."""

LONGEST_PERIOD = 0.25
"""Between readings further apart [s] the sea itself is not smooth."""


class SensorNoise:
    """Standard deviation of a sensor's noise: as assumed, or as stated or seen where that is more.

    Before it is seen `add` returns several times the assumed one.

    Parameters
    ----------
    nominal : assumed standard deviation, in the sensor's unit
    period : between readings [s]

    Attributes
    ----------
    sigma : now
    """

    def __init__(self, nominal: float, period: float) -> None:
        self.nominal = nominal
        self._is_judged = period <= LONGEST_PERIOD
        self._last: deque[float] = deque(maxlen=4)
        self._differences: deque[float] = deque(maxlen=READINGS)
        self._count = 0
        self._seen = math.nan
        self._reported = nominal
        self._worse = 0
        self.sigma = nominal

    def add(self, value: float, stated: float = math.nan) -> float:
        """Take in a reading; return the standard deviation to use.

        Parameters
        ----------
        value : of the reading
        stated : standard deviation that it states of itself; NaN: none
        """
        self._last.append(value)
        if self._is_judged and len(self._last) == 4:
            a, b, c, d = self._last
            self._differences.append(abs(d - 3.0 * c + 3.0 * b - a))
            self._count += 1
            if len(self._differences) >= FEWEST and self._count % UPDATED == 0:
                self._seen = median(self._differences) / MEDIAN_OF_MAGNITUDE
                self._worse = self._worse + UPDATED if self._seen >= WORSE * self._reported else 0
        is_stated = math.isfinite(stated)
        # one that is not a number is no maximum
        self.sigma = max(self.nominal, self._seen, stated if is_stated else 0.0)
        is_known = is_stated or math.isfinite(self._seen)
        return self.sigma if is_known or not self._is_judged else UNKNOWN * self.nominal

    @property
    def seen(self) -> float | None:
        """Standard deviation that the readings show, also where it is below the assumed one; None: not known."""
        return self._seen if math.isfinite(self._seen) else None

    def news(self) -> float:
        """Return the ratio of the noise to the assumed one when it has become much larger; else 0."""
        is_sure = math.isnan(self._seen) or self._worse >= READINGS
        if not is_sure or self.sigma < WORSE * self._reported:
            return 0.0
        self._reported, self._worse = self.sigma, 0
        return self.sigma / self.nominal
