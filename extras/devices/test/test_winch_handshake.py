"""Brake, watchdog and faults for a drive that has none: the contract's sentences, one by one."""

import math

import pytest
from heave_devices.live.winch_handshake import WinchHandshake, WinchOrder
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


def latched(timeout=0.5):
    """Return the handshake of a winch that command 5 moved, and that has timed out since."""
    winch = WinchHandshake(timeout)
    winch.take(0.0, order(5), 0.0)
    winch.order(timeout + 0.01)
    assert winch.fault is WinchFault.COMMAND_TIMEOUT
    return winch


def test_the_drive_may_move_only_while_it_is_commanded_without_a_brake_and_without_a_fault():
    winch = WinchHandshake(0.5)
    assert not winch.is_released
    winch.take(0.0, order(1), 0.0)
    assert winch.is_released
    winch.take(0.1, order(2, brake=True), 0.0)
    assert not winch.is_released
    assert not latched().is_released


def test_only_a_brake_request_with_another_number_acknowledges_a_fault():
    winch = latched()
    winch.take(1.0, order(5, brake=True), 0.0)
    assert not winch.wants_reset, "the number is the newest one's"
    winch.take(1.1, order(3), 0.0)
    assert not winch.wants_reset, "an old number without a brake request"
    assert winch.refused == 1, "one more of the newest number counts as that command"
    winch.take(1.2, order(3, brake=True), 0.0)
    assert winch.wants_reset


def test_a_drive_is_asked_for_a_reset_only_while_a_fault_is_latched():
    winch = latched()
    winch.take(1.0, order(6, brake=True), 0.0)
    assert winch.wants_reset
    winch.take(1.1, order(7), 0.0)
    assert (winch.fault, winch.wants_reset) == (WinchFault.NONE, False)


def test_a_new_trip_takes_an_acknowledgement_back():
    winch = latched()
    winch.take(1.0, order(6, brake=True), 0.0)
    winch.latch.trip(WinchFault.COMMAND_TIMEOUT)
    assert winch.release(0.0) is WinchRelease.BRAKE_REQUEST
    winch.take(1.1, order(7), 0.0)
    assert winch.fault, "a command alone releases nothing"


@pytest.mark.parametrize("sequence", [5, 4, 1])
def test_a_command_that_is_not_fresh_does_not_feed_the_watchdog(sequence):
    winch = WinchHandshake(0.5)
    winch.take(0.0, order(5), 0.0)
    for step in range(1, 12):
        winch.take(0.05 * step, order(sequence), 0.0)
    assert winch.order(0.55).brake
    assert winch.fault is WinchFault.COMMAND_TIMEOUT


@pytest.mark.parametrize(("silence", "is_taken"), [(0.6, True), (0.4, False)])
def test_a_braked_winch_hears_a_restarted_controller_after_the_timeout_and_no_command_that_came_late(silence, is_taken):
    winch = WinchHandshake(0.5)
    winch.take(10.0, order(1800, brake=True), 0.0)
    winch.take(10.0 + silence, order(1, brake=True), 0.0)
    winch.take(10.05 + silence, order(2, 0.1), 0.0)
    assert (winch.is_released, winch.refused) == (is_taken, 0 if is_taken else 2)


def test_a_fault_that_was_released_and_comes_again_has_to_be_acknowledged_again():
    winch = latched()
    winch.take(1.0, order(6, brake=True), 0.0)
    winch.take(1.1, order(7), 0.0)
    assert winch.order(1.2) == order(7)
    winch.latch.trip(WinchFault.DRIVE)
    assert winch.release(0.0) is WinchRelease.BRAKE_REQUEST


def test_the_number_of_a_set_point_that_is_no_number_is_used_up():
    winch = WinchHandshake(0.5)
    winch.take(0.0, order(3, math.inf), 0.0)
    winch.take(0.1, order(3, brake=True), 0.0)
    assert winch.release(0.0) is WinchRelease.BRAKE_REQUEST


def test_a_drum_whose_speed_is_not_known_is_taken_to_be_at_rest():
    """As a drive without a speed: what it waits for is the command."""
    winch = latched()
    winch.take(1.0, order(6, brake=True), math.nan)
    assert winch.release(math.nan) is WinchRelease.COMMAND
    assert winch.release(-0.02) is WinchRelease.STANDSTILL


def test_before_the_first_command_the_drive_is_to_stand_with_its_brake_on():
    assert WinchHandshake(0.5).order(100.0) == WinchOrder(0.0, 0.0, brake=True, sequence=0)


def test_silence_while_a_fault_is_acknowledged_takes_the_acknowledgement_of_it_not_back():
    """The drum still turned when the command came; once it is at rest the next one releases the fault."""
    winch = latched()
    winch.take(1.0, order(6, brake=True), 0.3)
    winch.take(1.1, order(7), 0.3)
    assert winch.order(9.0).brake
    assert winch.release(0.0) is WinchRelease.COMMAND
    winch.take(9.1, order(8), 0.0)
    assert winch.order(9.2) == order(8)
