"""Brake, watchdog and faults for a drive that has none: the contract's sentences, one by one."""

import math

from heave_node.devices.live.winch_handshake import WinchHandshake, WinchOrder
from heave_node.interface.codes import WinchFault, WinchRelease


def order(sequence, rate=0.5, *, brake=False, payout=0.0):
    return WinchOrder(payout, rate, brake, sequence)


def test_the_brake_is_on_until_a_fresh_command_releases_it():
    winch = WinchHandshake(0.5)
    assert winch.order(0.0).brake
    winch.take(0.0, order(1), 0.0)
    assert winch.order(0.1) == order(1)
    winch.take(0.1, order(1, 9.0), 0.0)
    assert winch.order(0.2).payout_rate == 0.5, "an old number is not taken"
    winch.take(0.2, order(2, brake=True), 0.0)
    assert winch.order(0.2)[1:3] == (0.0, True)


def test_without_commands_it_stops_brakes_and_is_released_step_by_step():
    winch = WinchHandshake(0.5)
    winch.take(0.0, order(5), 0.0)
    assert not winch.order(0.5).brake
    assert winch.order(0.51).brake
    assert winch.fault is WinchFault.COMMAND_TIMEOUT
    assert winch.release(0.3) is WinchRelease.BRAKE_REQUEST
    winch.take(1.0, order(6), 0.3)
    assert winch.order(1.0).brake, "a set-point alone does not release a fault"
    winch.take(1.1, order(1, brake=True), 0.3)
    assert winch.release(0.3) is WinchRelease.STANDSTILL, "a controller that was restarted is heard"
    winch.take(1.2, order(2), 0.3)
    assert winch.fault, "the drum still turns"
    assert winch.release(0.0) is WinchRelease.COMMAND
    winch.take(1.3, order(3), 0.0)
    assert not winch.fault
    assert winch.order(1.3) == order(3)


def test_a_set_point_that_is_no_number_is_a_fault():
    winch = WinchHandshake(0.5)
    winch.take(0.0, order(1, math.nan), 0.0)
    assert winch.fault is WinchFault.INVALID_COMMAND
    assert winch.order(0.0)[1:3] == (0.0, True)
