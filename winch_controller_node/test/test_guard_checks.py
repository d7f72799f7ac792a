"""The guard's checks over seconds, each alone: what a drum may do, and what a unit may swing."""

import math

import numpy as np
import pytest
from heave_core.look_table import Harm
from winch_controller_node.core.supervision.guard_checks import GuardedLoop, guard_design
from winch_controller_node.laws.parts.winch_limits import WinchLimits
from winch_controller_node.parameters.laws import GuardParameters

from tests.supervised import Guard, Judge, Seen

DT = 0.05
LIMITS = WinchLimits(2.0, 1.5, -50.0, 50.0)
FULL = 1.0


class Checks:
    """The guard's checks of a loop, which nothing keeps off."""

    def __init__(self, loop, window, floor=0.02):
        self.core = Guard(guard_design(GuardParameters(window=window, floor=floor), loop, DT))

    def step(self, seen, authority=FULL):
        """Take in a tick; return what is found."""
        self.verdict = self.core.step(seen, authority, FULL, inhibits=False)
        return self.found

    @property
    def found(self):
        return Harm(int(self.verdict.bits))

    @property
    def drum_is_off(self):
        return Harm.DRUM_OFF in self.found


def times(seconds):
    return DT * np.arange(round(seconds / DT))


@pytest.mark.parametrize(("speed", "is_beyond"), [(1.4, False), (2.2, True)])
def test_a_sea_is_out_of_reach_where_it_asks_for_more_speed_than_the_winch_has(speed, is_beyond):
    """At 0.3 rad/s the acceleration is no limit: 0.66 of 1.5 m/s^2; the speed is one, 2 m/s."""
    checks, found = Checks(GuardedLoop(LIMITS), 20.0), []
    assert not checks.core.state["is_out_of_reach"][0]
    for time in times(40.0):
        rate = speed * math.sin(0.3 * time)
        checks.step(Seen(tip_rate=rate, payout_rate=rate))
        found.append(bool(checks.core.state["is_out_of_reach"][0]))
    assert any(found) is is_beyond
    # 2.2 sin x > 2 for 2 (90 deg - asin(2/2.2)) of each half wave, a share of 0.27
    assert not is_beyond or 0.2 < np.mean(found) < 0.3


def fade(drum, seconds=8.0):
    """Let authority rise at 0.1 1/s, tip and uncompensated unit 5 m up; the drum runs at the speed `drum` [m/s]."""
    checks = Checks(GuardedLoop(LIMITS, fade_time=10.0), 4.0)
    for time in times(seconds):
        checks.step(Seen(free=5.0, tip=5.0, tip_rate=0.01, payout_rate=drum), 0.1 * (time + DT))
    return checks


def test_while_authority_moves_the_drum_is_to_take_the_unit_to_its_new_share_of_the_motion():
    """A' (3 tip - 2 free) = 0.1 (15 - 10) m/s; what it does otherwise is held against it with its size."""
    assert not fade(0.5).drum_is_off
    for drum in (0.0, 1.0):
        checks = fade(drum)
        assert checks.drum_is_off
        assert checks.verdict.drum == pytest.approx(0.5, rel=0.05)


def test_authority_that_jumps_asks_the_drum_for_no_more_than_one_that_fades():
    checks = Checks(GuardedLoop(LIMITS, fade_time=10.0), 4.0)
    for _ in times(8.0):
        checks.core.state["authority"] = 0.0
        checks.step(Seen(free=5.0, tip=5.0, tip_rate=0.01, payout_rate=0.5), 0.5)
    assert not checks.drum_is_off


def test_a_drum_may_take_the_unit_out_of_its_swing_while_authority_moves_and_for_seconds_after_it():
    """a = 4 s^2, a free swing of 1 m: 1.5 sqrt((2^2 + 1)/4) = 1.7 m/s may be then, 1.5 sqrt(1/4) = 0.75 later."""
    checks, found = Checks(GuardedLoop(LIMITS, inertia=4.0), 4.0), []
    for time in times(30.0):
        checks.step(Seen(free=1.0, payout_rate=1.2), 1.0 + 1e-9 * min(time, 10.0))
        found.append(checks.drum_is_off)
    assert not any(found[: round(11.0 / DT)])
    # e^(-t/3 s) over a memory of 4 s is 4 e^(-t/4 s) - 3 e^(-t/3 s), which is 1.2^2/1.5^2 - 0.25 at 7.2 s
    assert found.index(True) * DT == pytest.approx(17.2, abs=0.3)
    assert all(found[round(20.0 / DT) :])


def run_wild(loop, seconds, swing=0.0):
    """Let a drum run at 1.2 m/s over a still boom tip, with a `swing` of the unit [m]; return the checks."""
    checks = Checks(loop, 4.0)
    checks.core.state["authority"] = FULL
    for _ in times(seconds):
        checks.step(Seen(unit=swing, payout_rate=1.2))
    return checks


def test_a_drum_that_runs_wild_is_found_as_soon_as_half_the_time_of_the_waves_was_seen():
    """From the start on nothing is allowed: no swing, no speed to be gained, no limit that was left behind."""
    for inertia in (0.0, 4.0):
        assert not run_wild(GuardedLoop(LIMITS, inertia=inertia), 2.0 - DT).drum_is_off
        checks = run_wild(GuardedLoop(LIMITS, inertia=inertia), 2.0)
        assert checks.drum_is_off
        assert checks.verdict.drum == pytest.approx(1.2)


def test_on_a_cable_that_is_not_known_no_drum_is_allowed_to_stop_a_swing():
    assert run_wild(GuardedLoop(LIMITS), 20.0, swing=1.0).drum_is_off


def test_the_drum_of_a_law_that_does_not_feed_the_unit_back_is_not_judged():
    assert not run_wild(GuardedLoop(LIMITS, feeds_back_unit=False), 20.0).drum_is_off


@pytest.mark.parametrize("acceleration", [1.0, -1.0])
def test_a_drum_may_let_the_unit_gain_speed_with_the_mean_payout_for_some_seconds_after_it(acceleration):
    """a = 4 s^2: 4 m/s^2 over 2 s are 2 m/s, which fade within sqrt(a) = 2 s.

    Their mean square over a memory of 4 s is (16/3) e^(-t/4 s) m^2/s^2 then, which is 1.2^2/1.5^2 at 8.5 s.
    """
    checks, found = Checks(GuardedLoop(LIMITS, inertia=4.0), 4.0), []
    for time in times(60.0):
        checks.step(Seen(payout_rate=1.2, mean_acceleration=acceleration if time < 40.0 else 0.0))
        found.append(checks.drum_is_off)
    assert found.index(True) * DT - 40.0 == pytest.approx(8.5, abs=0.3)


@pytest.mark.parametrize(
    ("acceleration", "rate", "speed", "is_off"),
    [(0.05, 0.0, 0.41, False), (0.05, 0.0, 0.46, True), (0.0, 0.1, 0.44, False), (0.0, 0.1, 0.49, True)],
)
def test_cable_that_lets_the_unit_gain_speed_may_be_paid_out_as_quickly_as_the_winch_accelerates(
    acceleration, rate, speed, is_off
):
    """a = 7 s^2: 0.35 m for 0.05 m/s^2, at 1.5 m/s^2 with a peak of 0.725 m/s; 0.265 m for 0.1 m/s, with 0.63 m/s.

    The square of a triangle is a third of that of its peak in the mean: over 2 s 0.0845 and 0.0556 m^2/s^2. A unit at
    0.1 m/s may be stopped with 2 * 0.1 m/s beside. Allowed are 1.5 sqrt(0.0845) = 0.436, 1.5 sqrt(0.0956) = 0.464 m/s.
    """
    checks = Checks(GuardedLoop(LIMITS, inertia=7.0), 4.0)
    checks.core.state["authority"] = FULL
    found = False
    for _ in times(40.0):
        checks.step(Seen(unit_rate=rate, payout_rate=speed, mean_acceleration=acceleration))
        found = found or checks.drum_is_off
    assert found is is_off


@pytest.mark.parametrize("inertia", [0.25, 4.0])
@pytest.mark.parametrize(("share", "is_allowed"), [(0.2, False), (0.6, True)])
def test_stopping_a_unit_that_swings_is_no_harm_of_the_drum(share, is_allowed, inertia):
    """A drum of 1.2 m/s is allowed from 1.5 sqrt(4 z^2/a) m/s on: a swing z of 0.4 sqrt(a)."""
    checks = run_wild(GuardedLoop(LIMITS, inertia=inertia), 20.0, swing=share * math.sqrt(inertia))
    assert checks.drum_is_off is not is_allowed


HARM_TO_UNIT = Harm.SWING_HIGH | Harm.DEPTH_HIGH


def unit_checks():
    return Checks(GuardedLoop(LIMITS, inertia=1.0), 20.0, floor=0.001)


def feed(checks, seconds, *, unit, free, authority=1.0, reads=math.nan, is_out_of_reach=False, begin=0.0):
    """Feed waves of 1 rad/s on a cable with a = 1 s^2: the swing is the amplitude. Return when harm shows.

    A boom tip at 1e3 m/s is out of the winch's reach.
    """
    for time in times(seconds):
        wave, slope = math.sin(begin + time), math.cos(begin + time)
        rate = 1e3 if is_out_of_reach else 0.0
        given = Seen(unit * wave, unit * slope, free * wave, free * slope, 0.0, rate, rate, reads * wave)
        if checks.step(given, authority) & HARM_TO_UNIT:
            return time
    return None


def mismatch(checks):
    """Return by how much depth sensor and estimate disagree [m]; None: they agree."""
    return checks.verdict.mismatch if Harm.DISAGREE in checks.found else None


@pytest.mark.parametrize(("error", "is_reported"), [(0.7, False), (0.95, True)])
def test_depth_sensor_and_estimate_disagree_from_four_fifths_of_the_uncompensated_heave_on(error, is_reported):
    checks = unit_checks()
    feed(checks, 60.0, unit=0.0, free=1.0, reads=error)
    assert (mismatch(checks) is not None) is is_reported
    # standard deviation of a sine; the mean is followed within 5 s, which leaves 0.98 of it
    assert not is_reported or mismatch(checks) == pytest.approx(0.98 * 0.95 / math.sqrt(2.0), rel=0.05)


def test_a_corrected_disagreement_is_compared_anew_without_what_was_read_before():
    checks = unit_checks()
    feed(checks, 60.0, unit=0.0, free=1.0, reads=0.95)
    assert mismatch(checks) is not None
    checks.core.reset_mismatch()
    feed(checks, DT, unit=0.0, free=1.0, reads=0.0)
    assert mismatch(checks) is None
    feed(checks, 60.0, unit=0.0, free=1.0, reads=0.0)
    assert mismatch(checks) is None


def test_a_corrected_disagreement_leaves_no_heave_behind():
    """A sensor that reads four times the heave is corrected at a crest, and reads the truth from then on."""
    checks = unit_checks()
    feed(checks, 18.5 * math.pi, unit=0.0, free=1.0, reads=4.0, authority=0.0)
    assert mismatch(checks) is not None
    checks.core.reset_mismatch()
    for _ in range(20):
        feed(checks, 1.0, unit=0.0, free=1.0, reads=0.0, authority=0.0)
        assert mismatch(checks) is None


def test_noise_of_the_depth_sensor_that_is_known_is_no_heave_of_the_unit():
    """It reads 0.6 m up and down in turn, of a still unit in a sea of 0.5 m: more than 1.3 times its 1 sigma."""
    checks = unit_checks()
    for tick, time in enumerate(times(60.0)):
        free, rate = 0.5 * math.sin(time), 0.5 * math.cos(time)
        reads = 0.6 * (-1.0) ** tick
        assert Harm.DEPTH_HIGH not in checks.step(Seen(free=free, free_rate=rate, measured=reads, noise=0.6))


def test_a_swing_above_the_sea_is_found_at_the_start_as_later():
    """0.8 m over 0.5 m; half the time of the waves is 10 s, and nothing was left over that could be allowed."""
    assert feed(unit_checks(), 30.0, unit=0.8, free=0.5) == pytest.approx(10.0, abs=2.0 * DT)


def test_a_unit_that_moves_with_the_sea_while_the_winch_stands_has_no_swing_of_its_own_to_be_allowed():
    """0.8 m over 0.5 m are 1.6, and 1.2 is the most; a swing of its own of 0.5 m would make that 1.2 (0.5 + 0.5) m."""
    checks = unit_checks()
    feed(checks, 60.0, unit=0.5, free=0.5, authority=0.0)
    begun = feed(checks, 10.0, unit=0.8, free=0.5, authority=0.5)
    assert begun is not None and begun < 6.0
    assert checks.found == Harm.SWING_HIGH


def test_a_swing_of_its_own_while_the_winch_stands_is_given_half_a_minute():
    """Its 1.1 m less the sea's 0.5 m: 1.2 (0.5 + 0.6) = 1.32 m may be at first, e^-1 of the 0.6 m after 30 s."""
    checks = unit_checks()
    feed(checks, 60.0, unit=1.1, free=0.5, authority=0.0)
    begun = feed(checks, 60.0, unit=1.1, free=0.5)
    # 1.2 (0.5 + 0.6 e^(-t/30 s)) = 1.1 m at t = 11 s
    assert begun == pytest.approx(11.0, abs=3.0)


def test_what_a_wave_beyond_the_limits_has_left_is_allowed_once_and_what_stays_is_not():
    """1.0 m: twice the uncompensated 0.5 m, which is the most that is allowed to begin with."""
    checks = unit_checks()
    feed(checks, 60.0, unit=0.01, free=0.5)
    assert feed(checks, 5.0, unit=1.0, free=0.5, is_out_of_reach=True) is None
    begun = feed(checks, 120.0, unit=1.0, free=0.5, is_out_of_reach=True, begin=5.0)
    # 1.2 (0.5 + 1.0 e^(-t/30 s)) = 1.0 m at t = 33 s
    assert begun == pytest.approx(28.0, abs=6.0)


def test_harm_over_waves_is_told_from_half_the_window_on():
    """By a law that does not feed the unit back, whose swing is not judged over seconds."""
    loop = GuardedLoop(LIMITS, feeds_back_unit=False)
    guard, harms = Judge(GuardParameters(window=20.0, floor=0.02), loop, tick_period=DT), []
    for time in times(20.0):
        wave = math.sin(0.7 * time)
        guard.update(Seen(unit=0.8 * wave, free=0.5 * wave), 1.0)
        harms.append(guard.alarm)
    assert not any(harms[: round(9.9 / DT)])
    assert all(harms[round(10.1 / DT) :])
    assert harms[-1].name == "WORSE_THAN_OFF: estimate"
    assert harms[-1].values["sigma"] / harms[-1].values["free"] == pytest.approx(0.8 / 0.5)


def guarded(reads, unit, seconds=40.0):
    """Let a guard see a sea of 0.5 m until it inhibits; `unit` is estimated, `reads` by the depth sensor [m]."""
    guard = Judge(GuardParameters(window=20.0, floor=0.02), GuardedLoop(LIMITS), tick_period=DT)
    assert guard.trusts_estimate
    for time in times(seconds):
        wave = math.sin(0.7 * time)
        rate = 0.3 * wave
        given = Seen(unit=unit * wave, free=0.5 * wave, tip_rate=rate, payout_rate=rate, measured=reads * wave)
        guard.update(given, 1.0)
        if guard.inhibits:
            break
    return guard


def test_an_estimate_is_not_trusted_while_the_depth_sensor_contradicts_it_and_is_again_once_it_is_tried_again():
    assert guarded(reads=0.1, unit=0.1).trusts_estimate
    assert not guarded(reads=0.5, unit=0.0).trusts_estimate
    guard = guarded(reads=0.75, unit=0.55)
    assert (guard.alarm.name, guard.trusts_estimate) == ("WORSE_THAN_OFF: depth", False)
    guard.allow_correction("mru")
    assert guard.trusts_estimate
    guard = guarded(reads=0.75, unit=0.55)
    for time in times(400.0):  # the winch stands, and both see the sea as it is
        wave = math.sin(0.7 * time)
        heave = 0.5 * wave
        guard.update(Seen(unit=heave, free=heave, tip_rate=0.3 * wave, measured=heave), 0.0)
    assert (guard.inhibits, guard.trusts_estimate) == (False, True)


def test_of_a_sea_that_was_not_seen_yet_nothing_is_held_back():
    for keeps_limits in (True, False):
        guard = Judge(GuardParameters(window=20.0), GuardedLoop(LIMITS, keeps_limits=keeps_limits), tick_period=DT)
        guard.update(Seen(), 0.0)
        assert (guard.authority_limit, guard.demand) == (1.0, 0.0)


def test_a_law_that_keeps_the_limits_by_itself_is_given_as_much_as_the_winch_can_nearly_do():
    """Waves of one height and 4 m/s over 2 m/s: a demand of 2, of which 1.4 is given."""
    loop = GuardedLoop(WinchLimits(2.0, 100.0, -50.0, 50.0), keeps_limits=True)
    guard = Judge(GuardParameters(window=20.0), loop, tick_period=DT)
    for time in times(200.0):
        guard.update(Seen(tip_rate=4.0 * math.sin(0.7 * time)), 0.0)
    assert guard.authority_limit == pytest.approx(1.4 / 2.0, rel=0.02)


def shown(share_of_unit, share_of_drum, free=(0.3, 0.1), tip=(0.5, 0.2)):
    """Return the authority that a unit and a drum show, each moving with such a part of the heave of the boom tip."""
    left = 1.0 - share_of_unit
    guard = Guard(guard_design(GuardParameters(), GuardedLoop(LIMITS, inertia=4.0), DT))
    drum = {"payout": share_of_drum * tip[0], "payout_rate": share_of_drum * tip[1]}
    unit = {"unit": left * free[0], "unit_rate": left * free[1]}
    motions = dict(zip(("free", "free_rate", "tip", "tip_rate"), (*free, *tip), strict=True))
    return guard.step(Seen(**unit, **motions, **drum), 0.0).shown


@pytest.mark.parametrize("share", [0.0, 0.25, 1.0])
def test_unit_and_drum_show_the_authority_under_which_both_move(share):
    assert shown(share, share) == pytest.approx(share)


def test_of_two_that_show_another_authority_each_counts_by_the_energy_of_its_swing():
    """By hand, with a of 4 s^2: 0.3^2 + 4 x 0.1^2 = 0.13 of the unit, 0.5^2 + 4 x 0.2^2 = 0.41 of the boom tip."""
    assert shown(1.0, 0.0) == pytest.approx(0.13 / 0.54)
    assert shown(0.0, 1.0) == pytest.approx(0.41 / 0.54)


def test_what_is_shown_is_a_share_and_none_where_nothing_moves():
    assert shown(3.0, 3.0) == 1.0
    assert shown(-1.0, -1.0) == 0.0
    assert shown(1.0, 1.0, free=(0.0, 0.0), tip=(0.0, 0.0)) == 0.0
