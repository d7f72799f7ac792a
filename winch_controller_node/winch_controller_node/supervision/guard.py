"""Never worse than off: compensation is faded out when it does harm, as estimates and the depth sensor show live.

Over some waves the standard deviation of the compensated unit is compared with that of the uncompensated one:
compensation must be better than none. An unstable loop pumps energy into a unit that then swings for minutes, so that
the guard must not wait for waves. Over seconds it checks

- the speed of the drum, as far as the law does not intend it, against that of the boom tip: an unstable loop shows
  there first, long before the heavy unit has answered;
- the swing of the unit, z^2 + a z'^2, against that of the uncompensated one;
- the heave that the depth sensor reads, against the uncompensated one;
- the depth sensor against the estimate: where they disagree (a motion reference unit of the wrong sign), the estimate
  is not to be trusted, and compensation stays off until they agree again.

Compensation that does harm is faded out. After a hold time, which becomes longer each time, it is tried again once the
sea asks for no more than the winch can give.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

from heave_node.interface.alarm import Alarm

from winch_controller_node.estimation.loop_tick import Motion
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.laws.parts.effort import Effort
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.parameters.laws import GuardParameters
from winch_controller_node.supervision.checks import AmplitudeCheck, AmplitudeLimit, DetrendedHeave, RunningSigma
from winch_controller_node.supervision.watch.winch_demand import WinchDemand

FULL_SHARE = 0.95
"""Share of the wanted authority from which on compensation is judged over waves."""

RATE_ERROR = AmplitudeLimit(time=2.0, ratio=1.5, floor=0.1)
"""Speed of the drum that is not intended, against that of the boom tip [m/s]."""

CATCH_UP_TIME = 15.0
"""Time that the drum is not checked after a lost sensor is back [s]: the law has to catch up with what it missed."""

LEFT_OVER_TIME = 30.0
"""Time in which compensation has to take out a swing that it has found [s]: that of a sudden stop, or one not seen."""

LARGEST_LEFT_OVER = 2.0
"""Largest swing that compensation may find, over the uncompensated one."""

CORRECTIONS_TIME, CORRECTIONS_REST = 20.0, 300.0
"""Time within which a belief is corrected again and again [s], and time from its beginning to the next such."""

CAUSE_TIME, KNOWN_HOLD = 20.0, 5.0
"""Harm whose cause is known and corrected within the first time [s] keeps compensation off for the second [s] only."""

RESTART = 0.1
"""Rest of the last allowance at which a swing that waves have left is allowed again."""

BEYOND = 0.02
"""A sea is beyond the winch's limits where so much of the largest speed is missing."""

OUT_OF_REACH = 2.0
"""Allowed error of the drum's speed at its limits, over that of a drum that follows the intended speed within them."""

SWING_WORK = 2.0
"""Speed of the drum that stops a swinging unit, over the speed of the unit."""

SWING_TIME, SWING_RATIO = 3.0, 1.2
"""Swing of the unit against the uncompensated one: memory [s] and ratio."""

DEPTH_TIME, DEPTH_RATIO = 6.0, 1.3
"""Heave that the depth sensor reads against the uncompensated one: memory [s] and ratio."""

MISMATCH_TIME, MISMATCH_RATIO = 8.0, 0.8
"""Depth sensor less estimate, against the uncompensated heave: memory [s] and ratio."""

LEAST_AUTHORITY = 0.5
"""The drum is checked against this share of the boom tip's speed at least."""

FLOOR_FACTOR = 10.0
"""The checks over seconds ignore heave below so many times `guard.floor`: that is left to the comparison over waves."""

LARGEST_DEMAND = 1.4
"""Demand of the sea's share over the winch that a law is given which keeps the limits by itself."""

HOLD_GROWTH = 4.0
"""The hold time grows by this factor each time: what all tries do together stays little."""


@dataclass(frozen=True)
class GuardedLoop:
    """What the guard must know of the loop it watches.

    Attributes
    ----------
    limits : of the winch
    effort : of the law
    inertia : a of the two-state cable [s^2]; 0: unknown
    feeds_back_unit : the law feeds the unit's motion back, so that the loop can become unstable
    fade_time : shortest time over which authority goes from 0 to 1 or back [s]
    """

    limits: WinchLimits
    effort: Effort = field(default_factory=Effort)
    inertia: float = 0.0
    feeds_back_unit: bool = True
    fade_time: float = 10.0


class GuardedMotions(NamedTuple):
    """What the guard compares at a tick, all about the mean depth.

    Attributes
    ----------
    unit : estimated motion of the unit, compensated
    free_unit : the same with the winch locked
    boom_tip : estimated motion of the boom tip
    payout_rate : estimated speed of the drum, without that of the mean payout [m/s]
    measured_heave : heave of the unit as the depth sensor reads it [m]; None: no reading came
    depth_noise : standard deviation of that sensor's noise, as far as it is known [m]
    mean_acceleration : of the mean payout [m/s^2]
    """

    unit: Motion
    free_unit: Motion
    boom_tip: Motion
    payout_rate: float = 0.0
    measured_heave: float | None = None
    depth_noise: float = 0.0
    mean_acceleration: float = 0.0


class HarmGuard:
    """Says when compensation is to be off, and when it may be tried again.

    Parameters
    ----------
    parameters : window, ratio, hold times
    loop : that it watches
    tick_period : [s]

    Attributes
    ----------
    inhibits : compensation is to be off
    trusts_estimate : the depth sensor agrees with the estimate
    alarm : why it inhibits; None when it does not
    """

    def __init__(self, parameters: GuardParameters, loop: GuardedLoop, *, tick_period: float) -> None:
        self._parameters = parameters
        self._loop = loop
        self._dt = tick_period
        self.inhibits = False
        self.trusts_estimate = True
        self.alarm: Alarm | None = None
        self._is_unexplained = False
        self._hold_time = parameters.hold_time
        self._hold: float | None = None
        self._off_time = 0.0
        self._judged_time = 0.0
        self._authority_before = 0.0
        self.forget_sea()

    def forget_sea(self) -> None:
        """Begin to compare anew: what was seen until now was another sea."""
        self._demand = WinchDemand(self._parameters.window, tick_period=self._dt)
        self._make_comparison()
        self._make_checks()

    def _make_comparison(self) -> None:
        """Begin the comparison over waves anew."""
        self._unit = RunningSigma(self._parameters.window, self._dt)
        self._free_unit = RunningSigma(self._parameters.window, self._dt)

    def _make_checks(self) -> None:
        window, floor = self._parameters.window, FLOOR_FACTOR * self._parameters.floor
        self._rate_check = AmplitudeCheck(RATE_ERROR, window, self._dt)
        self._swing_check = AmplitudeCheck(AmplitudeLimit(SWING_TIME, SWING_RATIO, floor), window, self._dt)
        self._depth_check = AmplitudeCheck(AmplitudeLimit(DEPTH_TIME, DEPTH_RATIO, floor), window, self._dt)
        self._mismatch_check = AmplitudeCheck(AmplitudeLimit(MISMATCH_TIME, MISMATCH_RATIO, floor), window, self._dt)
        self._measured = DetrendedHeave(self._dt)
        self._mismatch = DetrendedHeave(self._dt)
        self._exchanged_swing = self._reachable = self._to_gain_speed = 0.0
        self._catch_up = 0.0
        self._left_over = 0.0
        self._is_corrected = self._is_out_of_reach = False
        self._corrected_first: dict[str, float] = {}
        self._time = self._began = self._excused = 0.0

    @property
    def demand(self) -> float:
        """What the sea asks of the winch over its limits: significant amplitude of speed or acceleration [-]."""
        return self._demand.significant(self._loop.limits)

    def authority_limit(self, *, keeps_limits: bool) -> float:
        """Return the largest authority by the sea seen now.

        It keeps a law off the winch's limits, or where it `keeps_limits` by itself, off a sea that asks for much more
        than the winch can give.
        """
        if keeps_limits:
            demand = self._demand.coming(self._loop.limits)
            return min(1.0, LARGEST_DEMAND / demand) if demand > 0.0 else 1.0
        return self._demand.largest_share(self._loop.limits, self._loop.effort, self._parameters.limit_use)

    @property
    def reason(self) -> str:
        """Why it inhibits, in words; empty when it does not."""
        return "" if self.alarm is None else self.alarm.brief

    @property
    def prospect(self) -> str:
        """When compensation is tried again, in words; empty where it is not inhibited."""
        if not self.inhibits:
            return ""
        hold = self._hold_time if self._hold is None else self._hold
        if self._off_time < hold:
            # one wording, whether the reason is there in this tick or not: it may come and go
            return (
                f"next attempt {hold:.0f} s after the cause has gone, in {hold - self._off_time:.0f} s at the earliest"
            )
        most = self._parameters.demand_ratio
        return f"next attempt when the sea demands at most {most:g} times the winch's limits; now {self.demand:.1f}"

    def take_loop(self, loop: GuardedLoop) -> None:
        """Watch another loop from now on: another design is in force."""
        self._loop = loop

    def allow_catch_up(self) -> None:
        """Do not check the drum for some seconds: the law has to catch up with what it could not see."""
        self._catch_up = CATCH_UP_TIME

    def allow_resumption(self) -> None:
        """Do not hold against the loop how drum and unit moved while a sensor was lost."""
        self.allow_catch_up()
        self._is_corrected = True
        self._excused = LEFT_OVER_TIME
        self._judged_time = 0.0
        self._make_comparison()

    def allow_correction(self, belief: str) -> None:
        """Do not hold against the loop what a wrong belief has done: it has just been corrected.

        What is corrected again and again is not known, and the loop is judged by what it does.

        Parameters
        ----------
        belief : what it is about, as "winch"
        """
        if self.inhibits and self._hold is None and self._time - self._began < CAUSE_TIME:
            self._hold = KNOWN_HOLD
        if self.inhibits and self._is_unexplained:
            self.alarm, self._is_unexplained = ALARMS.alarm("DEPTH_MRU_EXPLAINED", part=belief), False
        since = self._time - self._corrected_first.get(belief, -math.inf)
        if since > CORRECTIONS_REST:
            self._corrected_first[belief] = self._time
        elif since > CORRECTIONS_TIME:
            return
        self.allow_resumption()
        self.trusts_estimate = True
        self._mismatch_check.restart()
        self._mismatch = DetrendedHeave(self._dt)

    def inhibit(self, reason: Alarm, hold: float | None = None) -> None:
        """Keep compensation off while there is a `reason` that is certain, and for a time after it.

        Parameters
        ----------
        reason : why
        hold : time after it [s]; None: the hold time of harm, which becomes longer each time
        """
        self._off_time = 0.0
        if not self.inhibits or self._is_unexplained:
            self._begin_inhibiting(reason, hold)

    def update(self, motions: GuardedMotions, authority: float, target: float = 1.0) -> None:
        """Take one tick in.

        Parameters
        ----------
        motions : of the tick
        authority : share of the sea that is compensated now
        target : share it goes to; compensation is judged over waves when that is (nearly) reached
        """
        self._demand.add(motions.boom_tip.rate)
        self._time += self._dt
        self._excused = max(self._excused - self._dt, 0.0)
        self._update_checks(motions, authority)
        if self._mismatch_check.is_exceeded:
            self.trusts_estimate = False
            self._disagree(ALARMS.alarm("DEPTH_MRU_DISAGREE", error=self._mismatch_check.amplitude))
        if self.inhibits:
            self._wait(authority)
        elif authority <= 0.0:
            self._judged_time = 0.0
            self._make_comparison()
        else:
            self._judge_checks()
            may_compare = self._excused == 0.0 and authority >= FULL_SHARE * target
            if not self.inhibits and may_compare:
                self._compare(motions, authority)

    def _disagree(self, reason: Alarm) -> None:
        """Keep compensation off for a disagreement, which is the `reason` until it is known who is wrong."""
        self._off_time = 0.0
        if not self.inhibits:
            self._begin_inhibiting(reason)
            self._is_unexplained = True

    # over seconds

    def _update_checks(self, motions: GuardedMotions, authority: float) -> None:
        """Take the motions of a tick into the checks over seconds."""
        change = authority - self._authority_before
        self._authority_before = authority
        swing, free_swing = self._swing(motions.unit), self._swing(motions.free_unit)
        self._check_rate(motions, authority, change, swing, free_swing)
        self._swing_check.add(swing, free_swing)
        self._update_left_over(motions, authority)
        # the mean square of a heave is half that of its swing
        free_heave = 0.5 * free_swing
        heave, noise = motions.measured_heave, motions.depth_noise
        self._depth_check.take_off(noise)
        self._mismatch_check.take_off(noise)
        self._measured.add(heave, noise)
        self._depth_check.add(self._measured.value**2, free_heave)
        self._mismatch.add(None if heave is None else heave - motions.unit.heave, noise)
        self._mismatch_check.add(self._mismatch.value**2, free_heave)
        if authority <= 0.0:
            self._rate_check.restart()
            self._swing_check.restart(self._swing_check.reference)
            self._depth_check.restart()

    def _update_left_over(self, motions: GuardedMotions, authority: float) -> None:
        """Do not hold against the loop the swing that it has found.

        While the winch stands, the unit less the uncompensated one is a free swing, and would go on for long: whoever
        stops the winch suddenly sets it going. So does a wrong belief that has been corrected, and a wave that is
        beyond the winch's limits: of a compensated unit all of its motion is that.
        """
        unit, free = motions.unit, motions.free_unit
        if authority <= 0.0:
            unit = Motion(unit.heave - free.heave, unit.rate - free.rate)
        found = min(math.sqrt(self._swing(unit)), LARGEST_LEFT_OVER * math.sqrt(self._swing_check.reference))
        if authority <= 0.0 or self._is_corrected:
            self._left_over = found
        else:
            self._left_over *= 1.0 - self._dt / LEFT_OVER_TIME
            if self._is_out_of_reach and self._left_over < RESTART * found:
                self._left_over = found  # once: what keeps growing is no swing that a wave has left
        self._is_corrected = False
        self._swing_check.allow(self._left_over)
        self._depth_check.allow(math.sqrt(0.5) * self._left_over)

    def _swing(self, motion: Motion) -> float:
        """Return z^2 + a z'^2 [m^2]: the squared amplitude of a unit that swings by itself."""
        return motion.heave**2 + self._loop.inertia * motion.rate**2

    def _check_rate(
        self, motions: GuardedMotions, authority: float, change: float, swing: float, free_swing: float
    ) -> None:
        """Compare the speed of the drum that is not intended with that of the boom tip, and what stopping a swing asks.

        While authority A moves, the unit goes over to (1 - A) of its uncompensated motion: by thesis Eq. 6.2 that asks
        for payout = A tip + 2 a A' z_off' (b and A'' left out), with a z_off'' = tip - z_off.
        """
        loop, tip = self._loop, motions.boom_tip
        largest = self._dt / loop.fade_time
        authority_rate = min(max(change, -largest), largest) / self._dt
        intended = authority * tip.rate + authority_rate * (3.0 * tip.heave - 2.0 * motions.free_unit.heave)
        error = motions.payout_rate - intended
        allowed = (1.0 + loop.effort.rate_error) * max(authority, LEAST_AUTHORITY) * tip.rate
        # a law has to stop a unit that swings, and while authority moves to take it out of its uncompensated swing;
        # where that is large, as at a resonance, the drum does no harm before it is as fast
        is_moving = change != 0.0
        self._exchanged_swing = free_swing if is_moving else self._exchanged_swing * (1.0 - self._dt / SWING_TIME)
        to_stop = SWING_WORK**2 * (swing + self._exchanged_swing) + free_swing
        work = to_stop / loop.inertia if loop.inertia > 0.0 else 0.0
        self._follow_mean(motions.mean_acceleration)
        out_of_reach = intended - self._follow_within_limits(intended)
        self._is_out_of_reach = abs(out_of_reach) > BEYOND * loop.limits.speed
        self._rate_check.add(error**2, allowed**2 + work + self._to_gain_speed**2 + (OUT_OF_REACH * out_of_reach) ** 2)
        self._catch_up = max(self._catch_up - self._dt, 0.0)
        if self._catch_up > 0.0:
            self._rate_check.restart()

    def _follow_mean(self, acceleration: float) -> None:
        """Notice what speed of the drum an `acceleration` of the mean payout asks for [m/s^2].

        The unit gains speed with it once its cable is longer by a times the acceleration, on a soft cable by metres.
        The law pays that out within the memory of the check, and hauls it in while the unit comes along.
        """
        inertia = self._loop.inertia
        fading = self._dt / max(math.sqrt(inertia), self._dt)
        asked = inertia * abs(acceleration) / RATE_ERROR.time
        self._to_gain_speed = max(asked, (1.0 - fading) * self._to_gain_speed)

    def _follow_within_limits(self, intended: float) -> float:
        """Return the speed of a drum that follows an `intended` one within the winch's limits [m/s]."""
        limits = self._loop.limits
        largest = limits.acceleration * self._dt
        reached = self._reachable + min(max(intended - self._reachable, -largest), largest)
        self._reachable = min(max(reached, -limits.speed), limits.speed)
        return self._reachable

    def _judge_checks(self) -> None:
        feeds_back_unit = self._loop.feeds_back_unit
        if self._depth_check.is_exceeded:
            self.trusts_estimate = False
            self._begin_inhibiting(ALARMS.alarm("UNIT_HEAVE_HIGH", heave=self._depth_check.amplitude))
        elif feeds_back_unit and self._swing_check.is_exceeded:
            self._begin_inhibiting(ALARMS.alarm("UNIT_SWING_HIGH", swing=self._swing_check.amplitude))
        elif feeds_back_unit and self._rate_check.is_exceeded:
            self._begin_inhibiting(ALARMS.alarm("DRUM_SPEED_OFF", error=self._rate_check.amplitude))

    # over waves

    def _compare(self, motions: GuardedMotions, authority: float) -> None:
        """Compare the standard deviations of the compensated and the uncompensated unit.

        Of a share of the sea, `authority`, no more can be asked than that share of what the whole has to gain.
        """
        self._unit.add(motions.unit.heave)
        self._free_unit.add(motions.free_unit.heave)
        self._judged_time += self._dt
        parameters = self._parameters
        if self._judged_time < 0.5 * parameters.window:
            return
        sigma, free_sigma = self._unit.sigma, self._free_unit.sigma
        least = authority * (1.0 - parameters.harm_ratio)
        if sigma > parameters.floor and sigma > (1.0 - least) * free_sigma:
            self._begin_inhibiting(
                ALARMS.alarm("WORSE_THAN_OFF", sigma=sigma, free=free_sigma)
                if sigma > free_sigma
                else ALARMS.alarm("LITTLE_GAIN", sigma=sigma, free=free_sigma, percent=100.0 * least)
            )
        elif self._judged_time > 4.0 * self._hold_time:
            self._hold_time = parameters.hold_time

    # while it inhibits

    def _begin_inhibiting(self, reason: Alarm, hold: float | None = None) -> None:
        self.inhibits, self._began = True, self._time
        self._is_unexplained = False
        self._hold = hold
        self._off_time = 0.0
        self.alarm = reason

    def _wait(self, authority: float) -> None:
        """Count the time off, and let compensation be tried again."""
        if authority > 0.0:
            return
        self._off_time += self._dt
        hold = self._hold_time if self._hold is None else self._hold
        if self._off_time >= hold and self.demand <= self._parameters.demand_ratio:
            self.inhibits = False
            self.trusts_estimate = True
            self.alarm = None
            if self._hold is None:
                self._hold_time = min(HOLD_GROWTH * self._hold_time, self._parameters.hold_time_limit)
            self._judged_time = 0.0
            self._make_comparison()
