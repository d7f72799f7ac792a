"""Never worse than off: compensation is faded out when it does harm, as estimates and the depth sensor show live.

Over some waves the standard deviation of the compensated unit is compared with that of the uncompensated one:
compensation must be better than none. An unstable loop pumps energy into a unit that then swings for minutes, so that
the guard must not wait for waves. Over seconds it checks

- the speed of the drum, as far as the law does not intend it, against that of the boom tip: an unstable loop shows
  there first, long before the heavy unit has answered;
- the swing of the unit, z^2 + a z'^2, against that of the uncompensated one;
- the heave that the depth sensor reads, against the uncompensated one;
- the depth sensor against the estimate: where they disagree (a motion reference unit with a sign error), the estimate
  is not to be trusted, and compensation stays off until they agree again.

Compensation that does harm is faded out. After a hold time, which becomes longer each time, it is tried again once the
sea asks for no more than the winch can give.
"""

from __future__ import annotations

import math

from heave_node.interface.alarm import Alarm

from winch_controller_node.core.supervision.checks import Countdown, RunningSigma
from winch_controller_node.core.supervision.guard_checks import (
    FLOOR_FACTOR,
    LEFT_OVER_TIME,
    DrumCheck,
    GuardedLoop,
    GuardedMotions,
    Swings,
    UnitCheck,
)
from winch_controller_node.core.supervision.guard_hold import HarmHold
from winch_controller_node.core.supervision.watch.winch_demand import WinchDemand
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.parameters.laws import GuardParameters

FULL_SHARE = 0.95
"""Share of the wanted authority from which on compensation is judged over waves."""

CORRECTIONS_TIME, CORRECTIONS_REST = 20.0, 300.0
"""Time within which a belief is corrected again and again [s], and time from its beginning to the next such."""

LARGEST_DEMAND = 1.4
"""Demand of the sea's share over the winch that a law is given which keeps the limits by itself."""


class WaveComparison:
    """Compares the standard deviations of the compensated and the uncompensated unit over waves.

    Parameters
    ----------
    parameters : window, ratio, floor
    tick_period : [s]

    Attributes
    ----------
    time : compared so far [s]
    """

    def __init__(self, parameters: GuardParameters, tick_period: float) -> None:
        self._parameters = parameters
        self._dt = tick_period
        self.restart()

    def restart(self) -> None:
        """Restart."""
        self._unit, self._free_unit = (RunningSigma(self._parameters.window, self._dt) for _ in range(2))
        self.time = 0.0

    def harm(self, motions: GuardedMotions, authority: float) -> Alarm | None:
        """Take in the `motions` of a tick; return what harm there is; None: there is none.

        Under `authority` no more can be asked than that share of what the whole has to gain.
        """
        self._unit.add(motions.unit.heave)
        self._free_unit.add(motions.free_unit.heave)
        self.time += self._dt
        if self.time < 0.5 * self._parameters.window:
            return None
        sigma, free_sigma = self._unit.sigma, self._free_unit.sigma
        least = authority * (1.0 - self._parameters.harm_ratio)
        if sigma <= self._parameters.floor or sigma <= (1.0 - least) * free_sigma:
            return None
        if sigma > free_sigma:
            return ALARMS.alarm("WORSE_THAN_OFF", sigma=sigma, free=free_sigma)
        return ALARMS.alarm("LITTLE_GAIN", sigma=sigma, free=free_sigma, percent=100.0 * least)


class HarmGuard:
    """Says when compensation is to be off, and when it may be tried again.

    Parameters
    ----------
    parameters : window, ratio, hold times
    loop : that it watches
    tick_period : [s]

    Attributes
    ----------
    trusts_estimate : the depth sensor agrees with the estimate
    """

    def __init__(self, parameters: GuardParameters, loop: GuardedLoop, *, tick_period: float) -> None:
        self._parameters = parameters
        self._loop = loop
        self._dt = tick_period
        self._hold = HarmHold(parameters, tick_period)
        self.trusts_estimate = True
        self._authority_before = 0.0
        self.reset_sea()

    def reset_sea(self) -> None:
        """Restart the comparison: what was seen until now was another sea."""
        window = self._parameters.window
        self._demand = WinchDemand(window, tick_period=self._dt)
        self._waves = WaveComparison(self._parameters, self._dt)
        self._drum = DrumCheck(window, self._dt)
        self._unit = UnitCheck(window, FLOOR_FACTOR * self._parameters.floor, self._dt)
        self._allowance = Countdown(self._dt)
        self._corrected_first: dict[str, float] = {}
        self._time = 0.0

    @property
    def inhibits(self) -> bool:
        """Tell whether compensation is to be off."""
        return self._hold.inhibits

    @property
    def alarm(self) -> Alarm | None:
        """Why it inhibits; None where it does not."""
        return self._hold.alarm

    @property
    def reason(self) -> str:
        """Why it inhibits, in words; empty where it does not."""
        return "" if self.alarm is None else self.alarm.brief

    @property
    def awaits_operator(self) -> bool:
        """Tell whether compensation is off until an operator asks for it."""
        return self._hold.awaits_operator

    def release(self) -> None:
        """Let compensation be tried as at first: an operator asks for it."""
        if self.awaits_operator:
            self.trusts_estimate = True
            self._waves.restart()
        self._hold.release()

    @property
    def prospect(self) -> str:
        """When compensation is tried again, in words; empty where it is not inhibited."""
        return self._hold.prospect(self.demand)

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

    def take_loop(self, loop: GuardedLoop) -> None:
        """Watch another loop from now on: another design is active."""
        self._loop = loop

    def allow_catch_up(self) -> None:
        """Do not check the drum for some seconds: the law has to catch up with what it could not see."""
        self._drum.allow_catch_up()

    def reset_mismatch(self) -> None:
        """Compare depth sensor and estimate again: what was seen until now says nothing of either."""
        self._unit.reset_mismatch()

    def allow_resumption(self) -> None:
        """Do not hold against the loop how drum and unit moved while a sensor was lost."""
        self.allow_catch_up()
        self._unit.allow_left_over()
        self._allowance.start(LEFT_OVER_TIME)
        self._waves.restart()

    def allow_correction(self, belief: str) -> None:
        """Do not hold against the loop what a wrong belief has done: it has just been corrected.

        What is corrected again and again is not known, and the loop is judged by what it does.

        Parameters
        ----------
        belief : what it is about, as "winch"
        """
        self._hold.explain(belief)
        since = self._time - self._corrected_first.get(belief, -math.inf)
        if since > CORRECTIONS_REST:
            self._corrected_first[belief] = self._time
        elif since > CORRECTIONS_TIME:
            return
        self.allow_resumption()
        self.trusts_estimate = True
        self.reset_mismatch()

    def inhibit(self, reason: Alarm, hold: float | None = None) -> None:
        """Keep compensation off while there is a `reason` that is certain, and for a time after it.

        Parameters
        ----------
        reason : why
        hold : time after it [s]; None: the hold time of harm, which becomes longer each time
        """
        self._hold.certain(reason, hold)

    def update(self, motions: GuardedMotions, authority: float, target: float = 1.0) -> None:
        """Take one tick in.

        Parameters
        ----------
        motions : of the tick
        authority : authority of compensation now
        target : share it goes to; compensation is judged over waves when that is (nearly) reached
        """
        self._demand.add(motions.boom_tip.rate)
        self._time += self._dt
        is_allowed = self._allowance.step()
        self._check(motions, authority)
        if self.inhibits:
            self._wait(authority)
        elif authority <= 0.0:
            self._waves.restart()
        elif harm := self._harm_over_seconds():
            self._hold.begin(harm)
        elif not is_allowed and authority >= FULL_SHARE * target:
            if harm := self._waves.harm(motions, authority):
                self._hold.begin(harm)
            else:
                self._hold.is_kept_after(self._waves.time)

    def _check(self, motions: GuardedMotions, authority: float) -> None:
        """Take the motions of a tick into the checks; reject an estimate that the depth sensor contradicts."""
        change, self._authority_before = authority - self._authority_before, authority
        inertia = self._loop.inertia
        swings = Swings.of(motions, inertia)
        self._drum.update(motions, self._loop, authority, change, swings)
        self._unit.update(motions, inertia, authority, swings, is_out_of_reach=self._drum.is_out_of_reach)
        mismatch = self._unit.mismatch
        if mismatch is not None:
            self.trusts_estimate = False
            self._hold.unexplained(ALARMS.alarm("DEPTH_MRU_DISAGREE", error=mismatch))

    def _harm_over_seconds(self) -> Alarm | None:
        """Return what the checks over seconds have found; None: nothing."""
        if harm := self._unit.harm_by_depth:
            self.trusts_estimate = False
            return harm
        if not self._loop.feeds_back_unit:
            return None
        return self._unit.harm_to_swing or self._drum.harm

    def _wait(self, authority: float) -> None:
        """Count the time off, and let compensation be tried again."""
        if self._hold.ends(authority, self.demand):
            self.trusts_estimate = True
            self._waves.restart()
