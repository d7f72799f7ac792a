"""Running statistics and trends, the check of one amplitude against another, and a timer."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from heave_node.numerics.arrays import Array

from winch_controller_node.core.estimation.gates.depth_jumps import largest_step

SLOW_MEAN_FACTOR = 3.0
"""The mean about which motion is judged is followed this many times more slowly than the variance."""

DETREND_TIME = 5.0
"""Time constant with which the mean of a sensor's heave is followed [s]."""

REMEMBERED, LEAST_READINGS = 4096, 4
"""Readings of a trend that are kept, at least, and that a slope needs."""


class Countdown:
    """Time that is left of one that was set.

    Parameters
    ----------
    tick_period : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._left = 0.0

    def start(self, time: float) -> None:
        """Set the `time` [s]."""
        self._left = time

    def step(self) -> bool:
        """Take a tick off; return whether some is left."""
        self._left = max(self._left - self._dt, 0.0)
        return self._left > 0.0


class RunningSigma:
    """Exponentially weighted standard deviation about a slow mean.

    Parameters
    ----------
    time_constant : memory [s]
    tick_period : [s]
    """

    def __init__(self, time_constant: float, tick_period: float) -> None:
        self._weight = tick_period / time_constant
        self._slow_weight = self._weight / SLOW_MEAN_FACTOR
        self._count = 0
        self._mean = 0.0
        self._variance = 0.0

    def add(self, value: float) -> None:
        """Take a value in; the first ones weigh as in a plain average."""
        self._count += 1
        first = 1.0 / self._count
        self._mean += (self._slow_weight if self._slow_weight > first else first) * (value - self._mean)
        off = value - self._mean
        self._variance += (self._weight if self._weight > first else first) * (off**2 - self._variance)

    @property
    def sigma(self) -> float:
        """Standard deviation, in the unit of the values."""
        return math.sqrt(self._variance)


class DetrendedHeave:
    """Heave from the readings of a depth sensor: without their mean, spikes and jumps.

    Parameters
    ----------
    tick_period : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._last: float | None = None
        self._ticks = 0
        self.value = 0.0

    def add(self, reading: float | None, noise: float = 0.0) -> None:
        """Take in a tick.

        Parameters
        ----------
        reading : of the sensor [m]; None: none came
        noise : standard deviation of the sensor's, as far as it is known [m]
        """
        self._ticks += 1
        self.value *= 1.0 - self._dt / DETREND_TIME
        if reading is None:
            return
        step = 0.0 if self._last is None else reading - self._last
        if abs(step) <= largest_step(noise, self._ticks * self._dt):
            self.value += step
        self._last, self._ticks = reading, 0


@dataclass(frozen=True)
class AmplitudeLimit:
    """When an amplitude is too large.

    Attributes
    ----------
    time : memory of the amplitude [s]
    ratio : largest amplitude over that of the reference
    floor : amplitude that is never too large
    """

    time: float
    ratio: float
    floor: float


class AmplitudeCheck:
    """Checks the amplitude of a motion against that of a reference, over seconds.

    The reference is the larger of its amplitude now and that over the last waves: the pause between two groups of
    waves is no reason to find a motion too large.

    Parameters
    ----------
    limit : when it is too large
    window : memory of the waves [s]
    tick_period : [s]
    """

    def __init__(self, limit: AmplitudeLimit, window: float, tick_period: float) -> None:
        self._limit = limit
        self._short_weight, self._long_weight = tick_period / limit.time, tick_period / window
        self._count = 0
        self._ticks_needed = round(0.5 * window / tick_period)
        self._mean_square = self._reference_now = self._reference_waves = 0.0
        self._left_over = self._noise = 0.0

    def add(self, square: float, reference_square: float) -> None:
        """Take in the `square` of the motion and the `reference_square` at a tick."""
        self._count += 1
        first = 1.0 / self._count
        short = self._short_weight if self._short_weight > first else first
        long = self._long_weight if self._long_weight > first else first
        self._reference_now += short * (reference_square - self._reference_now)
        self._reference_waves += long * (reference_square - self._reference_waves)
        self._mean_square += short * (square - self._mean_square)

    def restart(self, mean_square: float = 0.0) -> None:
        """Go on as if the motion's mean square had been `mean_square` until now; the reference stays."""
        self._mean_square = mean_square

    def allow(self, left_over: float) -> None:
        """Allow the motion an amplitude beside the reference, `left_over` from before it came to be judged."""
        self._left_over = left_over

    def take_off(self, noise: float) -> None:
        """Take the standard deviation of the sensor's `noise` off the amplitude from now on."""
        self._noise = noise

    @property
    def reference(self) -> float:
        """Mean square of the reference."""
        return max(self._reference_now, self._reference_waves)

    @property
    def amplitude(self) -> float:
        """Root mean square of the motion, noise taken off."""
        return math.sqrt(max(self._mean_square - self._noise**2, 0.0))

    @property
    def is_exceeded(self) -> bool:
        """Tell whether the motion is too large; never before some waves have been seen."""
        if self._count < self._ticks_needed:
            return False
        largest = self._limit.ratio * (math.sqrt(self.reference) + self._left_over)
        return self.amplitude > max(self._limit.floor, largest)


@dataclass(frozen=True, slots=True)
class Slope:
    """Slope of a straight line through readings.

    Attributes
    ----------
    value, error : slope and its standard error, in units of the readings per second
    """

    value: float
    error: float


class Trend:
    """The newest readings, in the order of their times."""

    def __init__(self) -> None:
        self._times: Array = np.empty(2 * REMEMBERED)
        self._values: Array = np.empty(2 * REMEMBERED)
        self._count = 0
        self._changed = -math.inf

    def add(self, time: float, value: float) -> None:
        """Take in a reading `value` of a `time` [s]; one that is no later than the last one is left out."""
        if self._count and time <= self._times[self._count - 1]:
            return
        if not self._count or value != self._values[self._count - 1]:
            self._changed = time
        if self._count == self._times.size:
            for array in (self._times, self._values):
                array[:REMEMBERED] = array[REMEMBERED:]
            self._count = REMEMBERED
        self._times[self._count], self._values[self._count] = time, value
        self._count += 1

    def has_stood(self, window: float) -> bool:
        """Return whether all readings of the last `window` seconds are equal; True without readings."""
        return self._count == 0 or self._changed <= float(self._times[self._count - 1]) - window

    def mean(self, window: float) -> float:
        """Return the mean over the last `window` seconds; 0 without readings."""
        if not self._count:
            return 0.0
        times = self._times[: self._count]
        return float(np.mean(self._values[np.searchsorted(times, times[-1] - window) : self._count]))

    def slope(self, window: float) -> Slope | None:
        """Return the slope over the last `window` seconds; None: they hold too few readings."""
        times, values = self._times[: self._count], self._values[: self._count]
        if times.size < LEAST_READINGS or times[-1] - times[0] < 0.9 * window:
            return None
        first = np.searchsorted(times, times[-1] - window)
        times, values = times[first:], values[first:]
        if times.size < LEAST_READINGS:
            return None
        about = times - times.mean()
        spread = float(about @ about)
        slope = float(about @ values) / spread
        rest = values - values.mean() - slope * about
        return Slope(slope, math.sqrt(float(rest @ rest) / (times.size - 2) / spread))
