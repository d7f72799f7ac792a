"""Steps in the heave of a motion reference unit: it cannot move otherwise than its own heave rate says.

A unit that does not measure the rate is taken at that of its readings before, steps left out.

A ship heaves about where it floats, and so does what an MRU reads. After a step, heave and rate contradict each other
by as much as the step, for as long as it stays; a wrong mean heave would be paid out, metre by metre.
"""

from __future__ import annotations

import math

from heave_node.interface.sensors import MruReading

LARGEST_STEP, SIGMAS = 0.3, 8.0
"""A step is more than the first [m], and than so many standard deviations of its noise."""

LONGEST_GAP = 0.5
"""Longest gap between samples; after a longer one the comparison restarts [s]."""

MEMORY = 60.0
"""Time over which the mean of the heave is taken [s]."""

LARGEST_HEAVE = 100.0
"""Heave that no ship reaches [m]."""

NEAR_MEAN, LEAST_NEAR = 0.25, 0.1
"""Distance of the mean to the one before within which an MRU is read again after a step: standard deviations, [m]."""


class MruSteps:
    """Detects that the heave of an MRU has stepped away from the integral of its rate.

    Attributes
    ----------
    is_unproved : it has come back by its mean alone, which one of another scale does as well
    """

    def __init__(self) -> None:
        self.is_unproved = False
        self._last: MruReading | None = None
        self._foreseen = self._rate = 0.0
        self._mean, self._known = 0.0, 0.0
        self._new_mean = self._new_square = self._new_time = 0.0

    def restart(self) -> None:
        """Restart: what comes next need not go on from what came last."""
        self._last = None

    def is_off(self, reading: MruReading, noise: float) -> bool:
        """Take a `reading` in, whose `noise` is so large [m], 1 sigma; tell whether its heave is off by a step."""
        self.is_unproved = False
        last, self._last = self._last, reading
        elapsed = math.inf if last is None else reading.time - last.time
        if last is None or not 0.0 < elapsed <= LONGEST_GAP:
            self._foreseen, self._rate, self._new_time = reading.heave, 0.0, 0.0
            return False
        self._foreseen += self._rate_between(last, reading, noise) * elapsed
        off = abs(reading.heave - self._foreseen)
        if off <= max(LARGEST_STEP, SIGMAS * noise) or self._is_back(reading.heave, elapsed):
            self._follow(reading.heave, elapsed)
            return False
        return True

    def _rate_between(self, last: MruReading, reading: MruReading, noise: float) -> float:
        """Return the heave rate from the `last` reading to this [m/s], by the rates that were read or the one before.

        `noise` is that of the heave [m], 1 sigma.
        """
        if not math.isnan(last.heave_rate + reading.heave_rate):
            return 0.5 * (last.heave_rate + reading.heave_rate)
        before, change = self._rate, reading.heave - last.heave
        if abs(change) <= max(LARGEST_STEP, SIGMAS * noise):
            self._rate = change / (reading.time - last.time)
        return before

    def _follow(self, heave: float, elapsed: float) -> None:
        """Go on from a `heave` [m] that is right, so long `elapsed` after the last [s]."""
        self._foreseen, self._new_time = heave, 0.0
        self._known = min(self._known + elapsed, MEMORY)
        self._mean += elapsed / self._known * (heave - self._mean)

    def _is_back(self, heave: float, elapsed: float) -> bool:
        """Tell whether what is read since a step has the mean of before."""
        if self._new_time == 0.0:
            self._new_mean = self._new_square = 0.0
        self._new_time += elapsed
        heave = min(max(heave, -LARGEST_HEAVE), LARGEST_HEAVE)
        weight = elapsed / min(self._new_time, MEMORY)
        self._new_mean += weight * (heave - self._new_mean)
        self._new_square += weight * (heave**2 - self._new_square)
        spread = math.sqrt(max(self._new_square - self._new_mean**2, 0.0))
        is_near = abs(self._new_mean - self._mean) < max(NEAR_MEAN * spread, LEAST_NEAR)
        self.is_unproved = self._new_time >= MEMORY and is_near
        return self.is_unproved
