"""Steps in the heave of a motion reference unit: it cannot move otherwise than its own heave rate says.

A unit that does not measure the rate is taken at that of its readings before, steps left out. Where it says no time
either, its stamps are arrivals, which a busy machine scatters: heave is then off by so much more as it moves meanwhile.

A ship heaves about where it floats, and so does what an MRU reads. After a step, heave and rate contradict each other
by as much as the step, for as long as it stays; a wrong mean heave would be paid out, metre by metre.
"""

from __future__ import annotations

import math

from heave_node.interface.sensors import MruReading

LARGEST_STEP, SIGMAS = 0.3, 8.0
"""A step is more than the first [m], and than so many standard deviations of its noise."""

SCATTER = 0.2
"""Time by which a reading without a time may be late [s]; over it the rate is taken that is not measured."""

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
        self._foreseen, self._rate = 0.0, math.nan
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
            self._foreseen, self._rate, self._new_time = reading.heave, math.nan, 0.0
            return False
        self._foreseen += self._change_between(last, reading, noise)
        off = abs(reading.heave - self._foreseen)
        if off <= max(LARGEST_STEP, SIGMAS * noise) or self._is_back(reading.heave, elapsed):
            self._follow(reading.heave, elapsed)
            return False
        return True

    def _change_between(self, last: MruReading, reading: MruReading, noise: float) -> float:
        """Return by how much the heave has changed from the `last` reading to this [m], a step left out.

        By the rates that were read; without them by the heave itself, unless it is off what it did before. `noise` is
        that of the heave [m], 1 sigma.
        """
        elapsed = reading.time - last.time
        if not math.isnan(last.heave_rate + reading.heave_rate):
            return 0.5 * (last.heave_rate + reading.heave_rate) * elapsed
        change = reading.heave - last.heave
        if math.isnan(self._rate):
            self._rate = change / (elapsed + SCATTER)
            return change
        expected = self._rate * elapsed
        if abs(change - expected) > max(LARGEST_STEP, SIGMAS * noise) + SCATTER * abs(self._rate):
            return expected
        self._rate += (change - expected) / (elapsed + SCATTER)
        return change

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
