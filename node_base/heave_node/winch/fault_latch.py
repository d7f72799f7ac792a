"""Faults of a winch that latch: one table of their rank and of who releases them, and the latch that keeps to it.

A fault of a higher rank replaces a lower one; no event replaces or clears a higher one. A fault is left by an
acknowledgement (a brake request) and then, the drum at rest and the cause gone, by a release (a command without a
brake). Nothing else leaves it: no restart of a device, no jump of a count, of a clock or of a number.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from heave_node.interface.codes import WinchFault, WinchRelease, without_figures


class FaultRule(NamedTuple):
    """How a fault is ranked and left."""

    rank: int  # a fault replaces one of a lower rank
    is_automatic: bool  # a controller may release it by itself; otherwise an operator requests a mode


FAULTS: Mapping[int, FaultRule] = {
    WinchFault.NONE: FaultRule(0, is_automatic=True),
    WinchFault.COMMAND_TIMEOUT: FaultRule(1, is_automatic=True),
    WinchFault.INVALID_COMMAND: FaultRule(2, is_automatic=False),
    WinchFault.DRIVE: FaultRule(3, is_automatic=False),
    WinchFault.EMERGENCY_STOP: FaultRule(4, is_automatic=False),
}
"""Rank of each fault, and who may release it."""


def is_automatic(code: int) -> bool:
    """Return whether a controller may release the fault of a `code` by itself; one that is unknown it may not."""
    return code in FAULTS and FAULTS[code].is_automatic


class FaultLatch:
    """Holds the fault of one winch.

    Attributes
    ----------
    fault : the highest one since the last release
    words : what was found, until it is released; "": nothing was said
    is_acknowledged : since the last trip
    """

    def __init__(self) -> None:
        self.fault = WinchFault.NONE
        self.words = ""
        self.is_acknowledged = False
        self._present: set[WinchFault] = set()

    def trip(self, fault: WinchFault, words: str = "") -> None:
        """Latch a `fault`, found as `words` say. It takes an acknowledgement back, whatever its rank."""
        self.is_acknowledged = False
        if FAULTS[fault].rank > FAULTS[self.fault].rank:
            self.fault, self.words = fault, words
        elif fault is self.fault and without_figures(words) not in without_figures(self.words):
            self.words = f"{self.words}; {words}" if self.words else words

    def hold(self, fault: WinchFault, words: str = "", *, is_present: bool) -> None:
        """Latch a `fault` when its cause begins, and refuse the release while it `is_present`; found as `words` say."""
        if not is_present:
            self._present.discard(fault)
        elif fault not in self._present:
            self._present.add(fault)
            self.trip(fault, words)

    def acknowledge(self) -> None:
        """Note a brake request."""
        self.is_acknowledged = bool(self.fault)

    def release(self, *, is_at_rest: bool) -> None:
        """Note a command without a brake: it leaves a fault that was acknowledged and whose cause is gone.

        The drum must be at rest (`is_at_rest`).
        """
        if self.waits_for(is_at_rest=is_at_rest) is WinchRelease.COMMAND:
            self.fault, self.words, self.is_acknowledged = WinchFault.NONE, "", False

    def waits_for(self, *, is_at_rest: bool) -> WinchRelease:
        """Return what the fault waits for, the drum turning or, `is_at_rest`, standing."""
        if not self.fault:
            return WinchRelease.NONE
        if not self.is_acknowledged or self._present:
            return WinchRelease.BRAKE_REQUEST
        return WinchRelease.COMMAND if is_at_rest else WinchRelease.STANDSTILL
