"""Running comparisons of two motions: over some waves, and over seconds."""

from __future__ import annotations

import math
from dataclasses import dataclass

SLOW_MEAN_FACTOR = 3.0
"""The mean about which motion is judged is followed this many times more slowly than the variance."""

MEAN_TIME = 5.0
"""Time in which heave that a sensor reads is forgotten [s]: slower motion is its mean."""

LARGEST_STEP, LARGEST_SPEED = 0.2, 4.0
"""Steps [m] above the first and what the second [m/s] makes of the time between are the sensor's, not the unit's."""


class RunningSigma:
    """Exponentially weighted standard deviation about a slow mean.

    Parameters
    ----------
    time_constant : memory [s]
    tick_period : [s]
    """

    def __init__(self, time_constant: float, tick_period: float) -> None:
        self._weight = tick_period / time_constant
        self._count = 0
        self._mean = 0.0
        self._variance = 0.0

    def add(self, value: float) -> None:
        """Take a value in; the first ones weigh as in a plain average."""
        self._count += 1
        weight = max(self._weight, 1.0 / self._count)
        self._mean += max(self._weight / SLOW_MEAN_FACTOR, 1.0 / self._count) * (value - self._mean)
        self._variance += weight * ((value - self._mean) ** 2 - self._variance)

    @property
    def sigma(self) -> float:
        """Standard deviation, in the unit of the values."""
        return math.sqrt(self._variance)


class MeasuredHeave:
    """Heave out of the readings of a depth sensor, without their mean, spikes and jumps.

    Parameters
    ----------
    tick_period : [s]
    """

    def __init__(self, tick_period: float) -> None:
        self._dt = tick_period
        self._last: float | None = None
        self._ticks = 0
        self.value = 0.0

    def add(self, reading: float | None) -> None:
        """Take in the reading of a tick [m]; None: none came."""
        self._ticks += 1
        self.value *= 1.0 - self._dt / MEAN_TIME
        if reading is None:
            return
        step = 0.0 if self._last is None else reading - self._last
        if abs(step) <= LARGEST_STEP + LARGEST_SPEED * self._ticks * self._dt:
            self.value += step
        self._last, self._ticks = reading, 0


@dataclass(frozen=True)
class Quickness:
    """How two motions are compared over seconds.

    Attributes
    ----------
    time : memory [s]
    ratio : amplitude above this multiple of the reference's is too much
    floor : amplitude that is never too much
    noise : standard deviation of what is not motion, taken off
    """

    time: float
    ratio: float
    floor: float
    noise: float = 0.0


class QuickComparison:
    """Compares the amplitude of a motion with that of a reference, now and over the last waves.

    Parameters
    ----------
    quickness : memory, ratio and floor
    window : memory of the waves [s]
    tick_period : [s]
    """

    def __init__(self, quickness: Quickness, window: float, tick_period: float) -> None:
        self._quickness = quickness
        self._quick, self._slow = tick_period / quickness.time, tick_period / window
        self._count = 0
        self._patience = round(0.5 * window / tick_period)
        self._energy = self._reference = self._waves = 0.0

    def add(self, energy: float, reference: float) -> None:
        """Take in the squared motions of a tick."""
        self._count += 1
        least = 1.0 / self._count
        self._reference += max(self._quick, least) * (reference - self._reference)
        self._waves += max(self._slow, least) * (reference - self._waves)
        self._energy += max(self._quick, least) * (energy - self._energy)

    def begin(self, energy: float = 0.0) -> None:
        """Forget the motion, not the reference: go on as if it had been `energy`."""
        self._energy = energy

    @property
    def reference(self) -> float:
        """Mean square of the reference, the larger of now and the last waves."""
        return max(self._reference, self._waves)

    @property
    def amplitude(self) -> float:
        """Root mean square of the motion."""
        return math.sqrt(max(self._energy - self._quickness.noise**2, 0.0))

    @property
    def is_above(self) -> bool:
        """Tell whether the motion is surely above the reference, once some waves have come."""
        if self._count < self._patience:
            return False
        return self.amplitude > max(self._quickness.floor, self._quickness.ratio * math.sqrt(self.reference))
