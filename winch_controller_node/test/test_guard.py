"""The guard: what it takes for harm, what it leaves alone, and how it tries again."""

import math
import re

import numpy as np
import pytest
from winch_controller_node.core.supervision.guard_checks import GuardedLoop
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.parameters.laws import GuardParameters

from tests.supervised import Judge, Seen

DT = 0.05


def seen(unit, free, tip, payout_rate=0.0, measured=math.nan, noise=0.0, **more):
    """Return what a guard sees; `unit`, `free` and `tip` are heave [m] and rate [m/s]."""
    return Seen(*unit, *free, *tip, payout_rate, math.nan if measured is None else measured, noise, **more)


def figures(words):
    """Return the whole numbers in `words`."""
    return [int(one) for one in re.findall(r"\d+", words)]


def make_guard():
    limits = WinchLimits(2.0, 1.5, -50.0, 50.0)
    return Judge(GuardParameters(window=20.0, floor=0.02), GuardedLoop(limits), tick_period=DT)


def feed_guard(guard, residual, uncompensated, seconds, authority=1.0, rate=0.3, target=1.0):
    for k in range(round(seconds / DT)):
        wave = np.sin(0.7 * k * DT)
        motions = seen(
            (residual * wave, 0.0),
            (uncompensated * wave, 0.0),
            (0.0, rate * wave),
            authority * rate * wave,
        )
        guard.update(motions, authority, target)


def test_the_guard_tolerates_a_small_residual_and_stops_a_harmful_one():
    guard = make_guard()
    feed_guard(guard, 0.02, 0.01, 100.0)
    assert not guard.inhibits
    feed_guard(guard, 0.2, 0.5, 100.0)
    assert not guard.inhibits
    feed_guard(guard, 0.8, 0.5, 60.0)
    assert guard.inhibits
    assert guard.alarm.name == "WORSE_THAN_OFF: swing"


@pytest.mark.parametrize(("residual", "is_harm"), [(0.92, False), (0.985, False), (0.995, True)])
def test_of_a_small_share_of_the_sea_no_more_is_asked_than_it_has_to_gain(residual, is_harm):
    """A tenth of the sea has a tenth to gain, of which a tenth is asked for, as of the whole: 1 %."""
    guard = make_guard()
    feed_guard(guard, residual, 1.0, 100.0, authority=0.1, target=0.1)
    assert guard.inhibits == is_harm
    assert not is_harm or (guard.alarm.name, guard.alarm.values["percent"]) == ("LITTLE_GAIN", pytest.approx(1.0))


def test_after_harm_the_next_attempt_has_half_the_authority_and_one_that_goes_well_gets_all_back():
    """By hand, of a residual of 0.005 m in 0.5 m: 1 / (1 + 1), and after 5 windows 1 / (1 + exp(-5)), which is all."""
    guard = make_guard()
    feed_guard(guard, 0.8, 0.5, 40.0)
    assert guard.inhibits
    feed_guard(guard, 0.5, 0.5, 1.0, authority=0.0)
    assert not guard.inhibits
    assert guard.authority_limit == pytest.approx(0.5, abs=0.01)
    assert guard.residual == pytest.approx(math.sqrt(0.5), abs=0.01)
    feed_guard(guard, 0.005, 0.5, 130.0)
    assert guard.authority_limit == 1.0


def test_it_is_tried_again_only_where_it_is_predicted_to_leave_less_than_nine_tenths():
    """A sea of 50 m/s for a winch of 2 m/s: 0.85 of 2 m/s over 2.2 sigma of the present group leaves 98 %."""
    guard = make_guard()
    assert guard.prospect == ""
    feed_guard(guard, 0.8, 0.5, 40.0, rate=50.0)
    assert guard.inhibits
    feed_guard(guard, 0.5, 0.5, 200.0, authority=0.0, rate=50.0)
    assert guard.inhibits
    assert figures(guard.prospect) == [98, 90]


@pytest.mark.parametrize(
    ("error", "heave", "authority"),
    [(0.001, 0.5, 1.0), (0.1, 0.5, 1.0), (0.5, 0.5, 0.5), (0.1, 0.05, 0.2)],
)
def test_authority_falls_with_errors_of_the_drum_over_the_motion_with_the_winch_locked(error, heave, authority):
    """A drum that is off by up to `error` [m] in a sea that heaves the unit by an amplitude `heave` [m].

    Variances of both amplitudes are half their squares: V = (error / heave)^2, and the best authority 1 / (1 + V).
    """
    guard = make_guard()
    for time in DT * np.arange(round(120.0 / DT)):
        wave = math.sin(0.7 * time)
        motions = seen((heave * wave, 0.0), (heave * wave, 0.0), (0.0, 0.3 * wave), drum_error=error)
        guard.update(motions, 0.0)
    assert guard.authority_limit == pytest.approx(authority, abs=0.03)
    assert "winch" in guard.cause


def test_harm_keeps_compensation_off_until_its_fade_out_has_damped_the_load():
    guard = make_guard()
    feed_guard(guard, 0.8, 0.5, 60.0)
    still = seen((0.0, 0.0), (0.0, 0.0), (0.0, 0.0))
    for _ in range(100):
        guard.update(still, 0.0, fades=True)
        assert guard.inhibits
    guard.update(still, 0.0)
    assert not guard.inhibits


def test_what_a_wrong_belief_has_done_is_not_held_against_the_loop_that_knows_better_now_and_a_growing_swing_is():
    """The sea has 0.3 m, the unit 0.6 m at the crest at which a sensor or a limit of the winch is known, 71.8 s."""

    def tried(growth, *, is_corrected):
        guard, known = make_guard(), 16.0 * math.pi / 0.7
        for time in DT * np.arange(round(90.0 / DT)):
            wave = math.cos(0.7 * time)
            amplitude = 0.01 if time < known - 0.3 else 0.6 * growth ** max(time - known, 0.0)
            if is_corrected and abs(time - known) <= 0.5 * DT:
                guard.allow_correction("winch")
            tip = (0.0, 0.3 * wave)
            guard.update(seen((amplitude * wave, 0.0), (0.3 * wave, 0.0), tip, tip[1]), 1.0)
        return guard

    assert not tried(0.7, is_corrected=True).inhibits
    assert tried(0.7, is_corrected=False).inhibits
    assert tried(1.15, is_corrected=True).inhibits


def test_a_belief_that_is_corrected_again_and_again_is_no_excuse():
    """The unit moves twice as much as the uncompensated one; every two seconds a belief is corrected."""
    guard = make_guard()
    feed_guard(guard, 0.01, 0.3, 60.0)
    for _ in range(45):
        feed_guard(guard, 0.6, 0.3, 2.0)
        guard.allow_correction("winch")
    assert guard.inhibits


@pytest.mark.parametrize(("belief", "is_allowed"), [("mru", True), ("winch", False)])
def test_another_belief_may_be_corrected_after_one_that_was_corrected_before(belief, is_allowed):
    """The winch is corrected at 31.8 s; the unit has 0.6 m at the crest at 71.8 s, twice what the sea has."""
    guard, known = make_guard(), 16.0 * math.pi / 0.7
    for time in DT * np.arange(round(90.0 / DT)):
        wave = math.cos(0.7 * time)
        amplitude = 0.01 if time < known - 0.3 else 0.6 * 0.7 ** max(time - known, 0.0)
        for corrected, when in (("winch", known - 40.0), (belief, known)):
            if abs(time - when) <= 0.5 * DT:
                guard.allow_correction(corrected)
        tip = (0.0, 0.3 * wave)
        guard.update(seen((amplitude * wave, 0.0), (0.3 * wave, 0.0), tip, tip[1]), 1.0)
    assert guard.inhibits is not is_allowed


@pytest.mark.parametrize(("ratio", "is_wild"), [(1.6, False), (0.3, True)])
def test_what_the_limits_of_the_winch_keep_out_of_reach_is_no_drum_that_runs_wild(ratio, is_wild):
    """A tip that asks for `ratio` times the winch's acceleration, and a drum that turns against it as fast as it can.

    Where the winch could have followed, that is wild.
    """
    guard, omega, limit = make_guard(), 1.05, 1.5
    speed = ratio * limit / omega
    # a triangle of the limited acceleration, half a wave late: what a drum does that is at its limit all the time
    for k in range(round(60.0 / DT)):
        time = k * DT
        tip = (0.0, speed * math.sin(omega * time))
        drum = -min(speed, 0.25 * limit * 2.0 * math.pi / omega) * math.cos(omega * time)
        guard.update(seen((0.0, 0.0), (0.5 * math.sin(omega * time), 0.0), tip, drum), 1.0)
    assert guard.inhibits is is_wild


def test_after_a_resumption_waves_are_compared_anew_once_the_swing_had_time_to_be_taken_out():
    """A tenth is to be gained: of 0.5 m by which nothing is. Half a minute is allowed, and half of 20 s is compared."""
    guard = make_guard()
    feed_guard(guard, 0.44, 0.5, 100.0)
    guard.allow_resumption()
    feed_guard(guard, 0.5, 0.5, 39.0)
    assert not guard.inhibits
    feed_guard(guard, 0.5, 0.5, 3.0)
    assert guard.alarm.name in ("LITTLE_GAIN", "WORSE_THAN_OFF: estimate")


def test_the_reason_is_told_while_compensation_is_kept_off_and_the_loop_that_is_watched_may_be_another():
    """Half the speed limit: the sea asks twice as much of that winch."""
    guard = make_guard()
    feed_guard(guard, 0.2, 0.5, 60.0)
    assert guard.reason == ""
    demand = guard.demand
    guard.take_loop(GuardedLoop(WinchLimits(1.0, 0.75, -50.0, 50.0)))
    assert guard.demand == pytest.approx(2.0 * demand)
    feed_guard(guard, 0.8, 0.5, 60.0)
    assert guard.reason == guard.alarm.brief != ""


def test_a_disagreement_is_told_with_its_culprit_once_that_is_known():
    """The depth sensor reads the uncompensated heave, the estimate of the unit none of it."""
    guard = make_guard()
    for time in DT * np.arange(round(40.0 / DT)):
        wave = 0.5 * math.cos(0.7 * time)
        guard.update(seen((0.0, 0.0), (wave, 0.0), (wave, 0.0), 0.0, measured=wave), 1.0)
    assert guard.alarm.name == "DEPTH_MRU_DISAGREE"
    guard.allow_correction("mru")
    assert (guard.alarm.name, guard.alarm.values) == ("DEPTH_MRU_EXPLAINED", {"part": "mru"})
