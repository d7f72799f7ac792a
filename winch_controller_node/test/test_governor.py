import math
from functools import lru_cache

import numpy as np
import pytest
from cable_sim_node.winch.component import VirtualWinch, WinchCommand
from cable_sim_node.winch.parameters import WinchParameters
from hypothesis import given, settings
from hypothesis import strategies as st
from winch_controller_node.design.design import design_controller
from winch_controller_node.laws.parts.governor import CommandGovernor, standing_command
from winch_controller_node.laws.parts.winch_limits import ActiveWinch
from winch_controller_node.node_parameters import WinchControllerParameters
from winch_controller_node.parameters.model import WinchModelParameters

DT = 0.05


def governor_of(design):
    """Return the governor that keeps the active limits of a `design`."""
    return CommandGovernor(design.model, ActiveWinch(design.parameters.winch, design.limits, design.tick_period))


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
    governor = governor_of(design)
    belief = design.parameters.winch
    lags = WinchParameters(
        time_constant=belief.time_constant, command_delay=belief.command_delay, position_gain=belief.position_gain
    )
    winch = VirtualWinch(lags, tick_period=DT)
    model, x = design.model, np.zeros(design.model.order)
    winch.step(0, WinchCommand(1, brake=False))
    states, assumed = [], []
    for tick, wanted in enumerate(commands, start=1):
        payout, rate = governor.predict(x)
        governed = governor.govern(wanted, payout, rate, 1e4)
        x = model.A @ x + model.B[:, 0] * governed.value
        states.append(winch.step(tick, WinchCommand(tick + 1, 0.0, governed.sent)))
        assumed.append((float(model.row("payout") @ x), float(model.row("payout_rate") @ x)))
    return states, np.array(assumed)


@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(-30.0, 30.0), min_size=1, max_size=12))
def test_no_command_takes_the_winch_beyond_its_limits_and_the_model_knows_its_speed(design, targets):
    """The governed command keeps the real winch on the linear model: what the estimator assumes is what happens."""
    states, assumed = drive(design, np.repeat(targets, 25))
    rates = np.array([state.payout_rate for state in states])
    limits = WinchParameters()
    assert np.max(np.abs(rates)) <= limits.speed_limit + 1e-9
    assert np.max(np.abs(np.diff(rates))) <= limits.acceleration_limit * DT + 1e-9
    # the set-point itself stops at the speed limit: the last gain before it may fall short by what the lag leaves of
    # a tick, for 0.15 s 1.5 m/s^2 * (0.05 - 0.15 (1 - exp(-1/3))) s = 0.011 m/s; within a tick the linear servo is
    # ahead of the even acceleration by less than that again; the encoder shows the estimator the rest
    lag = design.parameters.winch.time_constant
    np.testing.assert_allclose(rates, assumed[:, 1], atol=2.0 * 1.5 * (DT + lag * math.expm1(-DT / lag)))


def test_the_winch_stops_inside_its_payout_range_under_a_command_that_never_lets_go(design):
    """The limits of the design are 50 m either way less the margin of 1 m."""
    states, _ = drive(design, np.full(1200, 30.0))
    assert max(state.payout for state in states) <= 49.0
    assert states[-1].payout > 47.0
    assert abs(states[-1].payout_rate) < 0.05
    # and slows down all the way: it went to and fro at the end, a tick each, and beyond it by half a millimetre
    rates = np.array([state.payout_rate for state in states])
    assert np.all(np.diff(rates[np.argmax(rates) + 40 :]) < 1e-3)


@given(st.floats(-1.0, 1.0))
def test_the_set_point_of_a_drum_that_creeps_gives_the_speed_that_was_asked_for(wanted):
    """Out it settles at 0.94 of its set-point, in at 0.7 of that, and creeps out by 0.06 m/s."""
    winch = WinchModelParameters(speed_gain=0.94, hauling_gain=0.7, creep=0.06)
    governor = governor_of(design_controller(WinchControllerParameters(winch=winch), tick_period=DT))
    sent = governor.govern(wanted, 0.0, wanted, 1e4).sent
    assert 0.06 + 0.94 * sent * (1.0 if sent > 0.0 else 0.7) == pytest.approx(wanted, abs=1e-12)


# what leaves, and by which limit


@lru_cache
def designed(**winch):
    return design_controller(WinchControllerParameters(winch=WinchModelParameters(**winch)), tick_period=DT)


def govern(wanted, *, payout=0.0, rate=0.0, tension=1e4, **winch):
    return governor_of(designed(**winch)).govern(wanted, payout, rate, tension)


LAG, ACCELERATION = 0.15, 1.5
STEP = ACCELERATION * DT / -math.expm1(-DT / LAG)
"""A set-point so far off gains the limit of 1.5 m/s^2 over a tick of the linear servo: v_set - v of the first order."""


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_command_at_a_limit_is_within_it(way):
    assert govern(way * 2.0, rate=way * 1.9)[:2] == (way * 2.0, ())


@pytest.mark.parametrize("wanted", [-0.2, 0.0, 0.2])
def test_a_command_within_the_limits_leaves_as_it_is(wanted):
    assert tuple(govern(wanted)) == (wanted, (), wanted)


@pytest.mark.parametrize(
    ("given", "value", "active"),
    [
        ({"rate": 1.9}, 2.0, ("speed",)),
        ({"rate": 2.2}, 2.0, ("speed",)),
        ({"rate": 0.0}, STEP, ("speed", "acceleration")),
        ({"rate": -0.5}, -0.5 + STEP, ("speed", "acceleration")),
        ({"rate": 0.5, "tension": 200e3, "power_limit": 100e3}, 0.5, ("power",)),
        ({"rate": 0.0, "power_limit": 1e9}, STEP, ("speed", "acceleration")),
    ],
    ids=[
        "speed",
        "faster than its speed",
        "acceleration",
        "acceleration while it hauls in",
        "power",
        "no power limit yet",
    ],
)
def test_a_command_beyond_a_limit_leaves_at_it_with_its_name_in_both_directions(given, value, active):
    """P = T v: 100 kW at 200 kN are 0.5 m/s."""
    governed = govern(30.0, **given)
    assert governed.value == pytest.approx(value)
    assert governed.active == active
    mirrored = govern(-30.0, **{**given, "rate": -given["rate"]})
    assert mirrored.value == pytest.approx(-value)
    assert mirrored.active == active


@pytest.mark.parametrize(("payout", "most"), [(47.0, math.sqrt(1.5 * 2.0)), (48.9, 0.1 / (4.0 * LAG)), (49.0, 0.0)])
def test_towards_an_end_of_the_range_it_leaves_at_a_speed_from_which_the_winch_can_stop(payout, most):
    """The range is 50 m less a margin of 1 m. Half of 1.5 m/s^2 over the room: v^2 = 1.5 x; near it x / (4 T)."""
    for way in (1.0, -1.0):
        governed = govern(way * 30.0, payout=way * payout, rate=way * 0.0)
        assert governed.value == pytest.approx(way * min(most, STEP), abs=1e-9)
        assert ("payout" in governed.active) == (most < 2.0)
        away = govern(-way * 0.2, payout=way * payout)
        assert tuple(away) == (-way * 0.2, (), -way * 0.2), "away from it nothing is held back"


def test_the_speed_it_has_takes_room_for_twice_the_lag_before_the_servo_brakes():
    """From 1.2 m/s towards an end, 1 m off: 1 - 1.2 * 2 T = 0.64 m are left; hauling away from it none is taken."""
    for way in (1.0, -1.0):
        towards = govern(way * 30.0, payout=way * 48.0, rate=way * 1.2)
        assert towards.value == pytest.approx(way * math.sqrt(1.5 * (1.0 - 1.2 * 2.0 * LAG)))
        away = govern(way * 30.0, payout=way * 48.9, rate=-way * 0.05)
        assert away.value == pytest.approx(way * 0.1 / (4.0 * LAG), abs=1e-9)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_beyond_the_end_of_its_range_it_is_ordered_back(way):
    """0.06 m beyond it: back with 0.06 / (4 T) = 0.1 m/s, whatever is wanted."""
    governed = govern(way * 0.2, payout=way * 49.06)
    assert governed.value == pytest.approx(-way * 0.06 / (4.0 * LAG))
    assert governed.active == ("payout",)


@pytest.mark.parametrize("gain", [0.5, 1.0])
def test_a_position_loop_takes_its_own_share_off_and_the_order_makes_up_for_it(gain):
    """It takes off k_p times the payout in the middle of the tick: 0.2 k_p + 0.4 * DT / 2 k_p."""
    taken = gain * (0.2 + 0.5 * 0.4 * DT)
    still = govern(taken + 0.4, payout=0.2, rate=0.4, position_gain=gain)
    assert still.active == ()
    assert still.value == pytest.approx(taken + 0.4)
    assert still.sent == pytest.approx(taken + 0.4)
    most = govern(30.0, payout=0.2, rate=1.95, position_gain=gain)
    assert most.value == pytest.approx(2.0 + gain * (0.2 + 0.5 * 1.95 * DT))
    assert most.sent == pytest.approx(most.value)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("rate", [-0.6, 0.0, 0.9])
def test_a_slow_servo_gets_the_set_point_that_takes_it_to_its_speed_within_the_tick(rate, way):
    """T = 1 s, 1.1 m/s: v + (s - v)(1 - exp(-dt/T)) = 1.1 at its end, unless the reach of 20 is too short for that."""
    slow = {"time_constant": 1.0, "speed_limit": 1.1, "acceleration_limit": 100.0, "set_point_reach": 20.0}
    slow |= {"payout_minimum": -200.0, "payout_maximum": 200.0}
    governed = govern(way * 1e3, rate=way * rate, command_delay=0.0, **slow)
    needed = rate + (1.1 - rate) / -math.expm1(-DT)
    assert governed.value == pytest.approx(way * min(needed, 22.0))
    assert governed.active == ("speed",)
    # one that is faster than its limit already is braked, by no more than a set-point within its limit
    assert govern(way * 1e3, rate=way * 1.3, command_delay=0.0, **slow).value == pytest.approx(-way * 1.1)


def test_no_set_point_of_a_limited_servo_is_sent_beyond_the_reach_of_the_winch():
    """To gain 1.5 m/s^2 over the tick from 1.95 m/s takes a set-point of 1.95 + 1.5 (T + dt) m/s: 2 m/s is the most."""
    for way in (1.0, -1.0):
        governed = govern(way * 30.0, rate=way * 1.8)
        assert governed.sent == pytest.approx(way * 2.0)
    assert govern(30.0).sent == pytest.approx(1.5 * (LAG + DT), rel=1e-4)


# the first-order winch of the thesis, ordered by its payout


FIRST = {"law": "first_order", "position_rate": 2.0, "speed_limit": 0.8, "power_limit": 100e3}


@pytest.mark.parametrize(
    ("wanted", "payout", "tension", "value", "active"),
    [
        (10.1, 10.0, 1e4, 10.1, ()),
        (10.4, 10.0, 1e4, 10.4, ()),
        (-10.4, -10.0, 1e4, -10.4, ()),
        (12.0, 10.0, 1e4, 10.4, ("speed",)),
        (-12.0, -10.0, 1e4, -10.4, ("speed",)),
        (12.0, 10.0, 250e3, 10.2, ("speed",)),
        (60.0, 48.9, 1e4, 49.0, ("payout",)),
        (-60.0, -48.9, 1e4, -49.0, ("payout",)),
        (60.0, 10.0, 1e4, 10.4, ("payout", "speed")),
    ],
    ids=["within", "at its speed out", "at its speed in", "out", "in", "power", "upper end", "lower end", "both"],
)
def test_a_first_order_winch_is_ordered_no_payout_that_takes_more_than_its_speed(
    wanted, payout, tension, value, active
):
    """u' = K (u_0 - u) with K = 2 / s: 0.8 m/s at 0.4 m off; 100 kW at 250 kN are 0.4 m/s, at 0.2 m off."""
    governed = govern(wanted, payout=payout, tension=tension, **FIRST)
    assert governed.value == pytest.approx(value)
    assert governed.sent == governed.value
    assert governed.active == active


@pytest.mark.parametrize("delay", [0.0, 0.05, 0.12, 0.25], ids=str)
@pytest.mark.parametrize("law", ["first_order", "speed_servo"])
def test_the_drum_is_foreseen_when_the_command_takes_effect(law, delay):
    """Against the winch's own equation in steps of 0.01 ms, under commands that differ from tick to tick."""
    winch = {"law": law, "position_rate": 2.0, "command_delay": delay}
    design = designed(**winch)
    model, x = design.model, np.zeros(design.model.order)
    commands = [0.3, -0.2, 0.4, 0.1, -0.3, 0.2, 0.35, -0.1]
    for command in commands:
        x = model.A @ x + model.B[:, 0] * command
    payout, rate, fine = 0.0, 0.0, 1e-5
    for step in range(round((len(commands) * DT + delay) / fine)):
        tick = math.floor((step * fine - delay) / DT + 1e-9)
        command = commands[tick] if tick >= 0 else 0.0
        if law == "first_order":
            rate = 2.0 * (command - payout)
        else:
            rate += (command - rate) / LAG * fine
        payout += rate * fine
    foreseen = governor_of(design).predict(x)
    assert foreseen[0] == pytest.approx(payout, abs=2e-4)
    if law == "speed_servo" or delay == 0.12:  # without inertia the speed is that under the command to come
        assert foreseen[1] == pytest.approx(rate, abs=2e-4)


@pytest.mark.parametrize("gain", [0.0, 0.8])
def test_the_standing_command_is_what_the_position_loop_takes_off(gain):
    design = designed(position_gain=gain)
    x = np.arange(1.0, design.model.order + 1.0)
    payout, _ = governor_of(design).predict(x)
    assert standing_command(design.model, design.parameters.winch) @ x == pytest.approx(gain * payout)
