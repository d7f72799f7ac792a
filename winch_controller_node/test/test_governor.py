import math

import numpy as np
import pytest
from cable_sim_node.winch.component import VirtualWinch, WinchCommand
from cable_sim_node.winch.parameters import WinchParameters
from hypothesis import given, settings
from hypothesis import strategies as st
from winch_controller_node.design.design import design_controller
from winch_controller_node.laws.parts.governor import SpeedServo
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import WinchModelParameters

DT = 0.05


@pytest.fixture(
    scope="module",
    params=[(0.15, 0.2, 0.0), (0.08, 0.237, 0.0), (0.15, 0.2, 0.5)],
    ids=["delay of ticks", "delay within a tick", "position loop"],
)
def design(request):
    lag, delay, gain = request.param
    winch = WinchModelParameters(time_constant=lag, command_delay=delay, position_gain=gain)
    return design_controller(WinchControllerParameters(winch=winch), tick_period=DT)


def drive(design, commands):
    """Give the virtual winch what the governor lets through; return its states and the linear model's."""
    governor = design.make_governor()
    belief = design.parameters.winch
    lags = WinchParameters(
        time_constant=belief.time_constant, command_delay=belief.command_delay, position_gain=belief.position_gain
    )
    winch = VirtualWinch(lags, tick_period=DT)
    model, x = design.model, np.zeros(design.model.order)
    winch.step(0, WinchCommand(1, brake=False))
    states, believed = [], []
    for tick, wanted in enumerate(commands, start=1):
        payout, rate = governor.predict(x)
        governed = governor.govern(wanted, payout, rate, 1e4)
        x = model.A @ x + model.B[:, 0] * governed.value
        states.append(winch.step(tick, WinchCommand(tick + 1, 0.0, governed.sent)))
        believed.append((float(model.row("payout") @ x), float(model.row("payout_rate") @ x)))
    return states, np.array(believed)


@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(-30.0, 30.0), min_size=1, max_size=12))
def test_no_command_takes_the_winch_beyond_its_limits_and_the_model_knows_its_speed(design, targets):
    """The governed command keeps the real winch on the linear model: what the estimator assumes is what happens."""
    states, believed = drive(design, np.repeat(targets, 25))
    rates = np.array([state.payout_rate for state in states])
    limits = WinchParameters()
    assert np.max(np.abs(rates)) <= limits.speed_limit + 1e-9
    assert np.max(np.abs(np.diff(rates))) <= limits.acceleration_limit * DT + 1e-9
    # the set-point itself stops at the speed limit: the last gain before it may fall short by what the lag leaves of
    # a tick, for 0.15 s 1.5 m/s^2 * (0.05 - 0.15 (1 - exp(-1/3))) s = 0.011 m/s; within a tick the linear servo is
    # ahead of the even acceleration by less than that again; the encoder shows the estimator the rest
    lag = design.parameters.winch.time_constant
    np.testing.assert_allclose(rates, believed[:, 1], atol=2.0 * 1.5 * (DT + lag * math.expm1(-DT / lag)))


def test_the_winch_stops_inside_its_payout_range_under_a_command_that_never_lets_go(design):
    """The limits of the design are 50 m either way less the margin of 1 m."""
    states, _ = drive(design, np.full(1200, 30.0))
    assert max(state.payout for state in states) <= 49.0
    assert states[-1].payout > 47.0
    assert abs(states[-1].payout_rate) < 0.05
    # and slows down all the way: it went to and fro at the end, a tick each, and beyond it by half a millimetre
    rates = np.array([state.payout_rate for state in states])
    assert np.all(np.diff(rates[np.argmax(rates) + 40 :]) < 1e-3)


def test_the_power_limit_bounds_the_speed_under_tension():
    """P = T v: 100 kW at 200 kN are 0.5 m/s."""
    limits = WinchLimits(2.0, 1.5, -50.0, 50.0, power=100e3)
    assert limits.speed_under(200e3) == pytest.approx(0.5)
    assert limits.speed_under(0.0) == 2.0


@given(st.floats(-0.26, 0.26), st.floats(-1.5, 1.5))
def test_the_set_point_gains_with_the_limiter_what_the_linear_servo_gains_without(step, rate):
    """Integrates the limited servo v' = clip((s - v)/T, a) finely and compares with the exact linear step."""
    lag, limit = 0.15, 1.5
    servo = SpeedServo(lag, limit, DT)
    set_point = servo.set_point(rate + step, rate)
    v, fine = rate, 5000
    for _ in range(fine):
        v += max(-limit, min(limit, (set_point - v) / lag)) * DT / fine
    assert v - rate == pytest.approx(step * -math.expm1(-DT / lag), abs=3e-5)


@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(-30.0, 30.0), min_size=1, max_size=12))
def test_a_slow_servo_that_takes_set_points_beyond_its_speed_is_driven_with_them_and_keeps_its_speed(targets):
    """v' = (v_set - v)/T, T = 1 s, exact over a tick: within 1.1 m/s, however large the set-points."""
    winch = WinchModelParameters(
        time_constant=1.0, command_delay=0.0, speed_limit=1.1, acceleration_limit=100.0, set_point_reach=20.0
    )
    governor = design_controller(WinchControllerParameters(winch=winch), tick_period=DT).make_governor()
    rate, rates = 0.0, [0.0]
    for wanted in np.repeat(targets, 10):
        governed = governor.govern(wanted, 0.0, rate, 1e4)
        assert governed.sent == governed.value
        assert abs(governed.sent) <= 22.0
        rate -= (governed.sent - rate) * math.expm1(-DT)
        rates.append(rate)
    assert np.max(np.abs(rates)) <= 1.1 + 1e-9


def test_full_speed_is_reached_in_the_time_that_the_larger_set_point_needs():
    """T = 1 s: 11 m/s reaches 1.1 m/s within -ln(1 - 0.1) = 0.105 s, three ticks; a set-point of 1.1 m/s never does."""

    def speed(reach):
        winch = WinchModelParameters(
            time_constant=1.0, command_delay=0.0, speed_limit=1.1, acceleration_limit=100.0, set_point_reach=reach
        )
        governor = design_controller(WinchControllerParameters(winch=winch), tick_period=DT).make_governor()
        rate = 0.0
        for _ in range(3):
            rate -= (governor.govern(11.0, 0.0, rate, 1e4).sent - rate) * math.expm1(-DT)
        return rate

    assert speed(10.0) == pytest.approx(1.1)
    assert speed(1.0) == pytest.approx(1.1 * -math.expm1(-3.0 * DT))


@given(st.floats(-1.0, 1.0))
def test_the_set_point_of_a_drum_that_creeps_gives_the_speed_that_was_asked_for(wanted):
    """Out it settles at 0.94 of its set-point, in at 0.7 of that, and creeps out by 0.06 m/s."""
    winch = WinchModelParameters(speed_gain=0.94, hauling_gain=0.7, creep=0.06)
    governor = design_controller(WinchControllerParameters(winch=winch), tick_period=DT).make_governor()
    sent = governor.govern(wanted, 0.0, wanted, 1e4).sent
    assert 0.06 + 0.94 * sent * (1.0 if sent > 0.0 else 0.7) == pytest.approx(wanted, abs=1e-12)
