"""Whether the pose of the crane can be used, and where its joints are at any time: gates, and holding.

A pose that is not finite, has a bad stamp, or has moved faster than the crane can is rejected. Without a usable one the
joints go on at their last rates until the pose is stale, and are then held: a crane that stands still is where it was,
while the reference pose may be tens of metres away. A stated rate is held against how far its joint moves: one that
is frozen says the rate that it had, and rates of another sign or unit would have the winch follow a lift that is not.
"""

from __future__ import annotations

import math
from collections import deque
from pathlib import Path

from heave_node.crane.kinematics import JOINTS, STILL
from heave_node.crane.pose import CranePose, moved
from heave_node.interface.alarm import Alarm, read_alarms
from winch_controller_node.parameters.model import CONFIRMED_AFTER, CraneModelParameters

ALARMS = read_alarms(Path(__file__).with_name("alarms.yaml"))
"""Alarms of a crane that moves."""

STAMP_TOLERANCE = 0.1
"""A pose may be stamped so much ahead of the clock [s]."""

TOLERANCE = (0.02, 0.02, 0.02, 0.2)
"""A joint may be read so far from where it can have moved [rad], [m]: play and steps of an encoder."""

WELL_AFTER = 1.0
"""Time of usable readings after which the pose is good again after a fault [s]."""

RATE_MEMORY = 5.0
"""Time in which a joint's lag behind its stated rate fades from memory [s]: some samples of a slow encoder."""

RATE_SPAN = 0.5
"""Time over which rates that are not measured are taken [s]."""

Joints = tuple[float, ...]
"""One number for each of JOINTS."""


class PoseWatch:
    """Keeps the pose of the crane.

    Parameters
    ----------
    parameters : of the crane

    Attributes
    ----------
    fault : code of the alarm that lasts; empty where the pose is well, or none has come
    has_come : a usable pose has come since the start
    breaks : how often a usable pose has come elsewhere, after a hold or a jump, so far
    """

    def __init__(self, parameters: CraneModelParameters) -> None:
        self._parameters = parameters
        self._measured = tuple(joint in parameters.joints for joint in JOINTS)
        self._largest = parameters.largest_rates
        self.fault = ""
        self.has_come = False
        self._recent: deque[tuple[float, Joints]] = deque(maxlen=64)
        self._candidate: tuple[float, Joints] | None = None
        self._candidate_since = 0.0
        self._rates: Joints = STILL
        self._stated: Joints = STILL
        self._behind: Joints = STILL
        self._held: Joints | None = None
        self.breaks = 0
        self._well_since = math.inf
        self._news: list[Alarm] = []

    def news(self) -> list[Alarm]:
        """Return what has changed since the last call."""
        news, self._news = self._news, []
        return news

    def take(self, now: float, pose: CranePose) -> None:
        """Take in a `pose` that has arrived `now` [s]."""
        joints = self._known(pose)
        newest = self._recent[-1][0] if self._recent else -math.inf
        if not all(map(math.isfinite, joints)):
            self._refuse("CRANE_POSE_INVALID", reason="not a number")
        elif not newest < pose.time <= now + STAMP_TOLERANCE:
            self._refuse("CRANE_POSE_INVALID", reason="its stamp is not after the last one, or ahead of the clock")
        elif self._has_jumped(pose.time, joints):
            self._refuse("CRANE_POSE_JUMP", **self._largest_jump(joints))
        else:
            self._accept(now, pose.time, joints, pose.rates)

    def _known(self, pose: CranePose) -> Joints:
        """Return the joints of a `pose`, those that are not measured as in the reference pose.

        An encoder begins again after a turn: the slew is that nearest to the one before.
        """
        given = zip(pose.joints, self._measured, self._parameters.reference, strict=True)
        slew, *others = (joint if is_measured else reference for joint, is_measured, reference in given)
        before = self._recent[-1][1][0] if self._recent else self._parameters.slew
        turns = round((before - slew) / math.tau) if math.isfinite(slew) else 0
        return (slew + turns * math.tau, *others)

    def _has_jumped(self, time: float, joints: Joints) -> bool:
        """Tell whether `joints` read at a `time` [s] cannot be where the crane was, and do not go on from a jump."""
        if not self._recent or self._can_reach(*self._recent[-1], time, joints):
            self._candidate = None
            return False
        before, self._candidate = self._candidate, (time, joints)
        if before is None or not self._can_reach(*before, time, joints):
            self._candidate_since = time
        if time - self._candidate_since < CONFIRMED_AFTER:
            return True
        self._recent.clear()
        return False

    def _can_reach(self, since: float, start: Joints, time: float, end: Joints) -> bool:
        """Tell whether the crane can move from `start` at `since` [s] to `end` at `time` [s].

        Of a longer silence no more counts than that after which a pose is stale.
        """
        elapsed = min(time - since, self._parameters.pose_timeout)
        limits = zip(start, end, self._largest, TOLERANCE, strict=True)
        return all(abs(b - a) <= rate * elapsed + tolerance for a, b, rate, tolerance in limits)

    def _largest_jump(self, joints: Joints) -> dict[str, float | str]:
        """Return which joint has jumped furthest for its rate, and by how much [rad], [m]."""
        changes = [abs(b - a) for a, b in zip(self._recent[-1][1], joints, strict=True)]
        worst = max(range(len(JOINTS)), key=lambda joint: changes[joint] / self._largest[joint])
        return {"joint": JOINTS[worst], "jump": changes[worst], "unit": _unit(worst)}

    def _accept(self, now: float, time: float, joints: Joints, rates: Joints) -> None:
        is_elsewhere = self.has_come and (self._held is not None or not self._recent)
        self._compare(time, joints, rates, goes_on=bool(self._recent) and not is_elsewhere)
        self._recent.append((time, joints))
        while len(self._recent) > 2 and self._recent[1][0] < time - RATE_SPAN:
            self._recent.popleft()
        worst = max(range(len(JOINTS)), key=lambda joint: abs(self._behind[joint]) / TOLERANCE[joint])
        disagrees = abs(self._behind[worst]) > TOLERANCE[worst]
        self._rates = self._rates_now((math.nan,) * len(JOINTS) if disagrees else rates)
        if not self.has_come:
            self.has_come = True
            self._news.append(ALARMS.alarm("CRANE_POSE_USED"))
        self.breaks += is_elsewhere
        self._held = None
        self._well_since = min(self._well_since, now)
        if disagrees:
            self._refuse("CRANE_RATES_DISAGREE", joint=JOINTS[worst], error=abs(self._behind[worst]), unit=_unit(worst))
        if self.fault and now - self._well_since >= WELL_AFTER:
            self.fault = ""
            self._news.append(ALARMS.alarm("CRANE_POSE_RESTORED"))

    def _compare(self, time: float, joints: Joints, stated: Joints, *, goes_on: bool) -> None:
        """Hold how far the `joints` have moved against their `stated` rates, where they go on from the last pose.

        `time` is that of the pose [s].
        """
        before, self._stated = self._stated, stated
        if not goes_on:
            self._behind = STILL
            return
        since, start = self._recent[-1]
        step = time - since
        kept = max(1.0 - step / RATE_MEMORY, 0.0)
        by_rate = [0.5 * step * (a + b) for a, b in zip(before, stated, strict=True)]
        lags = zip(self._behind, by_rate, start, joints, self._measured, TOLERANCE, strict=True)
        self._behind = tuple(
            # what is kept of it is bounded, so that a rate that is right again is soon taken for right
            min(max(kept * behind + expected - (b - a), -2.0 * tolerance), 2.0 * tolerance)
            if is_measured and math.isfinite(expected)
            else 0.0
            for behind, expected, a, b, is_measured, tolerance in lags
        )

    def _rates_now(self, stated: Joints) -> Joints:
        """Return the rates of the newest pose: those `stated`, or where they are not, of the readings before."""
        (before, start), (time, end) = self._recent[0], self._recent[-1]
        span = time - before
        rates = []
        for joint, is_measured in enumerate(self._measured):
            rate = stated[joint] if is_measured else 0.0
            if not math.isfinite(rate):
                rate = (end[joint] - start[joint]) / span if span > 0.0 else 0.0
            largest = self._largest[joint]
            rates.append(min(max(rate, -largest), largest))
        return tuple(rates)

    def _refuse(self, code: str, **values: float | str) -> None:
        self._well_since = math.inf
        if self.fault != code:
            self.fault = code
            self._news.append(ALARMS.alarm(code, **values))

    def tick(self, now: float) -> None:
        """Notice at `now` [s] that no usable pose has come for too long: the last one is held from then on."""
        timeout = self._parameters.pose_timeout
        if not self._recent or self._held is not None or now - self._recent[-1][0] <= timeout + 1e-6:
            return
        self._held = self.at(now)[0]
        self._well_since = math.inf
        if not self.fault:
            self.fault = "CRANE_POSE_STALE"
            self._news.append(ALARMS.alarm(self.fault, age=now - self._recent[-1][0], limit=timeout))

    def at(self, time: float) -> tuple[Joints, Joints]:
        """Return joints and their rates at a `time` [s] near now; the reference pose before the first has come."""
        if self._held is not None:
            return self._held, STILL
        if not self._recent:
            return self._parameters.reference, STILL
        newest, joints = self._recent[-1]
        return moved(joints, self._rates, time - newest), self._rates

    @property
    def words(self) -> str:
        """How it is with the pose."""
        joints = self.at(self._recent[-1][0] if self._recent else 0.0)[0]
        slew, luff, knuckle = (math.degrees(angle) for angle in joints[:3])
        held = f"{self.fault}: " if self.fault else ""
        return f"{held}slew {slew:.1f}, luff {luff:.1f}, knuckle {knuckle:.1f} deg, extension {joints[3]:.2f} m"


def _unit(joint: int) -> str:
    """Return the unit of a `joint` by its number."""
    return "m" if JOINTS[joint] == "extension" else "rad"
