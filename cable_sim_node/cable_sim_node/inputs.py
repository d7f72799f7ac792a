"""Inputs of the plant that go on smoothly where values are late or missing.

In lockstep every value is there and passes unchanged. In real time the newest value is carried forward to the end of
the tick (`NewestMotion`). One that is too old for that counts as missing (`BridgedInput`): the signal then coasts to
rest, and when values come again the gap between the coasted and the true signal closes without a jump of position or
velocity, so that a lost message never jerks the cable. The gap between the place where the plant rests at the start and
the first value is closed in the same way, where it is large enough to be felt.
"""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from heave_node.numerics.arrays import Array
from heave_node.numerics.kinematics import PointMotion

CLOSING_TIME = 2.0
"""Time constant of coasting to rest, and of the critically damped closing of the gap afterwards [s]."""
FELT_GAP = 0.02
FELT_GAP_RATE = 0.1
"""A gap at the start is bridged where it, or its rate, is larger [m], [m/s]."""


LONGEST_EXTRAPOLATION = 0.5
"""A value older than this is missing [s]."""


FOLLOWING_TIME = 1.0
"""Time constant with which the payout of the shadow plant follows the programme, critically damped [s]."""

Gap = TypeVar("Gap", float, Array)
"""Of a number, or of each axis."""


def closed(gap: Gap, rate: Gap, duration: float, time_constant: float) -> tuple[Gap, Gap]:
    """Return what critically damped closing leaves of a `gap` and its `rate`; `duration`, `time_constant` [s]."""
    decay = math.exp(-duration / time_constant)
    slope = rate + gap / time_constant
    return (gap + slope * duration) * decay, (rate - slope * duration / time_constant) * decay


def is_finite(motion: PointMotion) -> bool:
    """Return whether every number of a `motion` is finite, and so their sum."""
    numbers = motion.position.tolist() + motion.velocity.tolist() + motion.acceleration.tolist()
    return math.isfinite(sum(numbers))


class NewestMotion:
    """The newest motion of a signal, carried forward to the requested time."""

    def __init__(self) -> None:
        self._newest: PointMotion | None = None

    def put(self, motion: PointMotion) -> None:
        """Take a motion; its `time` says when it holds [s]."""
        self._newest = motion

    def at(self, time: float) -> PointMotion | None:
        """Return the motion at `time` [s], at constant acceleration from the newest one; None where that is too old."""
        motion = self._newest
        if motion is None or abs(time - motion.time) > LONGEST_EXTRAPOLATION:
            return None
        age = time - motion.time
        if age == 0.0:
            return motion
        velocity = motion.velocity + motion.acceleration * age
        position = motion.position + 0.5 * (motion.velocity + velocity) * age
        return PointMotion(time, position, velocity, motion.acceleration)


class BridgedInput:
    """A position and its velocity, sampled once a tick, with bridging of what is missing.

    Parameters
    ----------
    name : for messages
    position : shape (n,), where the signal rests at the start; then, as `velocity` and `acceleration`, as last advanced
    tick_period : [s]

    Attributes
    ----------
    velocity, acceleration : shape (n,), as last advanced
    has_started : whether a value has come yet
    missing_in_a_row, missing : values that were missing just now and in all
    """

    def __init__(self, name: str, position: Array, *, tick_period: float) -> None:
        self.name = name
        self.position = position.copy()
        self.velocity = np.zeros_like(position)
        self.acceleration = np.zeros_like(position)
        self.missing_in_a_row = 0
        self.missing = 0
        self.has_started = False
        self._tick_period = tick_period
        self._has_gap = False
        self._gap = np.zeros_like(position)
        self._gap_rate = np.zeros_like(position)

    def advance(self, value: PointMotion | None) -> None:
        """Take the value of the next tick, whatever its time says, or None where it is missing.

        A value that is not finite counts as missing.
        """
        if value is None or not is_finite(value):
            self.missing_in_a_row += 1
            self.missing += 1
            self._coast()
            return
        position, velocity, acceleration = value.position, value.velocity, value.acceleration
        if self.missing_in_a_row or not self.has_started:
            self._open_gap(position, velocity)
        if not self._has_gap:
            self.position, self.velocity, self.acceleration = position, velocity, acceleration
            return
        gap_acceleration = self._close_gap()
        self.position = position + self._gap
        self.velocity = velocity + self._gap_rate
        self.acceleration = acceleration + gap_acceleration

    def _coast(self) -> None:
        decay = math.exp(-self._tick_period / CLOSING_TIME)
        self.position = self.position + self.velocity * CLOSING_TIME * (1.0 - decay)
        self.velocity = self.velocity * decay
        self.acceleration = -self.velocity / CLOSING_TIME

    def _open_gap(self, position: Array, velocity: Array) -> None:
        """Note how far the signal is from where the true one was a tick ago."""
        gap = self.position - (position - velocity * self._tick_period)
        gap_rate = self.velocity - velocity
        is_felt = np.abs(gap).max() > FELT_GAP or np.abs(gap_rate).max() > FELT_GAP_RATE
        if self.has_started or is_felt:
            self._gap, self._gap_rate = gap, gap_rate
            self._has_gap = bool(gap.any() or gap_rate.any())
        self.has_started = True
        self.missing_in_a_row = 0

    def _close_gap(self) -> Array:
        """Let the gap close by a tick and return its acceleration; a gap below any sensor's resolution is gone."""
        if np.abs(self._gap).max() < 1e-9 and np.abs(self._gap_rate).max() < 1e-9:
            self._has_gap = False
            self._gap = np.zeros_like(self._gap)
            self._gap_rate = np.zeros_like(self._gap)
            return np.zeros_like(self._gap)
        gap, rate = self._gap, self._gap_rate = closed(self._gap, self._gap_rate, self._tick_period, CLOSING_TIME)
        return -2.0 * rate / CLOSING_TIME - gap / CLOSING_TIME**2


class ShadowPayout:
    """Payout of the shadow plant, whose winch does not compensate: it follows a programme smoothly, or stays.

    Parameters
    ----------
    tick_period : [s]

    Attributes
    ----------
    payout, rate : [m], [m/s]
    """

    def __init__(self, *, tick_period: float) -> None:
        self.payout = 0.0
        self.rate = 0.0
        self._tick_period = tick_period

    def advance(self, programme: float | None) -> None:
        """Advance by a tick towards `programme` [m]; None or NaN holds the last one."""
        if programme is None or not math.isfinite(programme):
            programme = self.payout + self.rate * FOLLOWING_TIME  # ends the motion as a critically damped system does
        gap, self.rate = closed(self.payout - programme, self.rate, self._tick_period, FOLLOWING_TIME)
        self.payout = programme + gap
