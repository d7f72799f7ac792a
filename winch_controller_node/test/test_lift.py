"""The crane's lift: what is ordered for it, how the winch is shared, and that the sum keeps the limits."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from winch_controller_node.crane.lift import LiftBounds, LiftOrders
from winch_controller_node.crane.lift_room import LiftRoom
from winch_controller_node.design.design import design_controller
from winch_controller_node.laws.parts.governor import LiftShare
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.crane import CraneModelParameters
from winch_controller_node.parameters.model import WinchModelParameters

DT = 0.05
SERVO = WinchModelParameters(time_constant=0.3, command_delay=0.2)
WINCHES = (
    SERVO,
    WinchModelParameters(time_constant=0.3, command_delay=0.13, position_gain=0.5),
    WinchModelParameters(law="first_order", position_rate=4.0, command_delay=0.1),
)


def drum(winch, commands, time):
    """Return the payout that `commands`, one a tick from 0 on, have made by a `time` [s]: Euler in steps of 0.1 ms."""
    payout = rate = 0.0
    step = 1e-4
    for n in range(round(time / step)):
        tick = math.floor((n * step - winch.command_delay) / DT + 1e-6)
        command = commands[tick] if tick >= 0 else 0.0
        if winch.law == "first_order":
            payout += step * winch.position_rate * (command - payout)
        else:
            payout += step * rate
            rate += step * (command - winch.position_gain * payout - rate) / winch.time_constant
    return payout


@pytest.mark.parametrize("winch", WINCHES)
def test_what_is_taken_for_paid_out_is_what_the_drum_pays_out(winch):
    lift = LiftOrders(winch, DT)
    commands = [lift.step(0.3 * n * DT, 0.3).command for n in range(60)]
    # 60 ticks are ordered: the drum is asked for at 3 s, and a moment before
    assert lift.made(0.0)[0] == pytest.approx(drum(winch, commands, 3.0), abs=5e-4)
    assert lift.made(0.02)[0] == pytest.approx(drum(winch, commands, 2.98), abs=5e-4)


@pytest.mark.parametrize("winch", WINCHES)
def test_a_steady_lift_is_made_up_for_in_full(winch):
    """The loop of lag and catch-up is at least critically damped, and has no error under a ramp."""
    lift = LiftOrders(winch, DT)
    for n in range(600):
        share = lift.step(0.2 * n * DT, 0.2)
    assert lift.made(0.0)[0] == pytest.approx(0.2 * 600 * DT, abs=1e-4)
    assert share.rate == pytest.approx(0.2, abs=1e-4)


def test_a_lift_beyond_its_share_of_speed_and_acceleration_waits_and_is_caught_up():
    lift, bounds = LiftOrders(SERVO, DT), LiftBounds(speed=0.4, acceleration=0.2)
    speeds, bound = [], set()
    for n in range(800):
        height = min(0.8 * n * DT, 8.0)
        speeds.append(lift.step(height, 0.8 if height < 8.0 else 0.0, bounds).command)
        bound.add(lift.bound)
    assert max(speeds) == 0.4
    assert np.abs(np.diff(speeds)).max() <= 0.2 * DT + 1e-12
    assert bound == {"", "speed"}
    assert lift.made(0.0)[0] == pytest.approx(8.0, abs=1e-3)


@given(st.floats(0.1, 5.0), st.floats(0.02, 0.8), st.floats(0.05, 1.0))
@settings(max_examples=60, deadline=None)
def test_a_lift_towards_the_end_of_its_range_stops_there_without_passing_it(highest, rate, acceleration):
    lift, bounds = LiftOrders(SERVO, DT), LiftBounds(1.0, acceleration, -1.0, highest)
    payouts = [lift.step(rate * n * DT, rate, bounds).payout for n in range(round((highest / rate + 30.0) / DT))]
    # the nominal drum coasts on by its lag times its speed, which the approach allows for
    assert max(payouts) <= highest + 1e-6
    assert payouts[-1] == pytest.approx(highest, abs=0.02)
    assert lift.bound == "range"


def test_the_room_of_the_sea_is_kept_free_at_the_ends_of_the_range():
    room = LiftRoom(CraneModelParameters(lift_speed_share=0.5, lift_acceleration_share=0.3), DT)
    limits = WinchLimits(speed=2.0, acceleration=1.0, payout_minimum=-10.0, payout_maximum=20.0)
    assert room.bounds(limits, 4.0, -1.5) == LiftBounds(1.0, 0.3, -10.0 + 1.5 - 4.0, 20.0 - 1.5 - 4.0)
    # a larger swing is kept for a minute
    assert room.bounds(limits, 4.0, 0.1).highest == pytest.approx(20.0 - 1.5 - 4.0, abs=0.002)


def test_an_alarm_is_given_once_until_the_winch_has_caught_up():
    room, bounds = LiftRoom(CraneModelParameters(), DT), LiftBounds(0.5, 0.3, -3.0, 3.0)
    for bound, left in (("speed", 0.05), ("speed", 0.2), ("", 0.4), ("speed", 0.5), ("range", 0.5), ("range", 2.0)):
        room.watch(bound, left, 0.7, bounds, 10.0)
    first, second = room.news()
    assert (first.code, first.values) == ("CRANE_TOO_FAST", {"rate": 0.7, "limit": 0.5})
    assert (second.code, second.values) == (
        "CRANE_BEYOND_RANGE",
        {"payout": 13.5, "limit": 13.0, "raise_or_lower": "raise"},
    )
    room.watch("", 0.0, 0.0, bounds, 10.0)
    room.watch("speed", -0.2, -0.7, bounds, 10.0)
    assert [alarm.code for alarm in room.news()] == ["CRANE_TOO_FAST"]


GOVERNOR = design_controller(
    WinchControllerParameters(winch=WinchModelParameters(time_constant=0.3, speed_limit=1.0, acceleration_limit=0.8)),
    tick_period=DT,
).make_governor()


@given(st.floats(-3.0, 3.0), st.floats(-60.0, 60.0), st.floats(-1.0, 1.0), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_the_limits_hold_for_the_sum_of_loop_and_lift(wanted, payout, rate, lifted, lift_rate):
    """What is governed beside a lift is what is governed of the whole, less the lift: superposition."""
    lift = LiftShare(lift_rate, lifted, 0.5 * lift_rate)
    governed = GOVERNOR.govern(wanted, payout, rate, 1e5, lift)
    whole = GOVERNOR.govern(wanted + lift_rate, payout + lifted, rate + 0.5 * lift_rate, 1e5)
    assert governed.value + lift_rate == pytest.approx(whole.value, abs=1e-9)
    assert governed.sent + governed.lift_sent == pytest.approx(whole.sent, abs=1e-9)
    assert governed.active == whole.active
    assert abs(governed.sent + governed.lift_sent) <= GOVERNOR.limits.speed + 1e-9
