"""The mean payout: where compensation works about, and how it goes to another depth.

A move is bounded in speed and acceleration and ends without overshoot; its target may change or be taken back at any
time, and the motion goes on smoothly from where it is.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from heave_core.envelope_table import MoveKind
from heave_core.law import put
from heave_core.law_table import MEAN_PAYOUT
from heave_core.library import library, new

from winch_controller_node.parameters.laws import MoveParameters

LONGEST_PLAY = 2_000_000
"""Ticks of a move that are played ahead at most: a day, in a few hundredths of a second of work."""


class MovePoint(NamedTuple):
    """The mean payout at a tick: payout [m], rate [m/s], acceleration [m/s^2]."""

    payout: float
    rate: float
    acceleration: float


class MoveRequest(NamedTuple):
    """What was last asked of the mean payout, as whoever makes the move a second time must know it."""

    number: int = 0  # counts requests
    # "go" to a target, "stop" smoothly, "halt", "drive" at a speed, "stand": it is elsewhere now, at rest
    kind: str = "stand"
    distance: float = 0.0  # to the target [m]
    target: float = math.nan  # payout to go to [m]; NaN: it goes nowhere, or not by payout
    speed: float = 0.0  # largest, or asked for [m/s]
    acceleration: float = 0.0  # largest [m/s^2]
    reference: float = math.nan  # distance by a depth sensor [m]; NaN: none


def approach_speed(distance: float, acceleration: float, lag: float) -> float:
    """Return the largest speed [m/s] from which half the acceleration is enough to stop after `distance`.

    Parameters
    ----------
    distance : to go, at least 0 [m]
    acceleration : largest [m/s^2]
    lag : with which a motion goes to another speed [s]; near the end that decides
    """
    speed: float = library().heave_core_approach_speed(distance, acceleration, lag)
    return speed


class MeanPayout:
    """Generator of the mean payout, one point per tick, which the core makes.

    Parameters
    ----------
    parameters : default speed, acceleration, time over which acceleration builds up
    tick_period : [s]
    record : array of one `MeanPayout` of the core that it moves; None: it has its own
    """

    def __init__(self, parameters: MoveParameters, *, tick_period: float, record: Any = None) -> None:
        self._parameters = parameters
        self._dt = tick_period
        self.lag = max(parameters.jerk_time, 2.0 * tick_period)  # with which it goes to another speed [s]
        self._record = new(MEAN_PAYOUT) if record is None else record
        put(self._record, {"tick_period": tick_period, "jerk_time": parameters.jerk_time})
        self._move, self._address = self._record["move"], self._record.ctypes.data
        self._core = library()
        self.point = MovePoint(0.0, 0.0, 0.0)  # now
        self.target = 0.0  # of the last move [m]
        self._acceleration = parameters.acceleration
        self._ticks_to_go = 0
        self.request = MoveRequest()  # that was last made
        self._set(MoveKind.STAND)

    def _note(self, kind: str, speed: float = 0.0, **where: float) -> None:
        """Note a request of a `kind` with its `speed` [m/s]; `where` it goes are fields of it."""
        number = self.request.number + 1
        acceleration = where.pop("acceleration", self._acceleration)
        self.request = MoveRequest(number, kind, speed=speed, acceleration=acceleration, **where)

    def _set(self, kind: MoveKind, speed: float = 0.0, distance: float = 0.0) -> None:
        """Begin a motion of a `kind` with its `speed` [m/s] and `distance` [m], and the acceleration that is set."""
        values = {"kind": kind, "speed": speed, "distance": distance, "acceleration": self._acceleration}
        put(self._move, values)

    @property
    def _kind(self) -> MoveKind:
        return MoveKind(int(self._move["kind"][0]))

    @property
    def is_moving(self) -> bool:
        """Return whether a move is under way."""
        return bool(self._core.heave_core_is_moving(self._address))

    @property
    def has_target(self) -> bool:
        """Return whether a move is under way to a target."""
        return self._kind is MoveKind.GO and self.is_moving

    @property
    def time_to_go(self) -> float:
        """Time to the target [s], 0 on arrival and where there is no target to go to.

        The move is played ahead once, and the ticks that it takes are counted down.
        """
        if not self.has_target:
            return 0.0
        if self._ticks_to_go == 0:
            self._ticks_to_go = self._core.heave_core_ticks_to_go(self._address, LONGEST_PLAY)
        return self._ticks_to_go * self._dt

    def move_to(self, payout: float, speed: float = 0.0, reference: float = math.nan) -> None:
        """Go to the mean payout [m] at no more than `speed` [m/s]; 0 takes the default.

        `reference` is the distance by a depth sensor [m], where the request is for a depth.
        """
        if not math.isfinite(payout) or not math.isfinite(speed) or speed < 0.0:
            raise ValueError(f"a move needs a finite payout and a speed of at least 0; got {payout} m, {speed} m/s")
        self.target = payout
        self._acceleration = self._parameters.acceleration
        self._ticks_to_go = 0
        largest, distance = speed if speed > 0.0 else self._parameters.speed, payout - self.point.payout
        self._set(MoveKind.GO, largest, distance)
        by_payout = payout if math.isnan(reference) else math.nan
        self._note("go", largest, distance=distance, target=by_payout, reference=reference)

    def stop(self) -> None:
        """Come to rest smoothly, wherever that is; a halt goes on."""
        if self._kind is not MoveKind.HALT:
            self._set(MoveKind.STOP_MOVE)
        self._note("stop")

    def halt(self, deceleration: float) -> None:
        """Come to rest at a `deceleration` [m/s^2], without the ease of a move."""
        self._set(MoveKind.HALT)
        put(self._move, {"acceleration": deceleration})
        self._note("halt", acceleration=deceleration)

    def drive(self, rate: float, acceleration: float) -> None:
        """Go to a `rate` [m/s] and keep it until another command; 0 ends the motion.

        It is done with no more than an `acceleration` [m/s^2], which builds up as that of a move does. A halt goes on
        until it is at rest.
        """
        self._acceleration = acceleration
        self.stop()
        if rate != 0.0:
            if self._kind is not MoveKind.HALT:
                self._set(MoveKind.DRIVE, rate)
            self._note("drive", rate)

    def jump_to(self, payout: float) -> None:
        """Take the mean payout to be here, at rest: for when the winch has stopped there."""
        self.target = payout
        self._set(MoveKind.STAND)
        put(self._move, {"rate": 0.0, "slope": 0.0})
        put(self._record, {"payout": payout})
        self.point = MovePoint(payout, 0.0, 0.0)
        self._note("stand")

    def advance(self) -> MovePoint:
        """Return the point of the next tick."""
        has_halted = bool(self._core.heave_core_advance_mean(self._address))
        return self.advanced(has_halted=has_halted)

    def advanced(self, *, has_halted: bool = False) -> MovePoint:
        """Return the point to which the core has moved it; with `has_halted` a halt has ended there."""
        self._ticks_to_go = max(self._ticks_to_go - 1, 0)
        move = self._move[0]
        self.point = MovePoint(float(self._record["payout"][0]), float(move["rate"]), float(move["slope"]))
        if has_halted:
            self.jump_to(self.point.payout)
        return self.point
