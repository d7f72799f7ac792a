"""Each part of `look` beside a library's formulation, and what holds for any input.

The unit stands beside `scipy.signal.cont2discrete` and scipy's integration of its equation, weighted means beside
`scipy.signal.lfilter`, the motions beside numpy on the rows of a random model.
"""

import math

import numpy as np
import pytest
from heave_core.look import Look, Motions, padded
from heave_core.look_table import Harm
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.signal import cont2discrete, lfilter

from tests.core_parts import HangingUnit, RunningSigma, part
from tests.supervised import Guard, Seen

DT = 0.05
INERTIA, DAMPING, DRAG, PUSH = 1.1, 0.06, 0.2, 1.2
ORDER = 7


def cable(push=math.inf, participation=1.0, drag=DRAG):
    """Return a sampled cable: outlet on a ramp within a tick, by the matrix exponential of scipy."""
    a, b = INERTIA, DAMPING
    joined = np.array([[0, 1, 0, 0], [-1 / a, -b / a, 1 / a, 0], [0, 0, 0, 1], [0, 0, 0, 0]], dtype=float)
    sampled = cont2discrete((joined, np.zeros((4, 1)), np.eye(4), np.zeros((4, 1))), DT)[0]
    return {
        "A": sampled[:2, :2],
        "B": sampled[:2, 2:],
        "drag": {"rate": 1, "inertia": a, "damping": b, "quadratic": drag, "tick_period": DT},
        "tick_period": DT,
        "participation": participation,
        "natural_inertia": a,
        "largest_push": push,
        "cable_share": 2.0 * (participation - 1.0),
    }


@pytest.mark.parametrize("push", [math.inf, PUSH], ids=["taut", "slack"])
def test_a_unit_moves_as_scipy_integrates_its_equation(push):
    """In resonance, where drag and a slack cable rule its motion."""
    frequency, times = INERTIA**-0.5, DT * np.arange(1200)
    unit, heaves = HangingUnit(cable(push)), []
    for time in times:
        heaves.append(unit.motion[0])
        unit.step(math.sin(frequency * time), frequency * math.cos(frequency * time))

    def rates(time, state):
        pull = max(math.sin(frequency * time) - state[0], -push)
        return [state[1], (pull - max(DAMPING, DRAG * abs(state[1])) * state[1]) / INERTIA]

    exact = solve_ivp(rates, (0.0, times[-1]), [0.0, 0.0], t_eval=times, rtol=1e-9, atol=1e-9, max_step=DT).y[0]
    assert np.array(heaves) == pytest.approx(exact, abs=DT * np.max(np.abs(exact)))


def test_a_unit_goes_on_from_where_it_is_put_below_an_outlet_that_moves():
    unit = HangingUnit(cable(participation=1.2))
    unit.step(0.4, 0.3)
    unit.continue_at(-1.5, 0.25)
    assert unit.motion == pytest.approx([-1.5, 0.25])


@given(st.lists(st.tuples(st.floats(-20.0, 20.0), st.floats(-8.0, 8.0)), max_size=60), st.booleans())
def test_no_motion_of_the_outlet_makes_a_unit_that_is_not_finite(outlets, has_slack):
    unit = HangingUnit(cable(PUSH if has_slack else math.inf, participation=1.1))
    for outlet in outlets:
        assert np.all(np.isfinite(unit.step(*outlet)))


def a_look(rng):
    """Return a Look on a random model, and its rows."""
    rows = {name: rng.standard_normal(ORDER) for name in ("tip", "tip_rate", "payout", "payout_rate")}
    design = {name: padded(row) for name, row in rows.items()} | {
        "order": ORDER,
        "unit": 2,
        "unit_rate": 4,
        "through": 0.7,
        "tick_period": DT,
        "tip_memory": 30.0,
        "noise_swing": 4.0,
        "taut_time": 20.0,
        "cable": cable(PUSH, 1.1),
        "taut_cable": cable(math.inf, 1.1),
    }
    return Looked(design), rows


class Looked(Look):
    """A look by itself: `step` does a tick of it."""

    def step(self, estimate, covariance, mean_state, *, command, knows_tip, takes_unit):
        self.inputs[0] = (*command, knows_tip, takes_unit)
        given = tuple(np.ascontiguousarray(one) for one in (estimate, mean_state, covariance))
        part("look")(self.design, self.state, self.inputs, given, self.motions)
        return Motions._make(self.motions.tolist())


def a_step(rng, **given):
    """Return the inputs of a tick of a random model."""
    half = rng.standard_normal((ORDER, ORDER))
    return {
        "estimate": rng.standard_normal(ORDER),
        "covariance": 1e-4 * half @ half.T,
        "mean_state": rng.standard_normal(ORDER),
        "command": (0.3, -0.2),
        "knows_tip": True,
        "takes_unit": False,
    } | given


@pytest.mark.parametrize("knows_tip", [True, False])
def test_motions_are_sums_of_rows_of_the_model(knows_tip):
    """Thesis, by linearity: what the mean payout brings about, and the rest."""
    rng = np.random.default_rng(1)
    looked, rows = a_look(rng)
    free, taut, hanging = (HangingUnit(cable(push, 1.1)) for push in (PUSH, math.inf, PUSH))
    power = 0.0
    for _ in range(50):
        given = a_step(rng, knows_tip=knows_tip)
        x, mean, P = given["estimate"], given["mean_state"], given["covariance"]
        found = looked.step(**given)
        tip = np.array([rows["tip"] @ x, rows["tip_rate"] @ x])
        drum = np.array([rows["payout"] @ x, rows["payout_rate"] @ x + 0.7 * 0.3])
        mean_drum = np.array([rows["payout"] @ mean, rows["payout_rate"] @ mean - 0.7 * 0.2])
        power += (tip[0] ** 2 - power) * DT / 30.0
        share = max(1.0 - 16.0 * rows["tip"] @ P @ rows["tip"] / power, 0.0)
        swing = mean_drum + mean[[2, 4]]
        locked = free.step(*tip)
        taut.step(*tip)
        taut.continue_at(*(taut.motion + DT / 20.0 * (locked - taut.motion)))
        hangs = mean[2] + hanging.step(*(tip - drum))[0]
        offset = swing + x[[2, 4]] + drum - (share * locked if knows_tip else 0.0)
        groups = (tip, drum, swing, swing + x[[2, 4]], locked, taut.motion, share * locked, offset)
        names = ("tip", "payout", "mean", "unit", "free", "taut", "released", "offset")
        for name, expected in zip(names, groups, strict=True):
            heave = {"mean": "mean_heave"}.get(name, name)
            assert (getattr(found, heave), getattr(found, f"{name}_rate")) == pytest.approx(tuple(expected), abs=1e-12)
        assert found.total_payout_rate == pytest.approx(drum[1] + mean_drum[1])
        assert found.mean_payout == pytest.approx(mean_drum[0])
        assert (found.hanging_heave, found.wave_share) == pytest.approx((hangs, share))
        assert found.hanging_stretch == pytest.approx(tip[0] - drum[0] - mean_drum[0] - hangs)


def moved(seed=2):
    """Return a Look that has gone on for a while, its last inputs, and the motions then."""
    rng = np.random.default_rng(seed)
    looked, _ = a_look(rng)
    for _ in range(40):
        given = a_step(rng)
        found = looked.step(**given)
    return looked, given, found


def again(looked, given):
    return looked.again(given["estimate"], given["mean_state"])


def test_a_tick_seen_again_is_the_same_until_something_jumps():
    looked, given, found = moved()
    assert again(looked, given) == found
    other = looked.again(given["estimate"] + 1.0, given["mean_state"])
    assert other.free == found.free and other.tip != found.tip


def test_a_share_begins_with_the_taut_unit_where_the_locked_one_is():
    looked, given, before = moved()
    assert before.taut != before.free
    looked.begin_share()
    found = again(looked, given)
    assert (found.taut, found.taut_rate) == pytest.approx((before.free, before.free_rate))


def test_the_locked_units_go_on_from_where_they_are_put():
    looked, given, _ = moved()
    looked.continue_shadow(0.7, -0.2)
    found = again(looked, given)
    assert (found.free, found.free_rate, found.taut, found.taut_rate) == pytest.approx((0.7, -0.2, 0.7, -0.2))


def hanging_of(looked):
    """Return heave and rate of the hanging unit."""
    twin = HangingUnit(cable(PUSH, 1.1))
    twin.unit[:] = looked.state["hanging"]
    return twin.motion


def test_the_hanging_unit_goes_on_from_where_it_is_put_and_nothing_else_moves():
    looked, given, before = moved()
    looked.continue_hanging(-0.4, 0.1)
    assert hanging_of(looked) == pytest.approx([-0.4, 0.1])
    assert again(looked, given) == before


def test_a_unit_that_is_elsewhere_is_so_with_the_winch_locked_too():
    looked, given, before = moved()
    hung = hanging_of(looked)
    looked.take_unit(2.0, 0.5)
    found = again(looked, given)
    assert (found.free, found.free_rate) == pytest.approx(
        (before.free + 2.0 - hung[0], before.free_rate + 0.5 - hung[1])
    )
    assert (found.taut, found.taut_rate) == pytest.approx((found.free, found.free_rate))
    assert hanging_of(looked) == pytest.approx([2.0, 0.5])


def test_a_boom_tip_that_is_known_again_lets_the_units_go_on_from_the_estimated_one():
    looked, _, _ = moved()
    given = a_step(np.random.default_rng(3), takes_unit=True)
    looked.step(**given)
    assert hanging_of(looked) == pytest.approx(given["estimate"][[2, 4]])


def test_another_sea_begins_with_a_boom_tip_that_has_not_moved():
    looked, _, _ = moved()
    looked.forget_waves()
    given = a_step(np.random.default_rng(3), estimate=np.zeros(ORDER))
    assert looked.step(**given).wave_share == 0.0


def test_a_running_sigma_is_the_low_pass_of_scipy_once_the_plain_average_is_over():
    """Both weights are beyond 1/count from the 61st value on: then the recursions are filters of the first order."""
    rng, weight, slow = np.random.default_rng(4), DT / 1.0, DT / 3.0
    values, sigma, found = rng.standard_normal(600), RunningSigma(1.0, DT, 3.0), []
    for value in values:
        sigma.add(value)
        found.append((float(sigma.memory["mean"][0]), sigma.sigma**2))
    found = np.array(found)
    start = 100
    mean, _ = lfilter([slow], [1, slow - 1], values[start:], zi=[(1 - slow) * found[start - 1, 0]])
    squares = (values[start:] - mean) ** 2
    variance, _ = lfilter([weight], [1, weight - 1], squares, zi=[(1 - weight) * found[start - 1, 1]])
    assert found[start:] == pytest.approx(np.column_stack([mean, variance]), rel=1e-9)


LIMIT = {"time": 2.0, "ratio": 1.2, "floor": 0.05}


def a_guard(**changed):
    """Return a guard of a winch with 2 m/s and 1.5 m/s^2."""
    return Guard(
        {
            "tick_period": DT,
            "window": 20.0,
            "seen_ticks": 200,
            "seen_time": 10.0,
            "slow_mean": 3.0,
            "speed": 2.0,
            "usual_speed": 2.0,
            "acceleration": 1.5,
            "effort_speed": 1.0,
            "effort_acceleration": 1.0,
            "rate_error": 0.0,
            "inertia": 1.0,
            "fade_time": 10.0,
            "feeds_back": 1,
            "drum": LIMIT,
            "swing": LIMIT,
            "depth": LIMIT,
            "mismatch": LIMIT,
            "catch_up_time": 15.0,
            "left_over_time": 30.0,
            "largest_left_over": 2.0,
            "restart": 0.1,
            "beyond": 0.02,
            "out_of_reach": 2.0,
            "swing_work": 2.0,
            "least_authority": 0.5,
            "detrend_time": 5.0,
            "largest_step": 0.2,
            "step_sigmas": 8.0,
            "step_speed": 4.0,
            "full_share": 0.95,
            "harm_ratio": 0.9,
            "floor": 0.005,
            "peak": 3.0,
            "significant": 2.0,
            "highest_time": 300.0,
            "group_time": 8.0,
            "group_peak": 2.2,
            "growing": 4.0,
            "growing_peak": 2.35,
            "first_look": 2400,
            "knot_ticks": 1,
            "limit_use": 0.85,
            "largest_demand": 1.4,
            "keeps_limits": 0.0,
            "unshown": 10.0,
            "worth": 0.01,
        }
        | changed
    )


NUMBERS = st.floats(-30.0, 30.0)
SEEN = st.builds(
    Seen,
    NUMBERS,
    NUMBERS,
    NUMBERS,
    NUMBERS,
    NUMBERS,
    NUMBERS,
    NUMBERS,
    NUMBERS | st.just(math.nan),
    st.floats(0.0, 1.0),
    mean_acceleration=NUMBERS,
    drum_error=NUMBERS,
    payout=NUMBERS,
    unknown=st.floats(0.0, 30.0),
)


@given(st.lists(st.tuples(SEEN, st.floats(0.0, 1.0), st.booleans()), min_size=1, max_size=40))
def test_whatever_is_seen_the_verdict_is_finite_and_an_authority_is_a_share(ticks):
    guard = a_guard()
    for seen, authority, inhibits in ticks:
        verdict = guard.step(seen, authority, 1.0, inhibits=inhibits)
        assert all(math.isfinite(one) for one in verdict)
        assert 0.0 <= verdict.authority <= 1.0 and 0.0 <= verdict.usual_authority <= 1.0
        # without authority 1 is left; what is not worth less authority may be beyond it
        most = 1.0 + guard.design["worth"][0]
        assert 0.0 <= verdict.best_authority <= verdict.allowed and 0.0 <= verdict.residual <= most
        assert 0 <= int(verdict.bits) <= sum(Harm)


@pytest.mark.parametrize("knot", [1, 3])
def test_a_sea_grows_by_the_sums_of_its_squares(knot):
    """The later half of what was seen has four times the energy of the earlier half, by numpy; each third is kept."""
    guard, rates = a_guard(knot_ticks=knot), np.sin(0.6 * DT * np.arange(1000)) * np.linspace(0.0, 1.0, 1000) ** 1.2
    for count, rate in enumerate(rates, start=1):
        verdict = guard.step(Seen(tip_rate=rate), 0.0, 1.0, inhibits=False)
        early = np.sum(rates[: (count + 1) // 2 // knot * knot] ** 2)
        if not np.sum(rates[:count] ** 2) - early > 4.0 * early:
            assert verdict.coming == verdict.demand
    assert verdict.coming > verdict.demand


def fed(guard, ticks=300, **given):
    """Feed a sea to a guard, in which compensation does no harm but what is `given`."""
    for k in range(ticks):
        wave = math.sin(0.7 * DT * k)
        seen = Seen(unit=0.01 * wave, free=wave, tip_rate=0.7 * wave, payout_rate=0.7 * wave)
        verdict = guard.step(seen._replace(**given), 1.0, 1.0, inhibits=False)
    return verdict


def test_a_guard_begins_again_with_nothing_but_the_authority_of_the_last_tick():
    guard, fresh = a_guard(), a_guard()
    fed(guard)
    guard.begin()
    fresh.state["authority"] = 1.0
    assert guard.state.tobytes() == fresh.state.tobytes()
    assert guard.verdict == fresh.verdict


def test_a_drum_that_catches_up_is_not_judged_for_fifteen_seconds():
    guard = a_guard()
    fed(guard)
    guard.allow_resumption()
    assert not Harm.DRUM_OFF & int(fed(guard, 299, payout_rate=5.0).bits)
    assert Harm.DRUM_OFF & int(fed(guard, 100, payout_rate=5.0).bits)


def test_after_a_resumption_neither_drum_nor_swing_nor_waves_are_held_against_the_loop():
    guard = a_guard()
    fed(guard)
    guard.allow_resumption()
    verdict = fed(guard, 1, unit=5.0)
    assert (verdict.bits, verdict.waves_time) == (0.0, 0.0)
    assert guard.state["left_over_swing"][0] > 1.0
    assert guard.state["is_corrected"][0] == 0.0, "once"


def test_depth_sensor_and_estimate_are_compared_again_after_a_correction():
    guard = a_guard()
    for k in range(400):
        guard.step(Seen(free=0.1, measured=math.sin(DT * k)), 1.0, 1.0, inhibits=False)
    assert guard.verdict.mismatch > 0.5
    guard.reset_mismatch()
    assert guard.step(Seen(free=0.1, measured=0.9), 1.0, 1.0, inhibits=False).mismatch == 0.0


motion = st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))


@given(motion, motion, st.floats(0.0, 1.0))
def test_the_authority_that_is_shown_is_that_of_unit_and_drum(free, tip, authority):
    """Of a unit at (1 - A) of its locked motion and a drum at A of the boom tip's it is A: by least squares."""
    assume(np.hypot(*free) + np.hypot(*tip) > 0.1)
    unit, drum = (1.0 - authority) * np.array(free), authority * np.array(tip)
    seen = Seen(*unit, *free, *tip, payout=drum[0], payout_rate=drum[1])
    assert a_guard().step(seen, 0.0, 1.0, inhibits=False).shown == pytest.approx(authority, abs=1e-9)


def test_a_unit_at_rest_in_a_resonance_shows_full_authority_and_one_in_short_waves_none():
    assert a_guard().step(Seen(free=2.0, tip=0.2), 0.0, 1.0, inhibits=False).shown > 0.98
    assert a_guard().step(Seen(free=0.1, tip=1.0), 0.0, 1.0, inhibits=False).shown < 0.02


@pytest.mark.parametrize(("unit", "is_read", "best"), [(0.02, True, 1.0), (0.02, False, 0.3), (2.0, True, 0.3)])
def test_what_is_not_known_of_the_sea_leaves_no_more_than_the_unit_shows(unit, is_read, best):
    """A V of 0.7 / 0.3 has its least residual at A = 0.3; a unit at rest shows that hardly any of it is there."""
    guard = a_guard()
    for k in range(2400):
        wave, rate = math.sin(0.37 * DT * k), 0.37 * math.cos(0.37 * DT * k)
        heave, speed = unit * wave, unit * rate
        seen = Seen(heave, speed, wave, rate, 0.2 * wave, 0.2 * rate, 0.2 * rate, heave if is_read else math.nan)
        verdict = guard.step(seen._replace(unknown=0.7 / 0.3), 1.0 if k else 0.0, 1.0, inhibits=False)
        if k == 40:
            assert verdict.best_authority == pytest.approx(0.3), "two seconds show nothing"
    assert verdict.best_authority == pytest.approx(best, abs=0.01)


@pytest.mark.parametrize(("share", "is_less"), [(0.27, False), (0.285, True)])
def test_an_error_by_a_share_of_the_motion_is_worth_less_authority_from_a_quarter_on(share, is_less):
    """sqrt(V) - sqrt(V / (1 + V)) = 0.01 at V = 0.0765, by bisection."""
    assert (a_guard().step(Seen(unknown=share**2), 0.0, 1.0, inhibits=False).best_authority < 1.0) == is_less
