"""The time of messages of hardware in simulated time: one rule for every external publisher, declared or detected, and
checked.

A message of an external node says when it was measured in one of three ways. `simulated`: its stamp is simulated
time (`use_sim_time`). `own`: its stamp is of a clock of its own, whose offset and drift are estimated here. `none`: its
stamp is 0, and the time of its arrival counts.

Estimate of an own clock: stamp and arrival differ by the offset of the clocks and by the delay of the message, which is
never negative. So in each second the message with the smallest difference is the one with the least delay, and of the
straight lines below these smallest differences of the last minute the one that is nearest to them is offset and drift
(S. Moon, P. Skelly, D. Towsley, "Estimation and removal of clock skew from network delay measurements", INFOCOM 1999):
the edge of their lower convex hull in the middle of the minute. Messages that are late for less than half a minute do
not touch it. The least delay itself cannot be separated from the offset: it counts as zero.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from heave_node.tick.clock_rule import ClockRule

_SECOND = 1_000_000_000
_WINDOW = 60
"""Smallest differences that the line goes through: one per second."""
_DRIFT_AFTER = 10
"""Seconds after which a drift is estimated; before, the clock is taken to run true."""
_NEAR = _SECOND
"""A stamp that differs less from simulated time at its arrival is simulated time [ns]."""
_JITTER_SAMPLES = 1000
_STEP_BACK, _STEP_AHEAD = 0.05, 1.0
"""Delays below minus the one, or of _STEPPED messages in a row above the other [s], are of a clock that was set, or of
a run that was paused: the estimate starts again."""
_STEPPED = 10


class ExternalClock:
    """Turns stamps of one external publisher into simulated time.

    Parameters
    ----------
    declared : rule for it
    latency : by which what was measured is older than the stamp, or the arrival, says [s]

    Attributes
    ----------
    rule : active; DETECT until the first message
    violation : why what comes does not fit the rule, in words; "" while it fits
    violations : messages that did not fit
    """

    def __init__(self, declared: ClockRule = ClockRule.DETECT, latency: float = 0.0) -> None:
        self.rule = declared
        self.latency = latency
        self.violation = ""
        self.violations = 0
        self._second = -1
        self._envelope: deque[tuple[float, float]] = deque(maxlen=_WINDOW)
        self._reference: int | None = None
        self._offset, self._drift = 0.0, 0.0
        self._lead = 0
        self._delays: deque[float] = deque(maxlen=_JITTER_SAMPLES)
        self._far_in_a_row = 0
        self._newest = (0, 0)  # stamp, and its simulated time [ns]

    def simulated_time(self, stamp: int, arrival: int, wall: int | None = None) -> int:
        """Return when a message was measured, in simulated time [ns].

        Parameters
        ----------
        stamp : of the message [ns]
        arrival : simulated time at which it came [ns]
        wall : monotonic wall time at which it came [ns]; None: runs as simulated time does
        """
        return self._stamped(stamp, arrival, wall) - round(self.latency * _SECOND)

    def _stamped(self, stamp: int, arrival: int, wall: int | None) -> int:
        if self.rule is ClockRule.DETECT:
            self.rule = detect(stamp, arrival)
        self._check(stamp, arrival)
        if self.rule is ClockRule.NONE or stamp == 0:
            return arrival
        if self.rule is ClockRule.SIMULATED:
            self._delays.append((arrival - stamp) / _SECOND)
            return stamp
        wall = arrival if wall is None else wall
        self._lead = arrival - wall
        return self._in_order(stamp, self._of_own_clock(stamp, wall) + self._lead)

    def _in_order(self, stamp: int, time: int) -> int:
        """Return the `time` of a `stamp` after that of an older one, which a better offset may have overtaken."""
        if stamp > self._newest[0]:
            is_near = self._newest[1] - time < _NEAR  # else simulated time has begun again
            self._newest = stamp, max(time, self._newest[1] + 1) if is_near else time
            return self._newest[1]
        return time

    def _check(self, stamp: int, arrival: int) -> None:
        if self.rule is ClockRule.NONE:
            self.violation = (
                "its messages are stamped, but it is declared to send no stamps: they are ignored" if stamp else ""
            )
        elif stamp == 0:
            self.violation = "its messages have no stamp: their time of arrival is used"
        elif self.rule is ClockRule.SIMULATED and abs(stamp - arrival) > _NEAR:
            ahead = (stamp - arrival) / _SECOND
            self.violation = f"its stamps are {abs(ahead):.6g} s {'ahead of' if ahead > 0 else 'behind'} simulated time"
        else:
            self.violation = ""
        self.violations += bool(self.violation)

    def _of_own_clock(self, stamp: int, arrival: int) -> int:
        if self._reference is None or self._has_stepped(stamp, arrival):
            self._reference = arrival - stamp
            self._envelope.clear()
            self._second, self._far_in_a_row = -1, 0
        # small numbers, so that doubles hold nanoseconds
        difference = (arrival - stamp) - self._reference
        self._note(arrival, difference)
        offset = self._offset + self._drift * arrival / _SECOND
        delay = difference / _SECOND - offset
        self._delays.append(max(0.0, delay))
        return min(arrival, stamp + self._reference + round(offset * _SECOND))

    def _has_stepped(self, stamp: int, arrival: int) -> bool:
        assert self._reference is not None
        offset = self._offset + self._drift * arrival / _SECOND
        delay = (arrival - stamp - self._reference) / _SECOND - offset
        self._far_in_a_row = self._far_in_a_row + 1 if delay > _STEP_AHEAD else 0
        return delay < -_STEP_BACK or self._far_in_a_row >= _STEPPED

    def _note(self, arrival: int, difference: int) -> None:
        """Keep the smallest difference of each second, and fit the line again where there is a new one."""
        second = arrival // _SECOND
        if second == self._second:
            if difference / _SECOND >= self._envelope[-1][1]:
                return
            self._envelope.pop()
        self._second = second
        self._envelope.append((arrival / _SECOND, difference / _SECOND))
        self._fit()

    def _fit(self) -> None:
        times, least = np.array(self._envelope).T
        self._drift = 0.0
        if len(times) > _DRIFT_AFTER:
            middle = times.mean()
            early = times < middle
            slopes = (least[~early] - least[early, None]) / (times[~early] - times[early, None])
            in_middle = least[early, None] + slopes * (middle - times[early, None])
            self._drift = float(slopes.flat[in_middle.argmin()])
        self._offset = float((least - self._drift * times).min())

    @property
    def offset(self) -> float:
        """What must be added to a stamp of an own clock now [s]."""
        if self._reference is None:
            return 0.0
        now = self._envelope[-1][0] if self._envelope else 0.0
        return (self._reference + self._lead) / _SECOND + self._offset + self._drift * now

    @property
    def drift(self) -> float:
        """How much faster simulated time runs than an own clock [-]."""
        return self._drift

    @property
    def jitter(self) -> float:
        """Standard deviation of the delay of the last messages [s]."""
        return float(np.std(self._delays)) if self._delays else 0.0

    @property
    def largest_delay(self) -> float:
        """Largest delay of the last messages beyond the least one [s]."""
        is_known = self._delays and all(map(math.isfinite, self._delays))
        return max(self._delays) - min(self._delays) if is_known else 0.0

    def describe(self) -> str:
        """Return the active rule, and what was estimated, in words."""
        if self.rule is ClockRule.DETECT:
            return "nothing received yet"
        taken_off = f"; latency of {1e3 * self.latency:g} ms taken off" if self.latency else ""
        if self.rule is ClockRule.NONE:
            return f"no stamp: time of arrival{taken_off}"
        jitter = f"jitter {1e3 * self.jitter:.1f} ms"
        if self.rule is ClockRule.SIMULATED:
            least, most = (min(self._delays), max(self._delays)) if self._delays else (0.0, 0.0)
            return f"simulated time; {jitter}, {1e3 * least:.1f} to {1e3 * most:.1f} ms behind at arrival{taken_off}"
        spread = f"{jitter}, up to {1e3 * self.largest_delay:.1f} ms more than the least delay"
        return f"own clock: offset {self.offset:.3f} s, drift {1e6 * self.drift:.1f} ppm; {spread}{taken_off}"


def detect(stamp: int, arrival: int) -> ClockRule:
    """Return the rule that a first message follows.

    Parameters
    ----------
    stamp : of the message [ns]
    arrival : simulated time at which it came [ns]
    """
    if stamp == 0:
        return ClockRule.NONE
    return ClockRule.SIMULATED if abs(stamp - arrival) <= _NEAR else ClockRule.OWN
