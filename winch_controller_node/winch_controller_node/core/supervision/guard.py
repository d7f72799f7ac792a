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
says it in words. Compensation that does harm is faded out. It is tried again where it is predicted to leave
less motion than the winch locked, with the authority that leaves least; each attempt that failed raises that bar.
"""

from __future__ import annotations

import math

from heave_core.look import Guard, Verdict
from heave_core.look_table import Harm
from heave_core.modes_table import WhyOff
from heave_node.interface.alarm import Alarm

from winch_controller_node.core.supervision.guard_checks import GuardedLoop, guard_design
from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.parameters.laws import GuardParameters

INTERRUPTION = 0.25
"""Motion that a stop for want of commands leaves, over that with the winch locked: a swing of some waves."""

NO_MORE = "every attempt has failed: request compensation once the cause has been found"
"""What follows the last attempt."""


def too_much(residual: float, largest: float) -> str:
    """Return in words that a predicted `residual` is above the `largest`, over the motion with the winch locked."""
    return f"it would leave {100.0 * residual:.0f} % of the motion with the winch locked, limit {100.0 * largest:.0f} %"


def prospect(residual: float, largest: float, *, awaits_operator: bool) -> str:
    """Return when compensation that is off is tried again.

    Parameters
    ----------
    residual : motion that it is predicted to leave, over that with the winch locked
    largest : most of it with which it is tried
    awaits_operator : it is off until an operator asks for it
    """
    if awaits_operator:
        return NO_MORE
    if residual > largest:
        return f"next attempt when it is predicted to help; {too_much(residual, largest)}"
    return "next attempt once the cause has gone and the load has settled"


def sequel(*, awaits_operator: bool) -> str:
    """Return what follows a failed attempt, as a sentence of its alarm; `awaits_operator` as of `prospect`."""
    if awaits_operator:
        return f"{NO_MORE[0].upper()}{NO_MORE[1:]}"
    return "The next attempt is automatic; if it fails too, request standby"


CORRECTIONS_TIME, CORRECTIONS_REST = 20.0, 300.0
"""Time within which a belief is corrected again and again [s], and time from its beginning to the next such."""


class HarmGuard:
    """Says when compensation is to be off, and when it may be tried again.

    Parameters
    ----------
    parameters : window, ratio, floor
    loop : that it watches
    tick_period : [s]
    """

    def __init__(self, parameters: GuardParameters, loop: GuardedLoop, *, tick_period: float) -> None:
        self._parameters, self._dt = parameters, tick_period
        attempts = {"largest_residual": parameters.harm_ratio, "interruption": INTERRUPTION}
        learnt = tick_period / parameters.window
        # what is measured and compared
        self.core = Guard(guard_design(parameters, loop, tick_period), {**attempts, "learnt": learnt})
        self._state, self._found = self.core.attempts[0], self.core.found[0]
        self._alarm: Alarm | None = None
        self._certain: Alarm | None = None
        self.reset_sea()

    def reset_sea(self) -> None:
        """Restart the comparison: what was seen until now was another sea."""
        self.core.begin()
        self._corrected_first: dict[str, float] = {}

    @property
    def inhibits(self) -> bool:
        """Tell whether compensation is to be off."""
        return bool(self._state["inhibits"])

    @property
    def trusts_estimate(self) -> bool:
        """Tell whether the depth sensor agrees with the estimate."""
        return not self._state["distrusts"]

    @property
    def alarm(self) -> Alarm | None:
        """Why it inhibits; None where it does not."""
        return self._alarm if self.inhibits else None

    @property
    def reason(self) -> str:
        """Why it inhibits, in words; empty where it does not."""
        return "" if self.alarm is None else self.alarm.brief

    @property
    def awaits_operator(self) -> bool:
        """Tell whether compensation is off until an operator asks for it: no authority would gain enough any more."""
        return self.inhibits and self.core.awaits_operator

    def release(self) -> None:
        """Let compensation be tried as at first: an operator asks for it."""
        self.core.release()

    @property
    def prospect(self) -> str:
        """When compensation is tried again, in words; empty where it is not inhibited."""
        if not self.inhibits:
            return ""
        return prospect(self.residual, self.largest_residual, awaits_operator=self.awaits_operator)

    @property
    def demand(self) -> float:
        """What the sea asks of the winch over its limits: significant amplitude of speed or acceleration [-]."""
        return float(self._found["demand"])

    @property
    def tip_sigma(self) -> float:
        """Standard deviation of the boom tip over the last waves [m]."""
        return float(self._found["tip_sigma"])

    @property
    def authority_limit(self) -> float:
        """Authority that is predicted to leave the least motion in the sea seen now."""
        return float(self._found["best_authority"])

    @property
    def residual(self) -> float:
        """Motion that it is predicted to leave, over that with the winch locked."""
        return float(self._found["residual"])

    @property
    def largest_residual(self) -> float:
        """Largest of it with which compensation is tried."""
        return self.core.largest_residual

    @property
    def cause(self) -> str:
        """The largest of the errors that keep authority below what the winch's limits allow, in words."""
        is_of_drum = self._found["by_drum"] >= self._state["doubt"]
        return "the winch does not follow its commands as modelled" if is_of_drum else "an attempt has failed"

    def take_loop(self, loop: GuardedLoop) -> None:
        """Watch another loop from now on: another design is active."""
        self.core.take_design(guard_design(self._parameters, loop, self._dt))

    def reset_mismatch(self) -> None:
        """Compare depth sensor and estimate again: what was seen until now says nothing of either."""
        self.core.reset_mismatch()

    def allow_resumption(self) -> None:
        """Do not hold against the loop how drum and unit moved while a sensor was lost."""
        self.core.allow_resumption()

    def allow_correction(self, belief: str, time: float) -> None:
        """Do not hold against the loop what a wrong belief has done: it has just been corrected.

        What is corrected again and again is not known, and the loop is judged by what it does.

        `belief` : what it is about, as "winch"; `time` : of the last tick [s]
        """
        reasons = int(self._state["begun"])
        self.core.explain()
        if self._state["begun"] != reasons:
            self._alarm = ALARMS.alarm("DEPTH_MRU_EXPLAINED", part=belief)
        since = time - self._corrected_first.get(belief, -math.inf)
        if since > CORRECTIONS_REST:
            self._corrected_first[belief] = time
        elif since > CORRECTIONS_TIME:
            return
        self.allow_resumption()
        self._state["distrusts"] = 0
        self.reset_mismatch()

    def note_certain(self, reason: Alarm) -> None:
        """Note the `reason` for which compensation must be off in this tick, and that no attempt has brought about."""
        self._certain = reason

    def note(self) -> Alarm | None:
        """Return why it inhibits, where the core has found another reason in this tick."""
        why, found = self._state["why"], self.core.verdict
        if why == WhyOff.HARM_CERTAIN:
            self._alarm = self._certain
        elif why == WhyOff.HARM_UNEXPLAINED:
            self._alarm = ALARMS.alarm("DEPTH_MRU_DISAGREE", error=found.mismatch, next=self._sequel)
        elif why == WhyOff.HARM_DONE:
            self._alarm = _alarm(Harm(int(self._state["harm"])), found, self._sequel)
        return self.alarm

    @property
    def _sequel(self) -> str:
        return sequel(awaits_operator=self.awaits_operator)


def _alarm(harm: Harm, found: Verdict, follows: str) -> Alarm:
    """Return the alarm of what was `found`: the depth sensor's word before the estimate's, seconds before waves.

    `follows` : what follows it, a sentence (`sequel`)
    """
    if Harm.DEPTH_HIGH in harm:
        return ALARMS.alarm("WORSE_THAN_OFF: depth", heave=found.depth, next=follows)
    if Harm.SWING_HIGH in harm:
        return ALARMS.alarm("WORSE_THAN_OFF: swing", swing=found.swing, next=follows)
    if Harm.DRUM_OFF in harm:
        return ALARMS.alarm("DRUM_SPEED_OFF", error=found.drum, next=follows)
    sigma, free = found.unit_sigma, found.free_sigma
    if sigma > free:
        return ALARMS.alarm("WORSE_THAN_OFF: estimate", sigma=sigma, free=free, next=follows)
    return ALARMS.alarm("LITTLE_GAIN", sigma=sigma, free=free, percent=100.0 * found.least_gain, next=follows)
