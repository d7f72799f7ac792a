"""The boom tip's heave from that of a motion sensor elsewhere on the ship: rigid-body motion by roll and pitch.

z_tip = heave - x sin(pitch) + (y sin(roll) + z cos(roll)) cos(pitch), less its value at rest; roll about x forward,
then pitch about y to port (REP-103), arm x, y, z from the sensor. The rate follows by the chain rule from the turn
rates, or, where the sensor has none, from the attitude of the last 0.6 s, with its noise. A heave is about its mean:
of the arm's share a running mean is taken out, its change of the rate too, so that trim and list do not lift the tip.

The simulated boom tip moves by it without its steps, which are none of the ship: a spike, a sensor that froze or fell
silent and goes on, or a new zero would throw the simulated load by metres. What a step adds is taken off at once, and
given back in GLIDE by half a cosine.
"""

from __future__ import annotations

import math
from typing import Any

from heave_node.numerics.kinematics import height_of, height_rate_of
from heave_node.sensing.recent_motion import OLDEST, RecentMotion

FIRST_MEAN_TIME, MEAN_TIME = 1.0, 300.0
"""Time constant of the running mean [s]: the time since the start, so that it is the average of all, up to the last."""


class TipMotion:
    """Carries heave to the boom tip, an `arm` from the sensor: x forward, y to port, z up [m]."""

    def __init__(self, arm: tuple[float, float, float]) -> None:
        self._arm = arm
        self._is_here = not any(arm)
        self._mean = 0.0
        self._first = self._last = math.nan
        self._recent = RecentMotion()
        self._given: tuple[Any, ...] = ()
        self._carried = (math.nan, math.nan, math.nan)

    def carry(
        self, time: float, heave: float, rate: float, attitude: tuple[float, float], turning: tuple[float, float]
    ) -> tuple[float, float, float]:
        """Return heave, heave rate and what its arm's share is uncertain by [m], [m/s], [m/s]; NaN: not known.

        At a `time` [s] the sensor reads `heave` and `rate`, `attitude` as roll and pitch [rad] and `turning` as their
        rates [rad/s]; NaN: not measured. What is read the same again stays the same, though the mean goes on: else
        nobody saw that a sensor is frozen.
        """
        if self._is_here:
            return heave, rate, 0.0
        given = heave, rate, attitude, turning
        if given != self._given:
            self._given, self._carried = given, self._carry(time, heave, rate, attitude, turning)
        return self._carried

    def _carry(
        self, time: float, heave: float, rate: float, attitude: tuple[float, float], turning: tuple[float, float]
    ) -> tuple[float, float, float]:
        share = height_of(self._arm, *attitude) - self._arm[2]
        if not math.isfinite(share):
            return math.nan, math.nan, math.nan
        self._recent.add(time, share)
        turned, sigma = height_rate_of(self._arm, *attitude, turning), 0.0
        if not math.isfinite(turned):
            recent = self._recent.at(time)
            turned, sigma = math.nan if recent is None else recent[1], self._recent.rate_sigma
        drift = self._update_mean(time, share)  # left in, it would look like a high-pass filter of the sensor
        return heave + share - self._mean, rate + turned - drift, sigma

    def _update_mean(self, time: float, share: float) -> float:
        if not math.isfinite(self._first):
            self._first, self._last, self._mean = time, time, share
        step, self._last = max(time - self._last, 0.0), max(time, self._last)
        span, away = min(max(time - self._first, FIRST_MEAN_TIME), MEAN_TIME), share - self._mean
        self._mean += away * min(step / span, 1.0)
        return away / span - away / MEAN_TIME  # none is taken out once it is over MEAN_TIME


STEP = 0.2
"""A reading further from where the last ones lead is a step: a ship's acceleration adds less, and so does noise [m]."""
ACCELERATION = 10.0
"""Acceleration that no ship exceeds, which counts where readings are apart [m/s^2]."""
RATE_TIME = 0.2
"""Time over which the rate is taken that leads from one reading to the next [s]."""
GLIDE = 5.0
"""Time in which a step is given back [s]."""


class WithoutSteps:
    """Takes steps out of readings that move the boom tip by `motion`: it stands still in a gap of more than OLDEST."""

    def __init__(self, motion: RecentMotion) -> None:
        self._motion = motion
        self._last: tuple[float, float] | None = None
        self._rate = 0.0
        self._since, self._size = -math.inf, 0.0

    def at(self, time: float, value: float) -> float:
        """Return a `value` of a `time` [s] without the steps so far [m]."""
        before = self._last or (time, value)
        elapsed, change = time - before[0], value - before[1]
        step = change - self._rate * elapsed
        if elapsed > OLDEST and (stands := self._motion.at(before[0] + 0.99 * OLDEST)):
            self._size, self._since, self._rate = value - stands[0], time, 0.0
        elif abs(step) > STEP + 0.5 * ACCELERATION * elapsed**2:
            self._size, self._since = self._left(time) + step, time
        elif elapsed > 0.0:
            self._rate += (change / elapsed - self._rate) * min(elapsed / RATE_TIME, 1.0)
        self._last = (time, value)
        return value - self._left(time)

    def _left(self, time: float) -> float:
        """Return what is left at a `time` [s] of the steps so far [m]."""
        gone = (time - self._since) / GLIDE
        return self._size * 0.5 * (1.0 + math.cos(math.pi * gone)) if gone < 1.0 else 0.0
