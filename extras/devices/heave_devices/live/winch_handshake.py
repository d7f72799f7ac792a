"""Brake, watchdog and latched faults for a drive that has none of its own, or says only some of it.

The contract of a winch (`docs/contract.md`): the brake is on at the start; a fresh command without a brake request
releases it; without a fresh command for the timeout it stops, brakes and latches a fault, which a brake request, and at
rest a command without one, release. A command is fresh when its number is above the newest one's; while a fault is
latched a brake request with any other number is fresh too.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from heave_node.interface.codes import WinchFault, WinchRelease

AT_REST = 0.01
"""A drum slower than this is at rest [m/s]."""


class WinchOrder(NamedTuple):
    """What is asked of the drive.

    Attributes
    ----------
    payout, payout_rate : set-points [m], [m/s]
    brake : stop, and hold with the brake
    sequence : number of the command
    """

    payout: float
    payout_rate: float
    brake: bool
    sequence: int


class WinchHandshake:
    """Keeps the contract between a controller and a drive.

    Parameters
    ----------
    timeout : of commands [s]

    Attributes
    ----------
    fault : latched
    refused : commands that were not fresh
    """

    def __init__(self, timeout: float) -> None:
        self._timeout = timeout
        self._order = WinchOrder(0.0, 0.0, brake=True, sequence=0)
        self._since = -math.inf
        self._is_acknowledged = False
        self.fault = WinchFault.NONE
        self.refused = 0

    def take(self, now: float, order: WinchOrder, rate: float) -> None:
        """Take a command of the controller.

        Parameters
        ----------
        now : monotonic time [s]
        order : the command
        rate : of the drum [m/s]; NaN: not known
        """
        is_resync = bool(self.fault) and order.brake and order.sequence != self._order.sequence
        if order.sequence <= self._order.sequence and not is_resync:
            self.refused += order.sequence != self._order.sequence
            return
        self._since = now
        if not (math.isfinite(order.payout) and math.isfinite(order.payout_rate)):
            self._order = self._order._replace(sequence=order.sequence)
            self.trip(WinchFault.INVALID_COMMAND)
            return
        self._order = order
        if self.fault and order.brake:
            self._is_acknowledged = True
        elif self.fault and self._is_acknowledged and self._is_at_rest(rate):
            self.fault = WinchFault.NONE

    def order(self, now: float) -> WinchOrder:
        """Return what the drive shall do at `now` [s]: the command, or to stop and brake."""
        if not self._order.brake and not self.fault and now - self._since > self._timeout:
            self.trip(WinchFault.COMMAND_TIMEOUT)
        if self.fault or self._order.brake:
            return self._order._replace(payout_rate=0.0, brake=True)
        return self._order

    @property
    def is_released(self) -> bool:
        """Whether the drive may move."""
        return not self._order.brake and not self.fault

    @property
    def wants_reset(self) -> bool:
        """Whether a latched fault has been acknowledged by a brake request: a drive may then reset its own."""
        return bool(self.fault) and self._is_acknowledged

    def trip(self, fault: WinchFault) -> None:
        """Latch a `fault`; the first one stays the named one."""
        self.fault = self.fault or fault
        self._is_acknowledged = False

    def release(self, rate: float) -> WinchRelease:
        """Return what a latched fault waits for, with the drum at a `rate` [m/s]."""
        if not self.fault:
            return WinchRelease.NONE
        if not self._is_acknowledged:
            return WinchRelease.BRAKE_REQUEST
        return WinchRelease.COMMAND if self._is_at_rest(rate) else WinchRelease.STANDSTILL

    def _is_at_rest(self, rate: float) -> bool:
        return not abs(rate) > AT_REST
