import math

import numpy as np
import pytest
from winch_controller_node.estimation.loop_tick import Motion
from winch_controller_node.laws.winch_limits import WinchLimits
from winch_controller_node.parameters.laws import GuardParameters, ModeParameters
from winch_controller_node.supervision.guard import GuardedLoop, GuardedMotions, HarmGuard
from winch_controller_node.supervision.modes import Mode, ModeError, ModeMachine, Situation

DT = 0.05
WELL = Situation(lost="", has_estimate=True, winch_fault=0, harm="", speed=0.0)
PARAMETERS = ModeParameters(settling_time=1.0, fade_in_time=2.0, fade_out_time=2.0, coast_time=1.5, resume_time=3.0)


def machine(*, moves_winch=True):
    return ModeMachine(PARAMETERS, moves_winch=moves_winch, factor=1.0, tick_period=DT)


def run(modes, seconds, situation=WELL):
    return [modes.step(situation) for _ in range(round(seconds / DT))]


def situation(**changes):
    values = {"lost": "", "has_estimate": True, "winch_fault": 0, "harm": "", "speed": 0.0} | changes
    return Situation(**values)


def test_compensation_starts_by_itself_and_authority_rises_without_a_step():
    modes = machine()
    outputs = run(modes, 5.0)
    authority = [output.authority for output in outputs]
    assert modes.mode is Mode.COMPENSATING
    assert authority[0] == 0.0
    assert authority[-1] == 1.0
    assert np.max(np.abs(np.diff(authority))) <= DT / 2.0 + 1e-12


def test_law_off_keeps_the_brake_on_and_refuses_to_move():
    modes = machine(moves_winch=False)
    assert all(output.brake for output in run(modes, 5.0))
    with pytest.raises(ModeError, match="law off"):
        modes.request("compensating")


def test_a_lost_mru_is_coasted_over_then_faded_then_stopped_then_forgiven():
    modes = machine()
    run(modes, 5.0)
    lost = situation(lost="mru frozen", speed=0.3)
    assert run(modes, 1.4, lost)[-1].mode is Mode.COMPENSATING
    assert "coasting" in modes.reason
    assert run(modes, 0.3, lost)[-1].mode is Mode.FADE_OUT
    assert run(modes, 2.0, lost)[-1].mode is Mode.STOPPING
    assert run(modes, 0.1, situation(lost="mru frozen"))[-1].mode is Mode.STOPPED
    assert modes.reason == "mru frozen"
    run(modes, 2.9)
    assert modes.mode is Mode.STOPPED
    run(modes, 2.0)
    assert modes.mode is Mode.COMPENSATING


def test_a_short_gap_does_not_end_compensation():
    modes = machine()
    run(modes, 5.0)
    run(modes, 1.0, situation(lost="mru stale"))
    assert run(modes, 0.1)[-1] == type(run(modes, 0.05)[-1])(Mode.COMPENSATING, "", 1.0, False)


def test_an_emergency_stop_brakes_at_once_and_waits_for_somebody():
    modes = machine()
    run(modes, 5.0)
    modes.request("emergency_stop")
    assert modes.step(WELL).brake
    assert run(modes, 60.0)[-1].mode is Mode.EMERGENCY_STOP
    modes.request("compensating")
    run(modes, 2.0)
    assert modes.mode is Mode.COMPENSATING


def test_a_fault_of_the_winch_brakes_and_is_not_forgiven_by_itself():
    modes = machine()
    run(modes, 5.0)
    assert run(modes, 0.1, situation(winch_fault=3))[-1].brake
    assert run(modes, 60.0)[-1].mode is Mode.STOPPED


def test_harm_fades_out_to_standby_and_comes_back_when_it_is_over():
    modes = machine()
    run(modes, 5.0)
    harm = situation(harm="compensation does harm")
    outputs = run(modes, 3.0, harm)
    assert outputs[0].mode is Mode.FADE_OUT
    assert modes.mode is Mode.STANDBY
    run(modes, 5.0, harm)
    assert modes.mode is Mode.STANDBY
    run(modes, 1.5)
    assert modes.mode is Mode.COMPENSATING


def test_an_unknown_mode_is_refused_by_name():
    with pytest.raises(ModeError, match="'dance' cannot be requested"):
        machine().request("dance")


def make_guard():
    limits = WinchLimits(2.0, 1.5, -50.0, 50.0)
    return HarmGuard(GuardParameters(window=20.0, hold_time=30.0, floor=0.02), GuardedLoop(limits), tick_period=DT)


def feed_guard(guard, residual, uncompensated, seconds, authority=1.0, rate=0.3):
    for k in range(round(seconds / DT)):
        wave = np.sin(0.7 * k * DT)
        motions = GuardedMotions(
            Motion(residual * wave, 0.0), Motion(uncompensated * wave, 0.0), Motion(0.0, rate * wave), rate * wave
        )
        guard.update(motions, authority)


def test_the_guard_tolerates_a_small_residual_and_stops_a_harmful_one():
    guard = make_guard()
    feed_guard(guard, 0.02, 0.01, 100.0)
    assert not guard.inhibits
    feed_guard(guard, 0.2, 0.5, 100.0)
    assert not guard.inhibits
    feed_guard(guard, 0.8, 0.5, 60.0)
    assert guard.inhibits
    assert "does harm" in guard.reason


def test_the_guard_lets_compensation_be_tried_again_and_waits_longer_each_time():
    guard = make_guard()
    feed_guard(guard, 0.8, 0.5, 40.0)
    feed_guard(guard, 0.0, 0.5, 29.0, authority=0.0)
    assert guard.inhibits
    feed_guard(guard, 0.0, 0.5, 2.0, authority=0.0)
    assert not guard.inhibits
    feed_guard(guard, 0.8, 0.5, 40.0)
    feed_guard(guard, 0.0, 0.5, 31.0, authority=0.0)
    assert guard.inhibits


def test_the_guard_waits_while_the_sea_asks_for_far_more_than_the_winch_can_give():
    """Demand: significant amplitude 2 sigma of speed or acceleration over the limit; sin amplitude A has A/sqrt(2)."""
    guard = make_guard()
    feed_guard(guard, 0.8, 0.5, 40.0, rate=10.0)
    feed_guard(guard, 0.0, 0.5, 200.0, authority=0.0, rate=10.0)
    assert guard.demand == pytest.approx(2.0 * 10.0 / np.sqrt(2.0) / 2.0, rel=0.1)
    assert guard.inhibits


def test_a_swing_above_the_sea_is_noticed_within_seconds_and_one_below_never():
    """A lost loop: the swing becomes three times the uncompensated one; half the window would be 10 s."""
    guard = make_guard()
    feed_guard(guard, 0.5, 0.5, 60.0, authority=0.0)
    feed_guard(guard, 0.4, 0.5, 30.0, authority=0.5)
    assert not guard.inhibits
    feed_guard(guard, 1.5, 0.5, 5.0, authority=0.5)
    assert guard.inhibits
    assert "swings" in guard.reason


def watch_waves(
    guard, seconds, *, rate_error=0.0, depth=lambda time: None, residual=0.01, uncompensated=0.5, authority=1.0
):
    """Give the guard an estimate in which all is well, next to what drum and depth sensor show."""
    for k in range(round(seconds / DT)):
        wave = uncompensated * np.sin(0.7 * k * DT)
        beat = rate_error * np.sin(2.0 * k * DT)
        unit = wave if authority == 0.0 else residual * np.sin(0.7 * k * DT)
        tip = Motion(0.0, 0.7 * wave)
        motions = GuardedMotions(Motion(unit, 0.0), Motion(wave, 0.0), tip, authority * tip.rate + beat, depth(k * DT))
        guard.update(motions, authority)
        if guard.inhibits:
            return k * DT
    return None


def test_a_drum_that_runs_wild_is_noticed_before_the_unit_has_answered():
    """Twice the boom tip's speed of 0.35 m/s, which the law did not mean: within seconds, not within a wave of 9 s."""
    guard = make_guard()
    watch_waves(guard, 60.0, authority=0.0)
    assert watch_waves(guard, 60.0, rate_error=0.2) is None
    noticed = watch_waves(guard, 60.0, rate_error=0.7)
    assert noticed is not None and noticed < 5.0
    assert "drum" in guard.reason


def test_a_depth_sensor_that_sees_twice_the_uncompensated_motion_is_believed_against_the_estimate():
    """As a motion reference unit of the wrong sign would have it: payout the wrong way, twice the motion."""
    guard = make_guard()
    watch_waves(guard, 60.0, authority=0.0)
    assert watch_waves(guard, 60.0, residual=0.4, depth=lambda time: 0.4 * math.sin(0.7 * time)) is None
    noticed = watch_waves(guard, 60.0, residual=0.4, depth=lambda time: 1.0 * math.sin(0.7 * time))
    assert noticed is not None and noticed < 15.0
    assert "depth sensor" in guard.reason


@pytest.mark.parametrize("fault", [lambda time: 2.0 * (time > 20.0), lambda time: 3.0 * (abs(time - 20.0) < 0.01)])
def test_a_jump_or_a_spike_of_the_depth_sensor_is_no_harm(fault):
    guard = make_guard()
    watch_waves(guard, 60.0, authority=0.0)
    assert watch_waves(guard, 60.0, depth=lambda time: fault(time) + 0.02 * math.sin(0.7 * time)) is None


def test_authority_falls_when_a_group_of_waves_comes_before_the_mean_of_the_sea_has_grown():
    """Amplitudes of 0.5 and 2 m/s at 0.7 rad/s: the latter asks for 1.4 m/s^2, the limit is 1.5 m/s^2."""
    guard = make_guard()
    watch_waves(guard, 120.0, uncompensated=0.5 / 0.7)
    calm = guard.authority_limit
    watch_waves(guard, 9.0, uncompensated=2.0 / 0.7, authority=0.0)
    assert calm == 1.0
    # sigma 1.0 m/s^2 at the end of the group, its first waves not quite forgotten: 0.85 * 1.5 / (2.2 * 1.0) = 0.58
    assert guard.authority_limit < 0.8
