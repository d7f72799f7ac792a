"""What failed attempts at compensation say of the next: it has less authority, and at last an operator has to ask."""

from __future__ import annotations

from heave_node.interface.alarm import Alarm

from winch_controller_node.interface.alarms import ALARMS


class Attempts:
    """Keeps compensation off for a reason, and remembers what the attempts that failed have shown.

    An attempt that fails shows that what is believed is not all: errors of unknown cause leave as much again of what
    is compensated. What compensation then does well in the waves takes that back.

    Parameters
    ----------
    largest_residual : motion that compensation may leave, over that with the winch locked

    Attributes
    ----------
    inhibits : compensation is to be off
    alarm : why; None where it need not
    doubt : variance that errors of unknown cause leave of compensated motion, over that motion's
    """

    def __init__(self, largest_residual: float) -> None:
        self._largest = largest_residual**2
        self.inhibits = False
        self.alarm: Alarm | None = None
        self._is_unexplained = self._is_present = False
        self.doubt = self._doubt_before = 0.0

    @property
    def awaits_operator(self) -> bool:
        """Tell whether compensation is off until an operator asks for it: no authority would gain enough any more."""
        return self.doubt / (1.0 + self.doubt) > self._largest

    def release(self) -> None:
        """Let compensation be tried as at first: an operator asks for it."""
        if self.awaits_operator:
            self.inhibits, self.alarm = False, None
        self.doubt = self._doubt_before = 0.0

    def count_failure(self) -> None:
        """Count an attempt that failed."""
        self._doubt_before, self.doubt = self.doubt, self.doubt + 1.0

    def fail(self, reason: Alarm) -> None:
        """Inhibit for a `reason` that compensation has brought about."""
        self._begin(reason)
        self.count_failure()

    def certain(self, reason: Alarm) -> None:
        """Inhibit for a `reason` that lasts in this tick, and that no attempt has brought about."""
        self._is_present = True
        if not self.inhibits or self._is_unexplained:
            self._begin(reason)

    def unexplained(self, reason: Alarm) -> None:
        """Inhibit for a disagreement in this tick, which is the `reason` until it is known who is wrong."""
        self._is_present = True
        if not self.inhibits:
            self.fail(reason)
            self._is_unexplained = True

    def _begin(self, reason: Alarm) -> None:
        self.inhibits, self.alarm = True, reason
        self._is_unexplained = False

    def explain(self, belief: str) -> None:
        """Take the last failure back, and say why: a wrong `belief`, as of the "winch", has just been corrected."""
        self.doubt = min(self.doubt, self._doubt_before)
        if self.inhibits and self._is_unexplained:
            self.alarm, self._is_unexplained = ALARMS.alarm("DEPTH_MRU_EXPLAINED", part=belief), False

    def learn(self, measured: float, share: float) -> None:
        """Take in by a `share` what the waves show: errors leave no more than `measured` of compensated motion."""
        self.doubt += share * (min(measured, self.doubt) - self.doubt)
        self._doubt_before = min(self._doubt_before, self.doubt)

    def prospect(self, residual: float) -> str:
        """Return when compensation is tried again, in words; empty where it is not off.

        `residual` : motion that it is predicted to leave, over that with the winch locked
        """
        if not self.inhibits:
            return ""
        if self.awaits_operator:
            return "every attempt has failed: request compensation once the cause has been found"
        if residual**2 > self._largest:
            return f"next attempt when it is predicted to help; {too_much(residual, self._largest**0.5)}"
        return "next attempt once the cause has gone and the load has settled"

    def ends(self, authority: float, residual: float) -> bool:
        """Take in a tick that inhibits; return whether compensation may be tried again from now on.

        Parameters
        ----------
        authority : of compensation still
        residual : motion that it is predicted to leave, over that with the winch locked
        """
        was_present, self._is_present = self._is_present, False
        if authority > 0.0 or was_present or self.awaits_operator or residual**2 > self._largest:
            return False
        self.inhibits, self.alarm = False, None
        return True


def too_much(residual: float, largest: float) -> str:
    """Return in words that a predicted `residual` is above the `largest`, over the motion with the winch locked."""
    return f"it would leave {100.0 * residual:.0f} % of the motion with the winch locked, limit {100.0 * largest:.0f} %"
