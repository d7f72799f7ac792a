"""The MRU's motion carried to the boom tip of a crane that moves: rigid-body motion, and the crane's own.

The MRU states heave of the boom tip in the crane's reference pose. With the arm r from there to where the tip is now,
in the ship's frame, and R the rotation by pitch and roll,

    z_tip = z_mru + [R r]_z,    z_tip' = z_mru' + [R' r]_z + [R r']_z

([omega x r]_z is the second term, the crane's own motion the third.) Rates of roll and pitch are those of the last
0.6 s of the MRU's attitude. Height is counted from the first pose, as heave is about its mean. A pose that comes back
elsewhere after a hold is approached in 10 s, and height is counted from it again: the unit is not moved by it. What is
added passes the MRU's own high-pass, where it has one: the estimator knows it to be in what is read.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

from heave_node.crane.kinematics import Crane, TipPlace, Vector
from heave_node.crane.pose import CranePose
from heave_node.devices.live.recent_motion import RecentMotion
from heave_node.interface.alarm import Alarm
from heave_node.interface.sensors import MruReading
from heave_node.numerics.kinematics import height_of, height_rate_of

from winch_controller_node.crane.pose_watch import PoseWatch
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.interface.readings import Measurements
from winch_controller_node.interface.sensors import MruModelParameters
from winch_controller_node.parameters.crane import CraneModelParameters

APPROACH = 10.0
"""Time in which a pose that has come back elsewhere is approached [s]."""

LONGEST_STEP = 1.0
"""After a longer gap between readings the high-pass starts again [s]."""


class AddedHighPass:
    """What the MRU's high-pass takes off a motion: e'' + 2 zeta w e' + w^2 e = 2 zeta w x' + w^2 x, by trapezoids.

    Parameters
    ----------
    period : 2 pi / w [s]; 0: there is none
    damping : zeta
    """

    def __init__(self, period: float, damping: float) -> None:
        frequency = 2.0 * math.pi / period if period > 0.0 else 0.0
        self._stiffness, self._damping = frequency**2, 2.0 * damping * frequency
        self._last = -math.inf
        self._off = self._off_rate = self._left = self._left_rate = 0.0

    def passed(self, time: float, value: float, rate: float) -> tuple[float, float]:
        """Return a motion `value` [m] and its `rate` [m/s] at a `time` [s] as the high-pass lets them through."""
        if self._stiffness == 0.0:
            return value, rate
        step = time - self._last
        if not 0.0 < step <= LONGEST_STEP:
            self._off, self._off_rate = 0.0, 0.0
        else:
            # with z = x - e the right side less the left is e'' = d z' + k z, implicit in the new e and e'
            half, d, k = 0.5 * step, self._damping, self._stiffness
            before = d * self._left_rate + k * self._left
            known = self._off_rate + half * (before + d * rate + k * (value - self._off - half * self._off_rate))
            off_rate = known / (1.0 + half * d + half * half * k)
            self._off += half * (self._off_rate + off_rate)
            self._off_rate = off_rate
        self._last, self._left, self._left_rate = time, value - self._off, rate - self._off_rate
        return self._left, self._left_rate


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
    """Carries the readings of an MRU to the boom tip; without a pose they stay as they are.

    Parameters
    ----------
    parameters : of the crane
    mru : what is known of the MRU: its high-pass

    Attributes
    ----------
    pose : of the crane, as watched
    place : of the boom tip at the newest reading, from its place in the reference pose; None: no pose has come
    """

    def __init__(self, parameters: CraneModelParameters, mru: MruModelParameters) -> None:
        self._is_fitted = parameters.is_fitted
        self._crane = Crane(parameters)
        self.pose = PoseWatch(parameters)
        self.place: TipPlace | None = None
        self._high_pass = AddedHighPass(mru.high_pass_period, mru.high_pass_damping)
        self._roll, self._pitch = RecentMotion(), RecentMotion()
        self._level = math.nan
        self._approach = Approach()
        self._is_refused = False

    def carried(self, now: float, delivered: Measurements) -> tuple[Measurements, list[Alarm]]:
        """Return what was `delivered` by `now` [s] with the MRU's readings at the boom tip, and what has changed."""
        poses = delivered.crane
        if not poses and not self.pose.has_come:
            return delivered, []
        if not self._is_fitted:
            return delivered, self._refused(poses)
        for pose in poses:
            self.pose.take(now, pose)
        self.pose.tick(now)
        if not self.pose.has_come or not delivered.mru:
            return delivered, self.pose.news()
        return replace(delivered, mru=tuple([self._at_tip(one) for one in delivered.mru])), self.pose.news()

    def _refused(self, poses: tuple[CranePose, ...]) -> list[Alarm]:
        """Return the alarm of `poses` that come for a crane without lengths, once."""
        is_new, self._is_refused = bool(poses) and not self._is_refused, True
        return [ALARMS.alarm("CRANE_LENGTHS_MISSING")] if is_new else []

    def _place(self, time: float) -> TipPlace:
        """Return where the boom tip is taken to be at a `time` [s], on the way to where the pose says it is."""
        place = self._crane.tip(*self.pose.at(time))
        if self.place is not None and self.pose.breaks != self._approach.breaks:
            self._approach = Approach(self.pose.breaks, time, self.place.arm, place.arm)
            self._level += place.arm[2] - self.place.arm[2]
        return self._approach.on_the_way(time, place)

    def _at_tip(self, reading: MruReading) -> MruReading:
        """Return a `reading` of the MRU at the boom tip; one that is not whole stays as it is, for the gates."""
        time, roll, pitch = reading.time, reading.roll, reading.pitch
        if not math.isfinite(time + roll + pitch):
            return reading
        self.place = place = self._place(time)
        self._roll.add(time, roll)
        self._pitch.add(time, pitch)
        motions = self._roll.at(time), self._pitch.at(time)
        turning = tuple([0.0 if motion is None else motion[1] for motion in motions])
        height = height_of(place.arm, roll, pitch)
        if math.isnan(self._level):
            self._level = height
        rate = height_rate_of(place.arm, roll, pitch, turning) + height_of(place.velocity, roll, pitch)
        added, added_rate = self._high_pass.passed(time, height - self._level, rate)
        return reading._replace(
            heave=reading.heave + added, heave_rate=reading.heave_rate + added_rate, heave_acceleration=math.nan
        )
