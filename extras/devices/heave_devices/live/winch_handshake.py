"""Brake, watchdog and latched faults for a drive that has none of its own, or says only some of it.

The contract of a winch (`docs/contract.md`): the brake is on at the start; a fresh command without a brake request
releases it; without a fresh command for the timeout it stops, brakes and latches a fault, which a brake request, and at
rest a command without one, release. A command is fresh when its number is above the newest one's. A brake request with
any other number is fresh too while a fault is latched, or once a braked winch has had no fresh command for the timeout:
a controller that was restarted counts from 1 again.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from heave_node.interface.codes import WinchFault, WinchRelease
from heave_node.winch.fault_latch import FaultLatch

AT_REST = 0.01
"""A drum slower than this is at rest [m/s]."""


class WinchOrder(NamedTuple):
    """What is asked of the drive."""

    payout: float  # set-point [m]
    payout_rate: float  # set-point [m/s]
    brake: bool  # stop, and hold with the brake
    sequence: int  # number of the command
    mean_payout: float = math.nan  # that the controller works about; NaN: it states none [m]


class WinchHandshake:
    """Keeps the contract between a controller, whose commands have a `timeout` [s], and a drive.

    Attributes
    ----------
    latch : of faults
    refused : commands that were not fresh
    """

    def __init__(self, timeout: float) -> None:
        self._timeout = timeout
        self._order = WinchOrder(0.0, 0.0, brake=True, sequence=0)
        self._since = -math.inf
        self.latch = FaultLatch()
        self.refused = 0

    def take(self, now: float, order: WinchOrder, rate: float) -> None:
        """Take an `order` of the controller at the time `now` [s], with the drum at a `rate` [m/s]; NaN: not known."""
        if not self._is_fresh(now, order):
            self.refused += order.sequence != self._order.sequence
            return
        self._since = now
        if not (math.isfinite(order.payout) and math.isfinite(order.payout_rate)):
            self._order = self._order._replace(sequence=order.sequence)
            self.latch.trip(WinchFault.INVALID_COMMAND)
            return
        self._order = order
        if order.brake:
            self.latch.acknowledge()
        else:
            self.latch.release(is_at_rest=_is_at_rest(rate))

    def order(self, now: float) -> WinchOrder:
        """Return what the drive shall do at `now` [s]: the command, or to stop and brake."""
        if self.is_released and now - self._since > self._timeout:
            self.latch.trip(WinchFault.COMMAND_TIMEOUT)
        return self._order if self.is_released else self._order._replace(payout_rate=0.0, brake=True)

    @property
    def fault(self) -> WinchFault:
        """The latched fault."""
        return self.latch.fault

    @property
    def is_released(self) -> bool:
        """Whether the drive may move."""
        return not self._order.brake and not self.fault

    @property
    def wants_reset(self) -> bool:
        """Whether a latched fault has been acknowledged by a brake request: a drive may then reset its own."""
        return self.latch.is_acknowledged

    def release(self, rate: float) -> WinchRelease:
        """Return what a latched fault waits for, with the drum at a `rate` [m/s]."""
        return self.latch.waits_for(is_at_rest=_is_at_rest(rate))

    def _is_fresh(self, now: float, order: WinchOrder) -> bool:
        newest = self._order
        if order.sequence > newest.sequence:
            return True
        is_silent = newest.brake and now - self._since > self._timeout
        return order.brake and order.sequence != newest.sequence and (bool(self.fault) or is_silent)


def _is_at_rest(rate: float) -> bool:
    return not abs(rate) > AT_REST
