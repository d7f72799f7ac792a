"""How long compensation stays off after harm, and when it is tried again."""

from __future__ import annotations

from heave_node.interface.alarm import Alarm

from winch_controller_node.interface.alarms import ALARMS
from winch_controller_node.parameters.laws import GuardParameters

CAUSE_TIME, KNOWN_HOLD = 20.0, 5.0
"""Harm whose cause is known and corrected within the first time [s] keeps compensation off for the second [s] only; so
do commands that were late for long: the transport is not the loop's harm."""

HOLD_GROWTH = 4.0
"""The hold time grows by this factor each time: what all tries do together stays little."""

MOST_TRIES = 5
"""Compensation is tried again after harm so many times; then an operator has to ask."""


class HarmHold:
    """Keeps compensation off for a reason, and for a time after it.

    Parameters
    ----------
    parameters : hold times, and the largest demand of the sea in which it is tried again
    tick_period : [s]

    Attributes
    ----------
    inhibits : compensation is to be off
    alarm : why; None where it need not
    """

    def __init__(self, parameters: GuardParameters, tick_period: float) -> None:
        self._parameters = parameters
        self._dt = tick_period
        self.inhibits = False
        self.alarm: Alarm | None = None
        self._is_unexplained = False
        self._hold_time = parameters.hold_time
        self._known_hold: float | None = None
        self._is_harm, self._tries = False, 0
        self._since = self._off_time = 0.0

    @property
    def awaits_operator(self) -> bool:
        """Tell whether compensation is off until an operator asks for it: it was tried too often."""
        return self.inhibits and self._is_harm and self._tries >= MOST_TRIES

    def release(self) -> None:
        """Let compensation be tried as at first: an operator asks for it."""
        if self.awaits_operator:
            self.inhibits, self.alarm = False, None
        self._tries = 0

    @property
    def _hold(self) -> float:
        """Time for which the reason must have been over [s]."""
        return self._hold_time if self._known_hold is None else self._known_hold

    def begin(self, reason: Alarm, hold: float | None = None) -> None:
        """Inhibit for a `reason`; `hold` as for `certain`."""
        self.inhibits, self.alarm = True, reason
        self._is_unexplained = False
        self._known_hold, self._is_harm = hold, hold is None
        self._since = self._off_time = 0.0

    def certain(self, reason: Alarm, hold: float | None = None) -> None:
        """Inhibit for a `reason` that lasts in this tick.

        Parameters
        ----------
        reason : why
        hold : time after it [s]; None: the hold time of harm, which becomes longer each time
        """
        self._off_time = 0.0
        if not self.inhibits or self._is_unexplained:
            self.begin(reason, hold)

    def unexplained(self, reason: Alarm) -> None:
        """Inhibit for a disagreement, which is the `reason` until it is known who is wrong."""
        self._off_time = 0.0
        if not self.inhibits:
            self.begin(reason)
            self._is_unexplained = True

    def explain(self, belief: str) -> None:
        """Hold for less, and say why: a wrong `belief`, as of the "winch", has just been corrected."""
        if self.inhibits and self._known_hold is None and self._since < CAUSE_TIME:
            self._known_hold = KNOWN_HOLD
        if self.inhibits and self._is_unexplained:
            self.alarm, self._is_unexplained = ALARMS.alarm("DEPTH_MRU_EXPLAINED", part=belief), False

    def is_kept_after(self, judged_time: float) -> None:
        """Reset the record of harm where compensation has done none for long, of a `judged_time` [s]."""
        if judged_time > 4.0 * self._hold_time:
            self._hold_time = self._parameters.hold_time
            self._tries = 0

    def prospect(self, demand: float) -> str:
        """Return when compensation is tried again in a sea of some `demand`, in words; empty where it is not off."""
        if not self.inhibits:
            return ""
        if self.awaits_operator:
            return f"tried {MOST_TRIES} times: request compensation once the cause has been found"
        if self._off_time < self._hold:
            # one wording, whether the reason is there in this tick or not: it may come and go
            left = self._hold - self._off_time
            return f"next attempt {self._hold:.0f} s after the cause has gone, in {left:.0f} s at the earliest"
        most = self._parameters.demand_ratio
        return f"next attempt when the sea demands at most {most:g} times the winch's limits; now {demand:.1f}"

    def ends(self, authority: float, demand: float) -> bool:
        """Take in a tick that inhibits; return whether compensation may be tried again from now on.

        Parameters
        ----------
        authority : authority of compensation still
        demand : of the sea, over the winch's limits
        """
        self._since += self._dt
        if authority > 0.0:
            return False
        self._off_time += self._dt
        if self.awaits_operator or self._off_time < self._hold or demand > self._parameters.demand_ratio:
            return False
        self.inhibits, self.alarm = False, None
        self._tries += int(self._is_harm)
        if self._known_hold is None:
            self._hold_time = min(HOLD_GROWTH * self._hold_time, self._parameters.hold_time_limit)
        return True
