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

What it measures and compares is in C++ (`heave_core`, guard.cpp): a tick sets a bit for each kind of harm. This shell
says what follows, in words. Compensation that does harm is faded out. It is tried again where it is predicted to leave
less motion than the winch locked, with the authority that leaves least; each attempt that failed raises that bar.
"""

from __future__ import annotations

import math

from heave_core.look import Guard, Seen, Verdict
from heave_core.look_table import Harm
from heave_node.interface.alarm import Alarm

from winch_controller_node.core.supervision.attempts import Attempts
from winch_controller_node.core.supervision.guard_checks import GuardedLoop, guard_design
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.parameters.laws import GuardParameters

CORRECTIONS_TIME, CORRECTIONS_REST = 20.0, 300.0
"""Time within which a belief is corrected again and again [s], and time from its beginning to the next such."""


class HarmGuard:
    """Says when compensation is to be off, and when it may be tried again.

    Parameters
    ----------
    parameters : window, ratio, floor
    loop : that it watches
    tick_period : [s]

    Attributes
    ----------
    trusts_estimate : the depth sensor agrees with the estimate
    """

    def __init__(self, parameters: GuardParameters, loop: GuardedLoop, *, tick_period: float) -> None:
        self._parameters = parameters
        self._dt = tick_period
        self._attempts = Attempts(parameters.harm_ratio)
        self.trusts_estimate = True
        self._core = Guard(guard_design(parameters, loop, tick_period))
        self.reset_sea()

    def reset_sea(self) -> None:
        """Restart the comparison: what was seen until now was another sea."""
        self._core.begin()
        self._found = self._core.verdict
        self._corrected_first: dict[str, float] = {}
        self._time = 0.0

    @property
    def inhibits(self) -> bool:
        """Tell whether compensation is to be off."""
        return self._attempts.inhibits

    @property
    def alarm(self) -> Alarm | None:
        """Why it inhibits; None where it does not."""
        return self._attempts.alarm

    @property
    def reason(self) -> str:
        """Why it inhibits, in words; empty where it does not."""
        return "" if self.alarm is None else self.alarm.brief

    @property
    def awaits_operator(self) -> bool:
        """Tell whether compensation is off until an operator asks for it."""
        return self.inhibits and self._attempts.awaits_operator

    def release(self) -> None:
        """Let compensation be tried as at first: an operator asks for it."""
        if self.awaits_operator:
            self.trusts_estimate = True
            self._core.restart_waves()
        self._attempts.release()

    @property
    def prospect(self) -> str:
        """When compensation is tried again, in words; empty where it is not inhibited."""
        return self._attempts.prospect(self._found.residual)

    @property
    def demand(self) -> float:
        """What the sea asks of the winch over its limits: significant amplitude of speed or acceleration [-]."""
        return self._found.demand

    @property
    def tip_sigma(self) -> float:
        """Standard deviation of the boom tip over the last waves [m]."""
        return self._found.tip_sigma

    @property
    def authority_limit(self) -> float:
        """Authority that is predicted to leave the least motion in the sea seen now."""
        return self._found.best_authority

    @property
    def shown_authority(self) -> float:
        """Authority that unit and drum show, as they move."""
        return self._found.shown

    @property
    def residual(self) -> float:
        """Motion that it is predicted to leave, over that with the winch locked."""
        return self._found.residual

    @property
    def largest_residual(self) -> float:
        """Largest of it with which compensation is tried."""
        return self._attempts.bar

    @property
    def is_reduced(self) -> bool:
        """Tell whether errors keep authority below what the winch's limits allow."""
        return self._found.best_authority < self._found.allowed

    @property
    def cause(self) -> str:
        """The largest of these errors, in words."""
        is_of_drum = self._found.by_drum >= self._attempts.doubt
        return "the winch does not follow its commands as modelled" if is_of_drum else "an attempt has failed"

    def take_loop(self, loop: GuardedLoop) -> None:
        """Watch another loop from now on: another design is active."""
        self._core.take_design(guard_design(self._parameters, loop, self._dt))
        self._found = self._core.verdict

    def allow_catch_up(self) -> None:
        """Do not check the drum for some seconds: the law has to catch up with what it could not see."""
        self._core.allow_catch_up()

    def reset_mismatch(self) -> None:
        """Compare depth sensor and estimate again: what was seen until now says nothing of either."""
        self._core.reset_mismatch()

    def forget_drum(self) -> None:
        """Do not hold errors of the drum against the winch: its count was another one."""
        self._core.state["drum_share"] = 0.0

    def allow_resumption(self) -> None:
        """Do not hold against the loop how drum and unit moved while a sensor was lost."""
        self._core.allow_resumption()

    def allow_correction(self, belief: str) -> None:
        """Do not hold against the loop what a wrong belief has done: it has just been corrected.

        What is corrected again and again is not known, and the loop is judged by what it does.

        Parameters
        ----------
        belief : what it is about, as "winch"
        """
        self._attempts.explain(belief)
        since = self._time - self._corrected_first.get(belief, -math.inf)
        if since > CORRECTIONS_REST:
            self._corrected_first[belief] = self._time
        elif since > CORRECTIONS_TIME:
            return
        self.allow_resumption()
        self.trusts_estimate = True
        self.reset_mismatch()

    def inhibit(self, reason: Alarm) -> None:
        """Keep compensation off while there is a `reason` that is certain, and no attempt has brought about."""
        self._attempts.certain(reason)

    def interrupt(self) -> bool:
        """Count an attempt that the winch has ended for want of commands; tell whether an operator has to ask now."""
        self._attempts.interrupt()
        return self._attempts.awaits_operator

    def update(self, seen: Seen, authority: float, target: float = 1.0, *, fades: bool = False) -> None:
        """Take one tick in.

        Parameters
        ----------
        seen : of the tick
        authority : authority of compensation now
        target : share it goes to; compensation is judged over waves when that is (nearly) reached
        fades : compensation fades out, or the winch comes to rest after it
        """
        self._time += self._dt
        attempts = self._attempts
        seen = seen._replace(unknown=seen.unknown + attempts.doubt)
        found = self._found = self._core.step(seen, authority, target, inhibits=self.inhibits)
        harm = Harm(int(found.bits)) if found.bits else None
        if harm and Harm.DISAGREE in harm:
            self.trusts_estimate = False
            attempts.unexplained(ALARMS.alarm("DEPTH_MRU_DISAGREE", error=found.mismatch))
        if self.inhibits:
            if attempts.ends(found.residual, is_off=authority <= 0.0 and not fades):
                self.trusts_estimate = True
                self._core.restart_waves()
        elif authority > 0.0:
            if harm:
                self.trusts_estimate &= Harm.DEPTH_HIGH not in harm
                attempts.fail(_alarm(harm, found))
            elif found.measured >= 0.0:
                attempts.learn(found.measured, self._dt / self._parameters.window)


def _alarm(harm: Harm, found: Verdict) -> Alarm:
    """Return the alarm of what was `found`: the depth sensor's word before the estimate's, seconds before waves."""
    if Harm.DEPTH_HIGH in harm:
        return ALARMS.alarm("UNIT_HEAVE_HIGH", heave=found.depth)
    if Harm.SWING_HIGH in harm:
        return ALARMS.alarm("UNIT_SWING_HIGH", swing=found.swing)
    if Harm.DRUM_OFF in harm:
        return ALARMS.alarm("DRUM_SPEED_OFF", error=found.drum)
    sigma, free = found.unit_sigma, found.free_sigma
    if sigma > free:
        return ALARMS.alarm("WORSE_THAN_OFF", sigma=sigma, free=free)
    return ALARMS.alarm("LITTLE_GAIN", sigma=sigma, free=free, percent=100.0 * found.least_gain)
