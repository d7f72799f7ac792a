"""The MRU's motion carried to the boom tip of a crane that moves: rigid-body motion, and the crane's own.

The MRU states heave of the boom tip in the crane's reference pose. With the arm r from there to where the tip is now,
in the ship's frame, and R the rotation by pitch and roll, the tip moves by

    z_tip = z_mru + [R r]_z,    z_tip' = z_mru' + [R' r]_z + [R r']_z

([R' r]_z is that of omega x r). It is taken in two parts. What the ship does to the arm, [R r]_z - r_z, is heave of
the boom tip and is added to the MRU's. The crane's own lift l = r_z is no wave: the winch pays out what a boom lifts,
so that the unit keeps its depth. What it has paid out for that, m, is taken off the encoder's payout, and what is
ordered for it is given to the governor and added to the order, see `lift`. l - m, which is left while the boom gains
speed, or moves faster than the winch has speed for it, is no wave either: the unit goes with it, and what its depth
sensor reads is corrected by it.

Rates of roll and pitch are those of the last 0.6 s of the MRU's attitude. The lift is counted from the first pose. A
pose that comes back elsewhere after a hold is approached in 10 s, and the lift is counted from it again: the unit is
not moved by it. What the ship adds to heave passes the MRU's own high-pass, where it has one: the estimator knows it to
be in what is read.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

from heave_node.crane.kinematics import Crane, TipPlace, Vector
from heave_node.crane.pose import CranePose
from heave_node.interface.alarm import Alarm
from heave_node.interface.sensors import MruReading
from heave_node.numerics.high_pass import HighPass
from heave_node.numerics.kinematics import height_of, height_rate_of
from heave_node.sensing.recent_motion import RecentMotion

from winch_controller_node.crane.lift import LiftOrders
from winch_controller_node.crane.lift_room import LiftRoom
from winch_controller_node.crane.pose_watch import PoseWatch
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.readings import Measurements, ScalarReading, WinchReading
from winch_controller_node.interface.sensors import MruModelParameters
from winch_controller_node.laws.parts.governor import NO_LIFT, LiftShare
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.parameters.crane import CraneModelParameters
from winch_controller_node.parameters.model import WinchModelParameters

APPROACH = 10.0
"""Time in which a pose that has come back elsewhere is approached [s]."""


class Approach(NamedTuple):
    """The way in the horizontal to a boom tip that the pose has found elsewhere.

    Attributes
    ----------
    breaks : of the pose so far, by which the next one is known
    since : time of the last one [s]
    start, end : boom tip before and after it, from its place in the reference pose [m]
    """

    breaks: int = 0
    since: float = -math.inf
    start: Vector = (0.0, 0.0, 0.0)
    end: Vector = (0.0, 0.0, 0.0)

    def on_the_way(self, time: float, place: TipPlace) -> TipPlace:
        """Return a `place` of the boom tip at a `time` [s] with what is left of the way."""
        left = 1.0 - max(time - self.since, 0.0) / APPROACH
        if left <= 0.0:
            return place
        (x, y, z), (vx, vy, vz) = place.arm, place.velocity
        off_x, off_y = self.start[0] - self.end[0], self.start[1] - self.end[1]
        velocity = (vx - off_x / APPROACH, vy - off_y / APPROACH, vz)
        return place._replace(arm=(x + left * off_x, y + left * off_y, z), velocity=velocity)


class TipCarry:
    """Carries the readings of MRU and encoder to the boom tip; without a pose all stays as it is.

    Parameters
    ----------
    parameters : of the crane
    mru : what is known of the MRU: its high-pass
    winch : delay and lag with which it follows the crane's lift
    tick_period : [s]

    Attributes
    ----------
    pose : of the crane, as watched
    place : of the boom tip now, from its place in the reference pose; None: no pose has come
    """

    def __init__(
        self, parameters: CraneModelParameters, mru: MruModelParameters, winch: WinchModelParameters, tick_period: float
    ) -> None:
        self._is_fitted = parameters.is_fitted
        self._crane = Crane(parameters)
        self.pose = PoseWatch(parameters)
        self.place: TipPlace | None = None
        period = mru.high_pass_period
        self._high_pass = HighPass(period, mru.high_pass_damping, starts_whole=True) if period > 0.0 else None
        self._roll, self._pitch = RecentMotion(), RecentMotion()
        self._level = self._now = 0.0
        self._lift = LiftOrders(winch, tick_period)
        self._room = LiftRoom(parameters, tick_period)
        self._approach = Approach()
        self._is_refused = False

    def carried(self, now: float, delivered: Measurements) -> tuple[Measurements, list[Alarm]]:
        """Return what was `delivered` by `now` [s] as of the boom tip where it is, and what has changed."""
        poses = delivered.crane
        if not poses and not self.pose.has_come:
            return delivered, []
        if not self._is_fitted:
            return delivered, self._refused(poses)
        for pose in poses:
            self.pose.take(now, pose)
        self.pose.tick(now)
        if not self.pose.has_come:
            return delivered, self.pose.news()
        self.place = self._place(now)
        self._now = now
        mru = tuple([self._at_tip(one) for one in delivered.mru])
        winch, scalar = self._without_lift(delivered.winch), dict(delivered.scalar)
        scalar["depth"] = tuple([self._as_if_made_up(one, 0, 1.0) for one in delivered.of("depth")])
        scalar["velocity"] = tuple([self._as_if_made_up(one, 1, -1.0) for one in delivered.of("velocity")])
        return replace(delivered, mru=mru, winch=winch, scalar=scalar), self.pose.news() + self._room.news()

    def take_winch(self, winch: WinchModelParameters) -> None:
        """Have another nominal `winch` follow the lift from now on."""
        self._lift.take_winch(winch)

    def lift_share(self, limits: WinchLimits, mean: float, swing: float) -> LiftShare:
        """Return what the winch is to do for the crane's lift in this tick; called once in each.

        Parameters
        ----------
        limits : active ones of the winch
        mean : mean payout, without that for the lift [m]
        swing : of the drum about it, by compensation [m]
        """
        if self.place is None:
            return NO_LIFT
        rate, bounds = self.place.velocity[2], self._room.bounds(limits, mean, swing)
        share = self._lift.step(self._lifted(self.place), rate, bounds)
        self._room.watch(self._lift.bound, self.left(self._now)[0], rate, bounds, mean)
        return share

    @property
    def lift_speed(self) -> float:
        """Speed that the winch is ordered for the crane's lift [m/s]; 0 without a pose."""
        return 0.0 if self.place is None else self._lift.speed

    def left(self, time: float) -> tuple[float, float]:
        """Return the lift that the winch has not made up for at a `time` [s] near now, and its rate [m], [m/s]."""
        if self.place is None:
            return 0.0, 0.0
        rate = self.place.velocity[2]
        made, made_rate = self._lift.made(self._now - time)
        return self._lifted(self.place) + rate * (time - self._now) - made, rate - made_rate

    def _lifted(self, place: TipPlace) -> float:
        """Return how much the crane has lifted the tip to a `place` since the first pose [m]."""
        return place.arm[2] - self._level

    def _without_lift(self, winch: WinchReading | None) -> WinchReading | None:
        """Return the state of the `winch` without what it has paid out for the crane's lift."""
        if winch is None or not math.isfinite(winch.time):
            return winch
        made, rate = self._lift.made(self._now - winch.time)
        return winch._replace(
            encoder_payout=winch.encoder_payout - made, encoder_payout_rate=winch.encoder_payout_rate - rate
        )

    def _as_if_made_up(self, reading: ScalarReading, derivative: int, sign: float) -> ScalarReading:
        """Return a `reading` of the unit as if the winch had made up for all of the lift.

        Parameters
        ----------
        reading : of the unit's place, or of its velocity
        derivative : 0 for a place, 1 for a velocity
        sign : of the reading where the unit goes with the boom: 1 where that takes from it
        """
        if not math.isfinite(reading.time):
            return reading
        return reading._replace(value=reading.value + sign * self.left(reading.time)[derivative])

    def _refused(self, poses: tuple[CranePose, ...]) -> list[Alarm]:
        """Return the alarm of `poses` that come for a crane without lengths, once."""
        is_new, self._is_refused = bool(poses) and not self._is_refused, True
        return [ALARMS.alarm("CRANE_LENGTHS_MISSING")] if is_new else []

    def _place(self, time: float) -> TipPlace:
        """Return where the boom tip is taken to be at a `time` [s], on the way to where the pose says it is."""
        place = self._crane.tip(*self.pose.at(time))
        if self.place is None:
            self._level = place.arm[2]
        elif self.pose.breaks != self._approach.breaks:
            self._approach = Approach(self.pose.breaks, time, self.place.arm, place.arm)
            self._level += place.arm[2] - self.place.arm[2]
        return self._approach.on_the_way(time, place)

    def _at_tip(self, reading: MruReading) -> MruReading:
        """Return a `reading` of the MRU at the boom tip; one that is not whole stays as it is, for the gates."""
        time, roll, pitch = reading.time, reading.roll, reading.pitch
        if not math.isfinite(time + roll + pitch):
            return reading
        place = self._place(time)
        arm, velocity = place.arm, place.velocity
        self._roll.add(time, roll)
        self._pitch.add(time, pitch)
        motions = self._roll.at(time), self._pitch.at(time)
        turning = tuple([0.0 if motion is None else motion[1] for motion in motions])
        height = height_of(arm, roll, pitch) - arm[2]
        rate = height_rate_of(arm, roll, pitch, turning) + height_of(velocity, roll, pitch) - velocity[2]
        if self._high_pass is not None:
            height = self._high_pass.add(time, height)
            rate -= self._high_pass.rate_taken_off
        return reading._replace(
            heave=reading.heave + height, heave_rate=reading.heave_rate + rate, heave_acceleration=math.nan
        )
