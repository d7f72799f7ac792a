"""The time of samples: of a device that states none, but takes them at a known rate, and of one with a counter."""

from __future__ import annotations

import math
import statistics
from collections import deque
from itertools import pairwise

LONG_SILENCE = 1.0
"""A sample that is later than this by the count begins it again: the line was silent [s]."""
JUDGED = 10
"""Periods over which all samples must be late before some are taken to be lost."""
LEAST_STEP = 0.01
"""Least time between two samples, in periods."""
STEPPED = 1.0
"""A counter that goes back, or ahead of the arrivals, by more restarted [s]: a delay makes it neither."""
LOOK, LOOKS = 1.0, 10
"""A clock is compared with the arrivals over so long [s], so many times: a restart or a halt among them is no rate."""
LEAD_LEAK = 1e-3
"""The least delay of a device's samples grows by this share of the time until one is less: clocks drift less."""
LEAST_RATE, LARGEST_RATE = 0.5, 2.0
"""A clock that runs slower or faster than the arrivals by more has another unit, or is no clock."""


class DeviceClock:
    """Follows the own time of a device, which may restart, or be wrong in one sample.

    Attributes
    ----------
    restarts : so far: a step that the next sample confirms
    glitches : steps that the next sample does not confirm
    late : samples older than one before
    standing : samples with the time of the one before: a clock that is coarser than they are apart
    has_stepped : the newest sample's time has stepped, and the next one has to confirm it
    """

    def __init__(self) -> None:
        self.restarts = self.glitches = self.late = self.standing = 0
        self.has_stepped = False
        self._newest, self._lead = -math.inf, math.inf
        self._looks: deque[tuple[float, float]] = deque(maxlen=LOOKS + 1)
        self._before: tuple[float, float] | None = None
        self._candidate: tuple[float, float] | None = None
        self._shift = 0.0

    def time(self, own: float, now: float) -> float | None:
        """Return the time of a sample that goes on over restarts [s]; None: it is older than one before.

        It is of the device's `own` time and has arrived `now`, by a monotonic clock [s]. While the own time stands, the
        arrivals count on.
        """
        if not self._looks or now - self._looks[-1][1] >= LOOK:
            self._looks.append((own, now))
        time = self._time(own, now)
        if time is not None:
            self._newest = time = max(time, self._newest + 1e-6)
        return time

    @property
    def rate(self) -> float:
        """How fast the own time runs beside the arrivals [-]: the median of the last looks; NaN: too few."""
        if len(self._looks) <= LOOKS:
            return math.nan
        return statistics.median((b[0] - a[0]) / (b[1] - a[1]) for a, b in pairwise(self._looks))

    def _time(self, own: float, now: float) -> float | None:
        self.has_stepped = False
        if self._before is None:
            self._before, self._lead = (own, now), now - own
            return own
        if _is_step(own - self._before[0], now - self._before[1]):
            return self._stepped(own, now)
        self.glitches += self._candidate is not None
        self._candidate = None
        if own < self._before[0]:
            self.late += 1
            return None
        if own == self._before[0]:
            self.standing += 1
            return own + self._shift + now - self._before[1]
        self._lead = min(self._lead + LEAD_LEAK * (now - self._before[1]), now - own - self._shift)
        self._before = (own, now)
        return own + self._shift

    def _stepped(self, own: float, now: float) -> float:
        """Return the time of a sample that has stepped [s]: by its arrival, until the next one confirms it.

        The clock that has restarted goes on by the least delay: no later sample is stamped before it was taken.
        """
        assert self._before is not None
        last = self._candidate
        if last is not None and not _is_step(own - last[0], now - last[1]):
            self.restarts += 1
            self._candidate, self._before = None, (own, now)
            self._shift = last[1] - self._lead - last[0]
            return own + self._shift
        self.glitches += last is not None
        self.has_stepped = True
        self._candidate = (own, now)
        return self._before[0] + self._shift + now - self._before[1]


def _is_step(went: float, passed: float) -> bool:
    return went < -STEPPED or went - passed > STEPPED


class CountedTime:
    """Says when each sample was taken: one period after the one before, and never after its own arrival.

    A sample that a busy machine hands over late, or several at once, so get the times at which they were taken. Samples
    that were lost, or a device a little slower than stated, leave all that follow late: then the count moves on by the
    smallest delay of the last JUDGED periods. `rate`: samples per second [Hz].
    """

    def __init__(self, rate: float) -> None:
        self._period = 1.0 / rate
        self._newest: float | None = None
        self._delays: deque[tuple[float, float]] = deque()

    def time(self, now: float) -> float:
        """Return when the sample that arrives `now` [s] was taken, by the same clock [s]."""
        before = self._newest
        if before is None or now - before > LONG_SILENCE + self._period:
            self._delays.clear()
            self._newest = now
            return now
        self._newest = before + self._period
        self._move_on(now)
        self._newest = max(self._newest, before + LEAST_STEP * self._period)
        return self._newest

    def _move_on(self, now: float) -> None:
        """Shift the count: back where a sample is earlier than by it, on where all have been late for long enough."""
        assert self._newest is not None
        self._delays.append((now, now - self._newest))
        while now - self._delays[0][0] > JUDGED * self._period:
            self._delays.popleft()
        late = min(delay for _, delay in self._delays)
        if late < 0.0 or now - self._delays[0][0] > (JUDGED - 2) * self._period:
            self._newest += late
            self._delays = deque((arrival, delay - late) for arrival, delay in self._delays)
