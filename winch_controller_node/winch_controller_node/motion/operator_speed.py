"""The operator's speed of the mean payout, as from a joystick: bounded by its share of the winch, and short-lived."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from heave_node.interface.alarm import Alarm

from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.requests import NO_SPEED, SPEED, Request
from winch_controller_node.motion.trajectory import MovePoint, approach_speed
from winch_controller_node.parameters.laws import OperatorParameters


@dataclass(frozen=True, slots=True)
class OperatorRange:
    """What the operator may use of the winch; compensation has what that leaves."""

    speed: float  # largest [m/s]
    acceleration: float  # largest [m/s^2]
    payout_minimum: float  # lower end of the range [m]
    payout_maximum: float  # upper end of the range [m]
    lag: float  # with which the mean payout goes to another speed [s]

    def nearest(self, speed: float, payout: float) -> float:
        """Return the speed next to `speed` [m/s], positive lowers, that ends in the range from a `payout` [m]."""
        down, up = self.payout_maximum - payout, payout - self.payout_minimum
        lowering, lifting = (approach_speed(max(room, 0.0), self.acceleration, self.lag) for room in (down, up))
        return float(np.clip(speed, -min(self.speed, lifting), min(self.speed, lowering)))


class OperatorSpeed:
    """The speed that was asked for last; it lapses when it is not asked for again.

    Parameters
    ----------
    parameters : how long it holds
    tick_period : [s]
    """

    def __init__(self, parameters: OperatorParameters, *, tick_period: float) -> None:
        self._dt = tick_period
        self._timeout = parameters.timeout
        self._asked = 0.0
        self._age = math.inf
        self._is_limit_reported = False
        self._reported: float | None = None
        self._begun_at: float | None = None

    @property
    def is_asked(self) -> bool:
        """Return whether an operator asks for a speed now, zero included."""
        return self._age <= self._timeout

    def ask(self, speed: float) -> None:
        """Ask for a `speed` of the mean payout, positive lowers [m/s]."""
        self._is_limit_reported = self._is_limit_reported and self.is_asked and speed != 0.0
        self._asked, self._age = speed, 0.0

    def drop(self) -> None:
        """Discard the request."""
        self._asked, self._age = 0.0, math.inf

    def advance(self, point: MovePoint, bounds: OperatorRange) -> float:
        """Return the speed of the next tick [m/s] at a `point` of mean payout, within `bounds`; 0 once it lapsed."""
        self._age += self._dt
        return bounds.nearest(self._asked, point.payout) if self.is_asked else 0.0

    def news(self, payout: float) -> tuple[str, ...]:
        """Return in words a speed other than before, or that none is asked for, at the mean `payout` [m] of now."""
        asked = self._asked if self.is_asked else None
        if asked == self._reported:
            return ()
        self._reported = asked
        words = Request(NO_SPEED).words if asked is None else Request(SPEED, (asked,)).words
        if asked and self._begun_at is None:
            self._begun_at = payout
        elif not asked and self._begun_at is not None:
            words += f": the mean payout has moved by {payout - self._begun_at:+.2f} m"
            self._begun_at = None
        return (words,)

    def limit_news(self, bounds: OperatorRange) -> Alarm | None:
        """Return that more is requested than `bounds` allow, once until it rests or lapses; else None."""
        if self._is_limit_reported or not self.is_asked or abs(self._asked) <= bounds.speed:
            return None
        self._is_limit_reported = True
        return ALARMS.alarm("OPERATOR_SPEED_LIMITED", requested=abs(self._asked), limit=bounds.speed)
