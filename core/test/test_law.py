"""Governor, laws, command and mean payout beside another formulation, and what holds for any input.

The limited servo stands beside scipy's integration of its equation, the loop's answer to the mean payout beside
python-control, the last minute of orders beside `scipy.signal.lfilter`, a plan beside matrix products of numpy.
"""

import math

import control
import numpy as np
import pytest
from heave_core import law_table
from heave_core.envelope_table import MoveKind
from heave_core.filter import check_states
from heave_core.filter_table import STATES
from heave_core.law import Commander, Law, put
from heave_core.law_table import FOLLOWED, Asks, LawKind, Moved, RowKind, Shaped, Way
from heave_core.library import library, new
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.signal import lfilter

from tests.core_parts import LoopNow, act, governed_by, pose

DT, LAG, SPEED, ACCELERATION = 0.05, 0.15, 2.0, 1.5
N = 3
WINCH = {
    "is_first_order": 0,
    "tick_period": DT,
    "lag": LAG,
    "position_rate": 1.0,
    "position_gain": 0.0,
    "gain": 1.0,
    "hauling_gain": 1.0,
    "creep": 0.0,
    "reach": 1.0,
    "tick_share": -math.expm1(-DT / LAG),
    "linear_step": ACCELERATION * DT / -math.expm1(-DT / LAG),
    "speed": SPEED,
    "acceleration": ACCELERATION,
    "power": math.inf,
    "lowest": -50.0,
    "highest": 50.0,
    "least_tension": 0.0,
    "most_tension": math.inf,
    "static_tension": 40e3,
}


def winch_of(**changes):
    record = new(law_table.ACTIVE_WINCH)
    put(record, WINCH | changes)
    return record


ANY = (-math.inf, math.inf)


def governed(command, payout=0.0, rate=0.0, tension=40e3, within=(math.nan, math.nan), passes=ANY, **winch):
    return governed_by(winch_of(**winch), (command, payout, rate, tension, *within, *passes))


# governor


@given(st.floats(-3.0, 3.0), st.floats(-SPEED, SPEED))
def test_a_limited_servo_gains_under_what_is_sent_what_the_linear_one_gains_under_the_value(command, rate):
    """T v' = s - v within |v'| <= a: integrated up to where the limit lets go, and beyond."""
    value, sent, _ = governed(command, rate=rate)
    assume(abs(sent) < SPEED)  # the winch takes no set-point beyond it

    def limited(_, v):
        return np.clip((sent - v) / LAG, -ACCELERATION, ACCELERATION)

    reached = solve_ivp(limited, (0.0, DT), [rate], max_step=DT / 50, rtol=1e-8, atol=1e-10).y[0, -1]
    assert reached == pytest.approx(rate + (value - rate) * -math.expm1(-DT / LAG), abs=1e-4)


@given(st.floats(-9.0, 9.0), st.floats(-60.0, 60.0), st.floats(-3.0, 3.0), st.floats(0.0, 1e6), st.floats(1e4, 1e6))
def test_what_was_governed_stays_and_up_and_down_are_alike(command, payout, rate, tension, power):
    given_ = {"payout": payout, "rate": rate, "tension": tension, "power": power}
    value, sent, shaped = governed(command, **given_)
    again, sent_again, _ = governed(value, **given_)
    assert (again, sent_again) == pytest.approx((value, sent), abs=1e-12)
    assert (shaped == 0.0) == (value == command)
    mirrored = governed(-command, **given_ | {"payout": -payout, "rate": -rate})
    assert mirrored == pytest.approx([-value, -sent, shaped])


@given(st.floats(-9.0, 9.0), st.floats(0.0, 9.0), st.floats(-48.0, 48.0), st.floats(-1.9, 1.9))
def test_more_that_is_wanted_is_never_less_that_is_let_through(command, more, payout, rate):
    assert governed(command + more, payout, rate)[0] >= governed(command, payout, rate)[0]


@pytest.mark.parametrize("within", [(-0.2, 0.1), (0.0, 0.0)])
def test_a_fade_out_keeps_its_speeds_whatever_is_wanted(within):
    for command in (-5.0, 5.0):
        value, _, shaped = governed(command, within=within)
        assert value == within[command > 0.0]
        assert int(shaped) & Shaped.BY_FADING


@given(st.floats(-9.0, 9.0), st.floats(-SPEED, SPEED), st.floats(-0.6, 0.0), st.floats(0.01, 0.6))
def test_no_set_point_is_sent_beyond_what_the_envelope_lets_pass(command, rate, lowest, highest):
    winch = {"gain": 0.8, "hauling_gain": 1.2, "creep": 0.03}
    found = governed(command, rate=rate, passes=(lowest, highest), **winch)
    assert lowest - 1e-12 <= found[1] <= highest + 1e-12
    plain = governed(command, rate=rate, **winch)
    asks_more = not 0.03 + 0.96 * lowest <= command <= 0.03 + 0.8 * highest
    assert bool(int(found[2]) & Shaped.BY_BOUNDS) == asks_more
    if not asks_more and lowest < plain[1] < highest:
        assert found == plain


def test_a_payout_of_a_first_order_winch_is_sent_no_further_from_the_drum_than_the_envelope_lets_pass():
    value, sent, shaped = governed(9.0, payout=2.0, is_first_order=1, passes=(-0.3, 0.4))
    assert (value, sent, int(shaped)) == (2.4, 2.4, Shaped.BY_BOUNDS)


# laws


def law_of(kind, winch=None, **values):
    law = Law(winch_of() if winch is None else winch, N)
    put(law.law, {"kind": kind, "unit": [0, 1], **values})
    return law


def command_of(law, x, reference=(0.0, 0.0, 0.0), *, mru_rate=0.0, speed=math.inf):
    law.pose((*reference, 40e3, math.nan, mru_rate, 1.0, speed), x)
    return law.ask(), float(law.state["command"][0])


states = st.lists(st.floats(-2.0, 2.0), min_size=N, max_size=N).map(np.array)
GAIN = np.array([0.5, -1.5, 0.7])


@given(states, st.floats(0.05, 2.0))
def test_of_a_feedback_the_share_of_the_unit_alone_is_bounded(x, share):
    law = law_of(LawKind.FEEDBACK_LAW, gain=GAIN, unit_share=share)
    asks, command = command_of(law, x)
    assert asks == 0
    unit = -GAIN[:2] @ x[:2]
    assert command == pytest.approx(-GAIN[2] * x[2] + np.clip(unit, -share * SPEED, share * SPEED))


@given(states, st.floats(-2.0, 2.0))
def test_a_linear_law_is_a_row_of_the_state_and_a_share_of_the_reading(x, rate):
    law = law_of(LawKind.LINEAR_LAW, gain=GAIN, reading_share=1.0)
    assert command_of(law, x, mru_rate=rate)[1] == pytest.approx(rate - GAIN @ x)


def test_a_law_that_the_core_does_not_know_is_asked_elsewhere():
    assert command_of(law_of(LawKind.ANOTHER_LAW), np.zeros(N))[0] == Asks.NEEDS_LAW
    assert command_of(law_of(LawKind.NO_LAW), np.ones(N)) == (0, 0.0)


KINDS = 4
"""Rows of each kind."""


def planning(rows, winch=None, **values):
    return law_of(
        LawKind.CONSTRAINED_LAW,
        winch,
        constrained=GAIN,
        free_less_constrained=0.5 * GAIN,
        kept=0.9,
        standing=np.array([0.0, 0.0, 1.0]),
        ends=KINDS * np.arange(1, RowKind.PLAN_KINDS + 1),
        times=DT * np.arange(KINDS),
        rows=rows.T.ravel(),
        **values,
    )


@given(states, st.floats(-1.0, 1.0), st.floats(-0.5, 0.5), st.integers(0, 2**32 - 1))
def test_a_plan_is_asked_for_where_its_rows_leave_their_bounds_and_only_there(x, payout, rate, seed):
    """Bounds by the definition of each row: speed, acceleration, set-point, payout and tension about their means."""
    rows = np.random.default_rng(seed).standard_normal((KINDS * RowKind.PLAN_KINDS, N))
    law = planning(rows, winch_of(most_tension=41e3, least_tension=39e3, lowest=-2.0, highest=2.0))
    asks, command = command_of(law, x, (payout, rate, rate + 0.1))
    planned = (rows @ x).reshape(-1, KINDS)
    linear = WINCH["linear_step"] / LAG
    mean = np.array([rate, 0.1 / LAG, rate + 0.1, 0.0, 0.0])[:, None] * np.ones(KINDS)
    mean[RowKind.PLANNED_PAYOUT] = payout + rate * DT * np.arange(KINDS)
    most = np.array([SPEED, linear, SPEED, 2.0, 1e3])[:, None]
    beyond = np.abs(planned + mean) - most
    assume(np.min(np.abs(beyond)) > 1e-9)
    assert asks == (Asks.NEEDS_PLAN if np.any(beyond > 0.0) else 0)
    if not asks:
        least = x[2] - 0.1 - ACCELERATION * LAG
        assert command == pytest.approx(np.clip(-1.5 * GAIN @ x, least, least + 2.0 * ACCELERATION * LAG))


def test_the_correction_of_a_plan_is_followed_until_the_next_solution():
    rows = np.zeros((KINDS * RowKind.PLAN_KINDS, N))
    rows[0, 0] = 10.0
    law = planning(rows, solve_ticks=3)
    x = np.array([1.0, 0.0, 0.0])
    assert command_of(law, x)[0] == Asks.NEEDS_PLAN
    put(law.state, {"has_plan": 1, "plan_age": 0, "correction": np.arange(1.0, FOLLOWED + 1)})
    law.follow_plan()
    followed = [float(law.state["command"][0])]
    for _ in range(2):
        asks, command = command_of(law, x)
        assert asks == 0
        followed.append(command)
    assert followed == pytest.approx(np.array([1.0, 2.0, 3.0]) - GAIN[0])
    assert law.state["plan_age"][0] == 2
    assert command_of(law, x)[0] == Asks.NEEDS_PLAN


def test_the_gain_slides_back_to_the_free_one():
    law = planning(np.zeros((KINDS * RowKind.PLAN_KINDS, N)))
    put(law.state, {"freedom": 0.0})
    for tick in range(1, 30):
        command_of(law, np.zeros(N))
        assert law.state["freedom"][0] == pytest.approx(1.0 - 0.9**tick)


# command


COMMAND = {
    "payout": 2,
    "unit": [0, 1],
    "payout_row": [0.0, 0.0, 1.0],
    "payout_ahead": [0.0, 0.0, 1.0],
    "rate_ahead": [0.0, 0.0, 0.0],
    "stiffness": 1e5,
    "giving_time": 1.0,
    "stop_step": 0.5 * DT,
    "longest_fade": 20.0,
    "minute": 60.0,
    "more_travel": 1.2,
    "more_room": 0.1,
    "quicker": 1.5,
    "more_acceleration": 0.3,
}


def commander_of(winch=None, **law):
    winch = winch_of() if winch is None else winch
    core = Commander(winch, N, law_of(LawKind.LINEAR_LAW, winch, **law), new(law_table.COMMAND_STATE))
    put(core.design, COMMAND)
    return core


def ordered(core, rate, way=Way.BY_LAW, **loop):
    """Return what is made of a wanted `rate` [m/s]."""
    act(core, LoopNow(way, share=1.0, mru_rate=rate, **loop))
    return core.made


@given(st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=300))
def test_the_travel_of_the_last_minute_is_a_leaky_integral_of_the_speed(rates):
    core = commander_of(reading_share=1.0)
    speeds = [ordered(core, rate).value for rate in rates]
    travel = DT * lfilter([1.0], [1.0, -(1.0 - DT / 60.0)], speeds)
    assert core.state["travel"][0] == pytest.approx(travel[-1], abs=1e-12)
    assert core.state["speed"][0] == speeds[-1]


@given(st.lists(st.floats(-2.0, 2.0), min_size=1, max_size=60), st.floats(-2.0, 2.0))
def test_a_stop_is_a_ramp_from_the_last_speed_whatever_the_law_wants(rates, wanted):
    core = commander_of(reading_share=1.0)
    speed = [ordered(core, rate).value for rate in rates][-1]
    for tick in range(1, 100):
        made = ordered(core, wanted, Way.BY_SLOWING)
        assert made.value == pytest.approx(math.copysign(max(abs(speed) - tick * 0.5 * DT, 0.0), speed), abs=1e-12)


@given(st.lists(st.floats(-2.0, 2.0), min_size=5, max_size=100), st.floats(-2.0, 2.0))
def test_in_a_fade_out_no_speed_is_larger_than_in_the_minute_before_and_it_ends(rates, wanted):
    core = commander_of(reading_share=1.0)
    speeds = [ordered(core, rate).value for rate in rates]
    largest, last = max(map(abs, speeds)), abs(speeds[-1])
    for tick in range(1, round(20.0 / DT) + 1):
        speed = abs(ordered(core, wanted, fades=True).value)
        assert speed <= max(largest * (1.0 - tick * DT / 20.0), last - 0.5 * DT) + 1e-9
        last = speed
    assert last <= 1e-9


def test_what_is_read_above_the_highest_tension_is_paid_out():
    core = commander_of(winch_of(most_tension=50e3))
    made = ordered(core, 0.0, filtered_tension=60e3, gives_way=True)
    assert (made.asked, made.gives_way) == (pytest.approx(10e3 / 1e5), 1.0)
    assert ordered(core, 0.0, filtered_tension=60e3).gives_way == 0.0


def test_a_lead_of_the_drum_is_motion_of_the_mean():
    """The law is left with the payout beyond; the drum itself is where it is, and the cable is as much looser."""
    core = commander_of(reading_share=1.0)
    core.records["loop"]["estimate"][0, :N] = 0.1, 0.3, 0.5
    core.records["loop"]["lead_state"][0, :N] = 7.0, 8.0, 0.4
    pose(core, LoopNow(Way.BY_LAW, share=1.0, mean_command=0.2, lead_command=0.1))
    found = core.problem[0]
    assert (found["payout"], found["command"]) == pytest.approx((0.4, 0.3))
    assert found["static_tension"] == pytest.approx(40e3 - 1e5 * 0.4)
    assert found["x"][:N] == pytest.approx([0.1, 0.3, 0.1])
    assert core.made.payout == 0.5


# mean payout


def stable(seed):
    random = np.random.default_rng(seed)
    A = random.standard_normal((N, N))
    return np.ascontiguousarray(0.9 * A / np.max(np.abs(np.linalg.eigvals(A)))), random.standard_normal(N)


@given(st.integers(0, 2**32 - 1), st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=40))
def test_the_loop_answers_to_the_mean_payout_as_python_control_says(seed, commands):
    A, B = stable(seed)
    motion = new(law_table.MEAN_MOTION)
    put(motion["mean"], {"tick_period": DT, "jerk_time": 0.0})
    put(motion["left_over"], {"tick_period": DT, "jerk_time": 0.0})
    addresses = A.ctypes.data, B.ctypes.data, motion.ctypes.data
    found = [motion["state"][0, :N].copy()]
    for command in commands:
        assert library().heave_core_advance_motion(*addresses, N, command, 0) == 0
        found.append(motion["state"][0, :N].copy())
    plant = control.ss(A, B[:, None], np.eye(N), np.zeros((N, 1)), DT)
    answer = control.forced_response(plant, inputs=np.array([[*commands, 0.0]]))
    np.testing.assert_allclose(np.array(found).T, answer.states, atol=1e-12)


@given(st.floats(-20.0, 20.0), st.floats(0.0, 2.0), st.integers(0, 200))
def test_the_payout_is_the_integral_of_its_rate_and_a_halt_ends_where_it_says(distance, jerk_time, ticks):
    mean = new(law_table.MEAN_PAYOUT)
    put(mean, {"tick_period": DT, "jerk_time": jerk_time})
    put(mean["move"], {"kind": MoveKind.GO, "distance": distance, "speed": 0.5, "acceleration": 0.1})
    rates = [0.0]
    for _ in range(ticks):
        assert not library().heave_core_advance_mean(mean.ctypes.data)
        rates.append(float(mean["move"]["rate"][0]))
    assert mean["payout"][0] == pytest.approx(np.trapezoid(rates, dx=DT), abs=1e-4)
    put(mean["move"], {"kind": MoveKind.HALT, "acceleration": 0.2})
    began, needed = float(mean["payout"][0]), abs(rates[-1]) / 0.2
    halted = 0
    while not library().heave_core_advance_mean(mean.ctypes.data):
        halted += 1
    assert halted * DT == pytest.approx(needed, abs=DT + 1e-9)
    assert abs(mean["payout"][0] - began) == pytest.approx(rates[-1] ** 2 / 0.4, abs=0.01)
    assert not library().heave_core_is_moving(mean.ctypes.data)


def test_a_halt_of_the_mean_is_reported_once_and_a_brake_holds_both():
    A, B = stable(1)
    motion = new(law_table.MEAN_MOTION)
    for name in ("mean", "left_over"):
        put(motion[name], {"tick_period": DT})
    put(motion["mean"]["move"], {"kind": MoveKind.HALT, "rate": 0.01, "acceleration": 1.0})
    addresses = A.ctypes.data, B.ctypes.data, motion.ctypes.data
    assert library().heave_core_advance_motion(*addresses, N, 0.0, 1) == 0
    assert motion["mean"]["move"]["rate"][0] == 0.01
    found = [library().heave_core_advance_motion(*addresses, N, 0.0, 0) for _ in range(2)]
    assert found == [Moved.MEAN_MOVED | Moved.HALT_ENDED, 0]


def test_more_states_than_fit_are_refused_in_a_sentence():
    with pytest.raises(
        ValueError, match=rf"^law: {STATES + 1} states, and at most {STATES} fit: .*command_delay"
    ) as refusal:
        check_states(STATES + 1, "law")
    assert "\n" not in str(refusal.value)
