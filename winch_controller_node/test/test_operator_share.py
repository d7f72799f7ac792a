"""The winch is shared: the operator never uses more than its share of it, and compensation has what that leaves."""

import numpy as np
import pytest
from cable_sim_node.winch.parameters import WinchParameters
from heave_bringup.closed_loop import ClosedLoop
from hypothesis import given, settings
from hypothesis import strategies as st
from winch_controller_node.design.design import design_controller
from winch_controller_node.laws.law import LawDesign
from winch_controller_node.laws.mpc import ConstrainedLaw, MpcParameters
from winch_controller_node.laws.parts.loop_state import LoopState, Reference
from winch_controller_node.motion.operator_speed import OperatorRange, OperatorSpeed
from winch_controller_node.motion.trajectory import MeanPayout
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.laws import MoveParameters, OperatorParameters

from tests.core_parts import bounds
from tests.loops import two_state_parameters

DT = 0.05

LARGEST_SPEED, ACCELERATION, LAG = 2.0, 1.5, 0.2
"""The winch of these tests [m/s], [m/s^2], [s]."""


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(st.floats(-3.0, 3.0), st.integers(1, 300)), min_size=1, max_size=6))
def test_an_operator_gets_no_more_than_the_share_and_stays_within_the_range(asked):
    bounds = OperatorRange(speed=0.6, acceleration=0.15, payout_minimum=-5.0, payout_maximum=5.0, lag=2.0)
    operator = OperatorSpeed(OperatorParameters(), tick_period=DT)
    mean = MeanPayout(MoveParameters(), tick_period=DT)
    for speed, ticks in asked:
        for _ in range(ticks):
            operator.ask(speed)
            before = mean.point
            mean.drive(operator.advance(before, bounds), bounds.acceleration)
            point = mean.advance()
            assert abs(point.rate) <= bounds.speed + 1e-9
            assert abs(point.rate - before.rate) <= bounds.acceleration * DT + 1e-9
            assert bounds.payout_minimum - 0.01 <= point.payout <= bounds.payout_maximum + 0.01


def test_each_speed_is_told_and_with_what_it_has_moved_when_it_ends():
    operator, told = OperatorSpeed(OperatorParameters(timeout=0.5), tick_period=DT), []
    bounds = OperatorRange(speed=0.6, acceleration=0.15, payout_minimum=-5.0, payout_maximum=5.0, lag=2.0)
    for second, speed in enumerate((0.2, 0.3, 0.0, -0.2, None)):
        for tick in range(20):
            if speed is not None:
                operator.ask(speed)
            time = second + tick * DT
            going = operator.advance(MeanPayout(MoveParameters(), tick_period=DT).point, bounds)
            told += [(time, words) for words in operator.news(payout=2.0 * time)]
    assert going == 0.0, "a joystick that has fallen silent"
    over = ": the mean payout has moved by "
    assert told[:4] == [
        (0.0, "speed +0.2 m/s"),
        (1.0, "speed +0.3 m/s"),
        (2.0, f"speed +0 m/s{over}+4.00 m"),
        (3.0, "speed -0.2 m/s"),
    ]
    ((time, words),) = told[4:]
    assert time == pytest.approx(4.5, abs=2 * DT)
    assert words.startswith(f"no speed{over}")


def test_a_speed_beyond_the_share_is_told_once_each_time_that_it_is_asked_for_anew():
    bounds = OperatorRange(speed=0.6, acceleration=0.15, payout_minimum=-5.0, payout_maximum=5.0, lag=2.0)
    operator = OperatorSpeed(OperatorParameters(timeout=0.5), tick_period=DT)
    told = []
    for second, speed in enumerate((0.6, -0.9, 0.7, 0.0, 0.8, None, 0.8)):
        for _ in range(20):
            if speed is not None:
                operator.ask(speed)
            told += [(second, alarm) for alarm in [operator.limit_news(bounds)] if alarm]
            operator.advance(MeanPayout(MoveParameters(), tick_period=DT).point, bounds)
    assert [second for second, _ in told] == [1, 4, 6]
    assert told[0][1].code == "OPERATOR_SPEED_LIMITED"
    assert told[0][1].values == {"limit": 0.6, "requested": 0.9}


def test_the_plan_of_compensation_has_what_the_operator_leaves():
    """While the mean gains speed at 0.3 m/s^2, 1.2 m/s^2 are left on that side, and 1.8 on the other."""
    design = design_controller(WinchControllerParameters(), tick_period=DT)
    made_for = LawDesign(design.model, design.parameters.winch, design.limits, design.parameters.weights, design.gain)
    law = ConstrainedLaw(made_for, MpcParameters())
    rows = next(kind.rows for kind in law.planner.rows.kinds if kind.name == "acceleration")
    rate = 0.4
    ahead = Reference(rate=rate, command=rate + design.parameters.winch.time_constant * 0.3)
    whole, left = (
        bounds(law, LoopState(np.zeros(design.model.order), reference, design.cable.static_tension))
        for reference in (Reference(), ahead)
    )
    for bound, without in zip(left, whole, strict=True):
        np.testing.assert_allclose(bound[rows], without[rows] - 0.3)


def loop_in(*, acceleration, height=4.0, **controller):
    """Return a loop in a sea that takes the winch to its limits; the winch has a true `acceleration` [m/s^2]."""
    winch = WinchParameters(acceleration_limit=acceleration, stop_deceleration=acceleration)
    return ClosedLoop(two_state_parameters(height, 8.0, sea={"ramp": 10.0}, winch=winch, **controller))


def operated(loop, ticks):
    """Run `ticks` of a `loop` with an operator who lowers and stops; return what was seen by tick.

    Columns: speed and acceleration of the operator's reference, what the winch is asked for, and how far that is from
    the speed that the drum has when it takes effect.
    """
    orders, seen = [], []
    delay = round(WinchParameters().command_delay / DT)
    for tick in range(ticks):
        loop.controller.operate(1.0 if tick % 800 < 400 else 0.0)
        before, speed = loop.controller.mean.point, loop.winch.state.payout_rate
        outputs, _ = loop.step()
        point = loop.controller.mean.point
        orders = [*orders[-delay:], outputs.order]
        step = orders[0].payout_rate - speed if len(orders) > delay else 0.0
        seen.append((point.rate, (point.rate - before.rate) / DT, outputs.order.payout_rate, step))
    return np.abs(np.array(seen)).T


def test_operator_and_compensation_together_keep_the_limits_in_a_sea_that_takes_all_of_the_winch():
    loop = loop_in(acceleration=ACCELERATION, height=4.0)
    for _ in range(round(40.0 / DT)):
        loop.step()
    rate, acceleration, asked, step = operated(loop, round(40.0 / DT))
    shares = loop.controller.parameters.operator
    assert 0.9 * shares.speed_share * LARGEST_SPEED < rate.max() <= shares.speed_share * LARGEST_SPEED
    assert acceleration.max() == pytest.approx(shares.acceleration_share * ACCELERATION)
    # the sea and the operator ask for more than the winch has, and neither speed nor acceleration is asked of it
    assert 0.9 * LARGEST_SPEED < asked.max() <= LARGEST_SPEED + 1e-9
    assert step.max() <= ACCELERATION * (LAG + DT) + 0.01
    assert loop.controller.mode.value == "compensating"


def test_the_share_is_one_of_the_acceleration_that_was_learnt():
    """The winch has half of the assumed acceleration, and so has the operator."""
    # all of the sea is compensated only once the winch is known
    loop = loop_in(acceleration=0.5 * ACCELERATION, height=3.0, **{"modes.fade_in_time": 15.0})
    for _ in range(round(40.0 / DT)):
        loop.step()
    learnt = loop.controller.parameters.winch.acceleration_limit
    assert learnt == pytest.approx(0.5 * ACCELERATION, rel=0.1)
    _, acceleration, _, _ = operated(loop, round(15.0 / DT))
    assert acceleration.max() == pytest.approx(loop.controller.parameters.operator.acceleration_share * learnt)
