"""The mean payout: where compensation works about, and how it goes to another depth.

A move is bounded in speed and acceleration and ends without overshoot; its target may change or be taken back at any
time, and the motion goes on smoothly from where it is.
"""

from __future__ import annotations

import copy
import math
from typing import NamedTuple

from winch_controller_node.parameters.laws import MoveParameters

ARRIVED_DISTANCE = 0.005
"""Distance from its target within which a move has arrived [m], once it is slower than ARRIVED_SPEED."""
ARRIVED_SPEED = 0.002
"""Speed below which a move has arrived [m/s], once it is within ARRIVED_DISTANCE."""
CRUISING = 0.995
"""Share of its speed from which on a move counts as being at its speed."""
LONGEST_PLAY = 20_000
"""Ticks of a move that are played ahead at most: a twentieth of a second of work."""


class MovePoint(NamedTuple):
    """The mean payout at a tick: payout [m], rate [m/s], acceleration [m/s^2]."""

    payout: float
    rate: float
    acceleration: float


class MoveRequest(NamedTuple):
    """What was last asked of the mean payout, as whoever makes the move a second time must know it.

    Attributes
    ----------
    number : counts requests
    kind : "go" to a target, "stop" smoothly, "halt", "drive" at a speed, "stand": it is elsewhere now, at rest
    distance : to the target [m]
    target : payout to go to [m]; NaN: it goes nowhere, or not by payout
    speed : largest, or asked for [m/s]
    acceleration : largest [m/s^2]
    reference : distance by a depth sensor [m]; NaN: none
    """

    number: int = 0
    kind: str = "stand"
    distance: float = 0.0
    target: float = math.nan
    speed: float = 0.0
    acceleration: float = 0.0
    reference: float = math.nan


def approach_speed(distance: float, acceleration: float, lag: float) -> float:
    """Return the largest speed [m/s] from which half the acceleration is enough to stop after `distance`.

    Parameters
    ----------
    distance : to go, at least 0 [m]
    acceleration : largest [m/s^2]
    lag : with which a motion goes to another speed [s]; near the end that decides
    """
    return min(math.sqrt(acceleration * distance), distance / (4.0 * lag))


class MeanPayout:
    """Generator of the mean payout, one point per tick.

    Parameters
    ----------
    parameters : default speed, acceleration, time over which acceleration builds up
    tick_period : [s]

    Attributes
    ----------
    lag : with which it goes to another speed [s]
    point : now
    target : of the last move [m]
    request : that was last made
    """

    def __init__(self, parameters: MoveParameters, *, tick_period: float) -> None:
        self._parameters = parameters
        self._dt = tick_period
        self.lag = max(parameters.jerk_time, 2.0 * tick_period)
        self.point = MovePoint(0.0, 0.0, 0.0)
        self.target = 0.0
        self._speed, self._acceleration = parameters.speed, parameters.acceleration
        self._is_stopping = False
        self._deceleration = 0.0
        self._driven: float | None = None
        self._ticks_to_go = 0
        self.request = MoveRequest()

    def _note(self, kind: str, speed: float = 0.0, **where: float) -> None:
        """Note a request of a `kind` with its `speed` [m/s]; `where` it goes are fields of it."""
        number = self.request.number + 1
        acceleration = self._deceleration if kind == "halt" else self._acceleration
        self.request = MoveRequest(number, kind, speed=speed, acceleration=acceleration, **where)

    @property
    def is_moving(self) -> bool:
        """Return whether a move is under way."""
        if self._driven is not None:
            return True
        if self._is_stopping:
            return abs(self.point.rate) > ARRIVED_SPEED
        return abs(self.target - self.point.payout) > ARRIVED_DISTANCE or abs(self.point.rate) > ARRIVED_SPEED

    @property
    def has_target(self) -> bool:
        """Return whether a move is under way to a target."""
        return self.is_moving and not self._is_stopping and self._driven is None

    @property
    def _rests_at_target(self) -> bool:
        """Return whether nothing moves, or is to."""
        is_free = self._driven is None and not self._is_stopping and self._deceleration == 0.0
        return is_free and self.point == (self.target, 0.0, 0.0)

    @property
    def time_to_go(self) -> float:
        """Time to the target [s], 0 on arrival and where there is no target to go to.

        The move is played ahead once, and the ticks that it takes are counted down.
        """
        if not self.has_target:
            return 0.0
        if self._ticks_to_go == 0:
            self._ticks_to_go = self._play_ahead()
        return self._ticks_to_go * self._dt

    def _play_ahead(self) -> int:
        """Return the number of ticks to the target; those at constant speed are not played one by one."""
        ahead = copy.copy(self)
        skipped = 0
        for played in range(LONGEST_PLAY):
            if not ahead.is_moving:
                return skipped + played
            skipped += ahead._skip_cruise()
            ahead.advance()
        return skipped + LONGEST_PLAY

    def _skip_cruise(self) -> int:
        """Go to where the speed of the move begins to fall, if it is reached; return the ticks that this takes."""
        distance = self.target - self.point.payout
        rate = math.copysign(self._speed, distance)
        slowing = max(self._speed**2 / self._acceleration, 4.0 * self.lag * self._speed)
        if self.point.rate / rate < CRUISING or abs(distance) <= slowing:
            return 0
        ticks = int((abs(distance) - slowing) / max(self._speed * self._dt, 1e-9))
        self.point = MovePoint(self.point.payout + ticks * self._dt * rate, rate, 0.0)
        return ticks

    def move_to(self, payout: float, speed: float = 0.0, reference: float = math.nan) -> None:
        """Go to the mean payout [m] at no more than `speed` [m/s]; 0 takes the default.

        `reference` is the distance by a depth sensor [m], where the request is for a depth.
        """
        if not math.isfinite(payout) or not math.isfinite(speed) or speed < 0.0:
            raise ValueError(f"a move needs a finite payout and a speed of at least 0; got {payout} m, {speed} m/s")
        self.target = payout
        self._speed = speed if speed > 0.0 else self._parameters.speed
        self._acceleration = self._parameters.acceleration
        self._is_stopping, self._deceleration, self._driven = False, 0.0, None
        self._ticks_to_go = 0
        by_payout = payout if math.isnan(reference) else math.nan
        distance = payout - self.point.payout
        self._note("go", self._speed, distance=distance, target=by_payout, reference=reference)

    def stop(self) -> None:
        """Come to rest smoothly, wherever that is."""
        self._is_stopping, self._driven = True, None
        self._note("stop")

    def halt(self, deceleration: float) -> None:
        """Come to rest at a `deceleration` [m/s^2], without the ease of a move."""
        self._is_stopping = True
        self._deceleration, self._driven = deceleration, None
        self._note("halt")

    def drive(self, rate: float, acceleration: float) -> None:
        """Go to a `rate` [m/s] and keep it until another command; 0 ends the motion.

        It is done with no more than an `acceleration` [m/s^2], which builds up as that of a move does.
        """
        self._acceleration = acceleration
        self.stop()
        if rate != 0.0:
            self._is_stopping, self._driven = False, rate
            self._note("drive", rate)

    def jump_to(self, payout: float) -> None:
        """Take the mean payout to be here, at rest: for when the winch has stopped there."""
        self.point = MovePoint(payout, 0.0, 0.0)
        self.target = payout
        self._is_stopping, self._deceleration, self._driven = False, 0.0, None
        self._note("stand")

    def advance(self) -> MovePoint:
        """Return the point of the next tick."""
        self._ticks_to_go = max(self._ticks_to_go - 1, 0)
        if self._rests_at_target:
            return self.point
        if self._deceleration > 0.0:
            return self._brake()
        limit = self._acceleration
        wanted = 0.0 if self._is_stopping else self._wanted_rate()
        acceleration = (wanted - self.point.rate) / self.lag
        step = limit * self._dt / max(self._parameters.jerk_time, self._dt)
        before = self.point.acceleration
        acceleration = min(max(acceleration, before - step), before + step)
        # the limit may have become less
        acceleration = min(max(acceleration, -limit), limit)
        rate = self.point.rate + acceleration * self._dt
        payout = self.point.payout + 0.5 * (self.point.rate + rate) * self._dt
        if not self.is_moving and abs(rate) < ARRIVED_SPEED:
            # the last fraction of a millimetre is not worth a motion
            rate, acceleration, payout = 0.0, 0.0, self.point.payout
            if self._is_stopping:
                self.target, self._is_stopping = payout, False
        self.point = MovePoint(payout, rate, acceleration)
        return self.point

    def _brake(self) -> MovePoint:
        """Return the next point of a halt."""
        before, step = self.point, self._deceleration * self._dt
        rate = math.copysign(max(abs(before.rate) - step, 0.0), before.rate)
        payout = before.payout + 0.5 * (before.rate + rate) * self._dt
        if rate == 0.0:
            self.jump_to(payout)
        else:
            self.point = MovePoint(payout, rate, (rate - before.rate) / self._dt)
        return self.point

    def _wanted_rate(self) -> float:
        """Return the rate that is driven, or from which it can stop at the target."""
        if self._driven is not None:
            return self._driven
        distance = self.target - self.point.payout
        approach = approach_speed(abs(distance), self._acceleration, self.lag)
        return math.copysign(min(self._speed, approach), distance)
