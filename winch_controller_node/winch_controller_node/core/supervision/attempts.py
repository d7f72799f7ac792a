"""What failed attempts at compensation say of the next: it has less authority, and at last an operator has to ask."""

from __future__ import annotations

from heave_node.interface.alarm import Alarm

from winch_controller_node.interface.alarms import ALARMS

INTERRUPTION = 0.25
"""Motion that a stop for want of commands leaves, over that with the winch locked: a swing of some waves."""


class Attempts:
    """Keeps compensation off for a reason, and remembers what the attempts that failed have shown.

    An attempt that fails shows that the model is not all: errors of unknown cause leave as much again of what is
    compensated. One that the winch ends for want of commands leaves a swing, and so lowers the motion that may
    remain. What compensation then does well in the waves takes both back.

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
        self._largest = largest_residual
        self.inhibits = False
        self.alarm: Alarm | None = None
        self._is_unexplained = self._is_present = False
        self.doubt = self._doubt_before = self._interruptions = 0.0

    @property
    def bar(self) -> float:
        """Largest residual with which compensation is tried, over the motion with the winch locked."""
        return self._largest - INTERRUPTION * self._interruptions

    @property
    def awaits_operator(self) -> bool:
        """Tell whether compensation is off until an operator asks for it: no authority would gain enough any more."""
        return self.doubt / (1.0 + self.doubt) > max(self.bar, 0.0) ** 2 or self.bar <= 0.0

    def release(self) -> None:
        """Let compensation be tried as at first: an operator asks for it."""
        if self.awaits_operator:
            self.inhibits, self.alarm = False, None
        self.doubt = self._doubt_before = self._interruptions = 0.0

    def interrupt(self) -> None:
        """Count an attempt that the winch has ended for want of commands."""
        self._interruptions += 1.0

    def fail(self, reason: Alarm) -> None:
        """Inhibit for a `reason` that compensation has brought about."""
        self._begin(reason)
        self._doubt_before, self.doubt = self.doubt, self.doubt + 1.0

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
        self.inhibits, self.alarm, self._is_unexplained = True, reason, False

    def explain(self, belief: str) -> None:
        """Take the last failure back, and say why: a wrong `belief`, as of the "winch", has just been corrected."""
        self.doubt = min(self.doubt, self._doubt_before)
        if self.inhibits and self._is_unexplained:
            self.alarm, self._is_unexplained = ALARMS.alarm("DEPTH_MRU_EXPLAINED", part=belief), False

    def learn(self, measured: float, share: float) -> None:
        """Take in by a `share` what the waves show: errors leave no more than `measured` of compensated motion."""
        self.doubt += share * (min(measured, self.doubt) - self.doubt)
        self._doubt_before = min(self._doubt_before, self.doubt)
        self._interruptions *= 1.0 - share

    def prospect(self, residual: float) -> str:
        """Return when compensation is tried again, in words; empty where it is not off.

        `residual` : motion that it is predicted to leave, over that with the winch locked
        """
        if not self.inhibits:
            return ""
        if self.awaits_operator:
            return "every attempt has failed: request compensation once the cause has been found"
        if residual > self.bar:
            return f"next attempt when it is predicted to help; {too_much(residual, self.bar)}"
        return "next attempt once the cause has gone and the load has settled"

    def ends(self, residual: float, *, is_off: bool) -> bool:
        """Take in a tick that inhibits; return whether compensation may be tried again from now on.

        Parameters
        ----------
        residual : motion that it is predicted to leave, over that with the winch locked
        is_off : its fade-out has come to its end: the load has settled, as far as it can be damped
        """
        was_present, self._is_present = self._is_present, False
        if not is_off or was_present or self.awaits_operator or residual > self.bar:
            return False
        self.inhibits, self.alarm = False, None
        return True


def too_much(residual: float, largest: float) -> str:
    """Return in words that a predicted `residual` is above the `largest`, over the motion with the winch locked."""
    return f"it would leave {100.0 * residual:.0f} % of the motion with the winch locked, limit {100.0 * largest:.0f} %"
