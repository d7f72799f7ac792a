"""Noise and rate of a sensor by itself, from its readings alone: no model is needed, and other sensors have no part.

A third difference of readings takes away what is smooth and leaves white noise, sqrt(20) times as large; the median of
its magnitude does not see spikes.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
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

INTERVALS = 5
"""Intervals by whose median a sensor's own rate is known."""

LATE = 1.5
"""Nominal intervals from which on a reading is late: half way to the next but one."""


@dataclass(frozen=True)
class SensorTiming:
    """What is nominal of a sensor's timing: period [s] and usual latency [s]."""

    period: float
    latency: float = 0.0


class OwnInterval:
    """Interval at which a sensor delivers: its nominal one, or its own where that is longer.

    One longer than LONGEST_PERIOD counts as that, unless it is nominal: a sensor must be known to be so slow.

    Parameters
    ----------
    nominal : interval [s]

    Attributes
    ----------
    value : now [s]; before the first two readings the longest that may be
    seen : median of the last ones, whatever may be [s]
    """

    def __init__(self, nominal: float) -> None:
        self._nominal, self._late = nominal, LATE * nominal
        self._longest = max(nominal, LONGEST_PERIOD)
        self._last: deque[float] = deque(maxlen=INTERVALS)
        self._reported = self._late
        self.seen, self.value = nominal, self._longest

    def add(self, interval: float) -> None:
        """Take in the time from one reading to the next, an `interval` [s]."""
        self._last.append(interval)
        if interval <= self._late and self.value == self._nominal:
            return
        self.seen = median(self._last) if len(self._last) == INTERVALS else min(self._last)
        self.value = min(self.seen, self._longest) if self.seen > self._late else self._nominal

    def news(self) -> bool:
        """Return whether the sensor has become slower than nominal, or than reported; asked again and again."""
        if self.seen <= self._reported or len(self._last) < INTERVALS:
            return False
        self._reported = LATE * self.seen
        return True


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
