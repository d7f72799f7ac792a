"""The MRU's motion carried to the boom tip of a crane that moves: rigid-body motion, and the crane's own.

The MRU states heave of the boom tip in the crane's reference pose. With the arm r from there to where the tip is now,
in the ship's frame, and R the rotation by pitch and roll, the tip moves by

    z_tip = z_mru + [R r]_z,    z_tip' = z_mru' + [R' r]_z + [R r']_z

([R' r]_z is that of omega x r). It is taken in two parts. What the ship does to the arm, [R r]_z - r_z, is heave of
the boom tip and is added to the MRU's. The crane's own lift l = r_z is no wave: it moves the place about which the tip
heaves. Readings are made those below that place: a depth sensor reads l deeper, a velocity l' less.

Rates of roll and pitch are those of the last 0.6 s of the MRU's attitude. The lift is counted from the first pose. A
pose that comes back elsewhere after a hold is approached in 10 s, and the lift is counted from it again: the unit is
not moved by it. What the ship adds to heave passes the MRU's own high-pass, where it has one: the estimator knows it to
be in what is read.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from heave_node.crane.kinematics import Crane, TipPlace, Vector
from heave_node.crane.pose import CranePose
from heave_node.interface.sensors import MruReading
from heave_node.numerics.high_pass import HighPass
from heave_node.numerics.kinematics import height_of, height_rate_of
from heave_node.sensing.recent_motion import RecentMotion
from winch_controller_node.interface.readings import Measurements, ScalarReading
from winch_controller_node.interface.sensors import MruModelParameters
from winch_controller_node.parameters.model import CraneModelParameters

from heave_devices.crane.pose_watch import PoseWatch

APPROACH = 10.0
"""Time in which a pose that has come back elsewhere is approached [s]."""


class Approach(NamedTuple):
    """The way in the horizontal to a boom tip that the pose has found elsewhere."""

    breaks: int = 0  # of the pose so far, by which the next one is known
    since: float = -math.inf  # time of the last one [s]
    start: Vector = (0.0, 0.0, 0.0)  # boom tip before it, from its place in the reference pose [m]
    end: Vector = (0.0, 0.0, 0.0)  # boom tip after it

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
    """Carries the readings of the MRU to the boom tip; without a pose all stays as it is.

    Parameters
    ----------
    parameters : of the crane
    mru : what is known of the MRU: its high-pass

    Attributes
    ----------
    pose : of the crane, as watched
    place : of the boom tip now, from its place in the reference pose; None: no pose has come
    """

    def __init__(self, parameters: CraneModelParameters, mru: MruModelParameters) -> None:
        self._crane = Crane(parameters)
        self.pose = PoseWatch(parameters)
        self.place: TipPlace | None = None
        period = mru.high_pass_period
        self._high_pass = HighPass(period, mru.high_pass_damping, starts_whole=True) if period > 0.0 else None
        self._roll, self._pitch = RecentMotion(), RecentMotion()
        self._level = self._now = 0.0
        self._approach = Approach()

    def carried(self, now: float, delivered: Measurements, poses: Sequence[CranePose]) -> Measurements:
        """Return what was `delivered` by `now` [s], with `poses` of the crane, as of the boom tip where it is."""
        for pose in poses:
            self.pose.take(now, pose)
        self.pose.tick(now)
        if not self.pose.has_come:
            return delivered
        self._now, self.place = now, self._place(now)
        mru = tuple([self._at_tip(one) for one in delivered.mru])
        scalar = dict(delivered.scalar)
        scalar["depth"] = tuple([self._below_tip(one, 0, 1.0) for one in delivered.of("depth")])
        scalar["velocity"] = tuple([self._below_tip(one, 1, -1.0) for one in delivered.of("velocity")])
        return replace(delivered, mru=mru, scalar=scalar)

    def lift(self, time: float) -> tuple[float, float]:
        """Return how much the crane has lifted the tip by a `time` [s] near now, and the rate [m], [m/s]."""
        if self.place is None:
            return 0.0, 0.0
        rate = self.place.velocity[2]
        return self.place.arm[2] - self._level + rate * (time - self._now), rate

    def _below_tip(self, reading: ScalarReading, derivative: int, sign: float) -> ScalarReading:
        """Return a `reading` of the unit's depth or velocity as below the place about which the tip heaves.

        The `derivative` is 0 for a depth, 1 for a velocity; the `sign` is 1 where it is positive down, else -1.
        """
        if not math.isfinite(reading.time):
            return reading
        return reading._replace(value=reading.value + sign * self.lift(reading.time)[derivative])

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
