"""The virtual winch obeys its law, its limits, its brake and its watchdog."""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import Any

import numpy as np
import pytest
from cable_sim_node.winch.command_line import WinchCommand
from cable_sim_node.winch.component import VirtualWinch, WinchState
from cable_sim_node.winch.drive import settings_of
from cable_sim_node.winch.parameters import EncoderParameters, WinchDriftParameters, WinchParameters
from heave_drives.parameters import ElectricParameters, SpoolParameters
from heave_node.interface.codes import WinchFault, WinchLimit, WinchRelease
from heave_node.interface.faults import FaultParameters
from heave_node.winch.parameters import highest_position_gain
from hypothesis import given, settings
from hypothesis import strategies as st

TICK = 0.05
IDEAL = WinchParameters(
    command_delay=0.0,
    speed_limit=100.0,
    acceleration_limit=1e6,
    stop_deceleration=1e6,
    encoder=EncoderParameters(resolution=0.0),
)


def run(
    winch: VirtualWinch,
    ticks: int,
    *,
    rate: float = 0.0,
    payout: float = 0.0,
    brake: bool = False,
    tension: float = math.nan,
) -> list[WinchState]:
    """Step with a fresh command of these set-points in every tick."""
    states = []
    for _ in range(ticks):
        tick = winch.tick
        states.append(winch.step(tick, WinchCommand(1_000_000 + tick, payout, rate, brake), tension))
    return states


def starve(winch: VirtualWinch, ticks: int) -> list[WinchState]:
    """Step without commands."""
    return [winch.step(winch.tick, None) for _ in range(ticks)]


def test_speed_servo_answers_a_step_like_a_first_order_lag() -> None:
    winch = VirtualWinch(IDEAL, tick_period=TICK)
    states = run(winch, 20, rate=0.5)
    t = np.array([state.time for state in states])
    lag = IDEAL.time_constant
    # Exact solution of v' = (0.5 - v)/T from rest.
    np.testing.assert_allclose([s.payout_rate for s in states], 0.5 * (1 - np.exp(-t / lag)), rtol=1e-12)
    np.testing.assert_allclose([s.payout for s in states], 0.5 * (t - lag * (1 - np.exp(-t / lag))), rtol=1e-11)


def test_speed_servo_with_position_gain_follows_its_second_order_equation() -> None:
    gain = 1.2
    winch = VirtualWinch(dataclasses.replace(IDEAL, position_gain=gain), tick_period=TICK)
    states = run(winch, 100, payout=0.3, rate=0.1)
    # T u'' + u' + k_p u = k_p u_set + v_set from rest: u_end + A exp(p1 t) + B exp(p2 t).
    p1, p2 = np.roots([IDEAL.time_constant, 1.0, gain])
    end = 0.3 + 0.1 / gain
    a = end * p2 / (p1 - p2)
    b = -end * p1 / (p1 - p2)
    t = np.array([state.time for state in states])
    np.testing.assert_allclose([s.payout for s in states], end + a * np.exp(p1 * t) + b * np.exp(p2 * t), atol=2e-6)


@pytest.mark.parametrize("lag", [0.001, 0.15])
@pytest.mark.parametrize("acceleration", [0.1, 1.5])
def test_each_swing_of_the_highest_position_gain_is_at_most_a_third_of_the_one_before(
    lag: float, acceleration: float
) -> None:
    """At the limits each overshoot is (k V - 2 a)/(k V + 2 a) of the last swing, a third for k = 4 a/V."""
    gain = highest_position_gain(2.0, acceleration)
    parameters = WinchParameters(
        command_delay=0.0,
        position_gain=gain,
        time_constant=lag,
        acceleration_limit=acceleration,
        stop_deceleration=acceleration,
    )
    winch = VirtualWinch(parameters, tick_period=TICK)
    error = np.array([s.payout for s in run(winch, 1000 + round(500.0 / acceleration), payout=30.0)]) - 30.0
    braked = 2.0**2 / (2.0 * acceleration)
    if lag < 0.1:  # the formula is that of a drum without lag
        assert error.max() == pytest.approx(braked - 2.0 / gain, rel=0.02)
    swings = [
        30.0,
        *(np.max(np.abs(part)) for part in np.split(error, np.flatnonzero(np.diff(np.sign(error))) + 1)[1:]),
    ]
    assert swings[1] <= (braked + 2.0 / gain) / 3.0 * (1.0 + 0.5 * gain * lag) * 1.02
    assert all(later <= earlier / 3.0 for earlier, later in itertools.pairwise(swings[1:]) if later > 1e-3)
    assert abs(error[-1]) < 1e-6


def test_first_order_law_is_thesis_equation_6_1() -> None:
    winch = VirtualWinch(dataclasses.replace(IDEAL, law="first_order", position_rate=1.5), tick_period=TICK)
    states = run(winch, 60, payout=0.2)
    t = np.array([state.time for state in states])
    # Thesis 6.2.2: u = u_I (1 - exp(-K (t - t_0))).
    np.testing.assert_allclose([s.payout for s in states], 0.2 * (1 - np.exp(-1.5 * t)), rtol=1e-12)
    np.testing.assert_allclose([s.payout_rate for s in states], 0.3 * np.exp(-1.5 * t), rtol=1e-12)


@pytest.mark.parametrize("delay", [0.0, 0.05, 0.2, 0.23, 0.0817, 1.0])
def test_command_takes_effect_exactly_after_the_delay_also_inside_a_tick(delay: float) -> None:
    winch = VirtualWinch(dataclasses.replace(IDEAL, command_delay=delay), tick_period=TICK)
    states = run(winch, 40, rate=0.5)
    lag = IDEAL.time_constant
    since = np.maximum(np.array([state.time for state in states]) - delay, 0.0)
    expected = 0.5 * (since - lag * (1 - np.exp(-since / lag)))
    np.testing.assert_allclose([s.payout for s in states], expected, rtol=1e-9, atol=1e-13)


def test_limited_step_is_a_ramp_at_the_acceleration_limit_to_the_speed_limit() -> None:
    parameters = WinchParameters(command_delay=0.0)
    winch = VirtualWinch(parameters, tick_period=TICK)
    states = run(winch, 60, rate=9.0)
    assert states[3].payout_rate == pytest.approx(1.5 * 0.2, rel=1e-12)  # v = a t
    assert states[3].payout == pytest.approx(0.5 * 1.5 * 0.2**2, rel=1e-12)  # u = a t^2/2
    assert states[3].limits_hit == WinchLimit.SPEED | WinchLimit.ACCELERATION
    assert states[-1].payout_rate == pytest.approx(2.0, rel=1e-3)
    assert max(s.payout_rate for s in states) <= 2.0


def test_winch_stops_at_the_end_of_its_range_and_says_so() -> None:
    winch = VirtualWinch(WinchParameters(payout_minimum=-1.0, payout_maximum=3.0), tick_period=TICK)
    states = run(winch, 200, rate=2.0)
    assert states[-1].payout == pytest.approx(3.0, abs=1e-6)
    assert max(s.payout for s in states) <= 3.0
    assert states[-1].payout_rate == pytest.approx(0.0, abs=1e-6)
    assert any(s.limits_hit & WinchLimit.PAYOUT for s in states)
    states = run(winch, 300, rate=-2.0)
    assert states[-1].payout == pytest.approx(-1.0, abs=1e-6)
    assert min(s.payout for s in states) >= -1.0


def test_power_limit_bounds_the_speed_to_power_over_tension() -> None:
    winch = VirtualWinch(WinchParameters(power_limit=50e3), tick_period=TICK)
    states = run(winch, 100, rate=-2.0, tension=100e3)
    assert states[-1].payout_rate == pytest.approx(-0.5, rel=1e-6)
    assert states[-1].power == pytest.approx(50e3, rel=1e-6)
    assert states[-1].limits_hit == WinchLimit.POWER
    risen = run(winch, 40, rate=-2.0, tension=200e3)
    steps = np.diff([s.payout_rate for s in risen])
    assert np.abs(steps).max() <= 1.5 * TICK + 1e-12
    assert risen[-1].payout_rate == pytest.approx(-0.25, rel=1e-3)


def test_brake_request_stops_with_the_stop_deceleration_and_then_holds() -> None:
    winch = VirtualWinch(WinchParameters(command_delay=0.0, stop_deceleration=1.0), tick_period=TICK)
    before = run(winch, 100, rate=1.0)[-1]
    states = run(winch, 30, brake=True)
    assert states[5].payout_rate == pytest.approx(before.payout_rate - 1.0 * 6 * TICK, rel=1e-9)
    assert states[-1].brake
    assert states[-1].payout_rate == 0.0
    # Stopping distance v^2/(2 d).
    assert states[-1].payout - before.payout == pytest.approx(before.payout_rate**2 / 2.0, rel=1e-9)
    assert states[-1].fault is WinchFault.NONE
    assert not run(winch, 1, rate=1.0)[-1].brake


def test_brake_is_engaged_until_the_first_command() -> None:
    winch = VirtualWinch(WinchParameters(), tick_period=TICK)
    assert all(s.brake and s.payout == 0.0 and s.fault is WinchFault.NONE for s in starve(winch, 100))
    assert winch.state.command_sequence == 0


def test_watchdog_stops_brakes_and_latches_until_an_explicit_release() -> None:
    winch = VirtualWinch(WinchParameters(command_timeout=0.5), tick_period=TICK)
    moving = run(winch, 100, rate=1.0)[-1]
    assert moving.fault is WinchFault.NONE
    silent = starve(winch, 60)
    first = next(i for i, s in enumerate(silent) if s.fault is not WinchFault.NONE)
    # The last command, of the tick before `moving`, takes effect 0.2 s after its start; the watchdog
    # trips 0.5 s later, and that is reported at the end of the tick that begins then.
    assert silent[first].time == pytest.approx(moving.time - TICK + 0.2 + 0.5 + TICK)
    assert silent[first].fault is WinchFault.COMMAND_TIMEOUT
    assert np.abs(np.diff([s.payout_rate for s in silent])).max() <= 1.5 * TICK + 1e-12
    assert silent[-1].brake
    assert silent[-1].payout_rate == 0.0
    still = run(winch, 20, rate=1.0)
    assert all(s.brake and s.fault is WinchFault.COMMAND_TIMEOUT for s in still)
    run(winch, 1, brake=True)
    released = run(winch, 20, rate=1.0)[-1]
    assert released.fault is WinchFault.NONE
    assert released.payout_rate > 0.5


def test_a_latched_fault_says_what_it_waits_for_until_it_is_released() -> None:
    winch = VirtualWinch(WinchParameters(command_timeout=0.5, stop_deceleration=0.5), tick_period=TICK)
    assert run(winch, 100, rate=1.0)[-1].release is WinchRelease.NONE
    starve(winch, 15)
    tripped = winch.state
    assert (tripped.fault, tripped.release) == (WinchFault.COMMAND_TIMEOUT, WinchRelease.BRAKE_REQUEST)
    assert run(winch, 20, rate=1.0)[-1].release is WinchRelease.BRAKE_REQUEST, "no set-point releases it"
    stopping = run(winch, 6, brake=True)[-1]
    assert abs(stopping.payout_rate) > 0.0
    assert stopping.release is WinchRelease.STANDSTILL
    assert run(winch, 60, brake=True)[-1].release is WinchRelease.COMMAND
    assert run(winch, 10, rate=1.0)[-1].release is WinchRelease.NONE


def test_command_at_the_very_deadline_is_in_time() -> None:
    winch = VirtualWinch(WinchParameters(command_timeout=0.5), tick_period=TICK)
    for tick in range(100):
        winch.step(tick, WinchCommand(tick + 1, 0.0, 0.5) if tick % 10 == 0 else None)
    assert winch.state.fault is WinchFault.NONE


def test_duplicates_and_stale_commands_do_not_feed_the_watchdog() -> None:
    winch = VirtualWinch(WinchParameters(), tick_period=TICK)
    run(winch, 20, rate=0.5)
    newest = WinchCommand(2_000_000, 0.0, 0.5)
    for tick in range(20, 60):
        winch.step(tick, newest if tick % 2 else WinchCommand(7, 0.0, -2.0))
    assert winch.state.fault is WinchFault.COMMAND_TIMEOUT
    assert winch.refused_commands > 0
    assert winch.state.command_sequence == 2_000_000


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("field", ["payout", "payout_rate"])
def test_command_that_is_not_a_finite_number_stops_the_winch_with_a_named_fault(bad: float, field: str) -> None:
    winch = VirtualWinch(WinchParameters(), tick_period=TICK)
    run(winch, 60, rate=1.0)
    tick = winch.tick
    winch.step(tick, WinchCommand(1_000_000 + tick)._replace(**{field: bad}))
    states = run(winch, 60, rate=1.0)
    assert states[-1].fault is WinchFault.INVALID_COMMAND
    assert states[-1].brake
    assert all(math.isfinite(s.payout) and math.isfinite(s.payout_rate) for s in states)


def test_restarted_controller_takes_over_only_by_a_brake_request() -> None:
    winch = VirtualWinch(WinchParameters(), tick_period=TICK)
    run(winch, 20, rate=0.5)
    starve(winch, 60)
    for sequence in range(1, 20):
        winch.step(winch.tick, WinchCommand(sequence, 0.0, 0.5))
    assert winch.state.fault is WinchFault.COMMAND_TIMEOUT
    winch.step(winch.tick, WinchCommand(20, brake=True))
    for sequence in range(21, 50):
        winch.step(winch.tick, WinchCommand(sequence, 0.0, 0.5))
    assert winch.state.fault is WinchFault.NONE
    assert winch.state.payout_rate == pytest.approx(0.5, rel=0.01)


@pytest.mark.parametrize(
    ("kind", "fault"), [("drive", WinchFault.DRIVE), ("emergency_stop", WinchFault.EMERGENCY_STOP)]
)
def test_scheduled_trip_acts_at_its_time_and_needs_a_release_after_it_ended(kind: str, fault: WinchFault) -> None:
    faults = FaultParameters(kind=(kind,), start=(5.0,), duration=(4.0,), magnitude=(0.0,))
    winch = VirtualWinch(WinchParameters(faults=faults), tick_period=TICK)
    before = run(winch, 100, rate=1.0)
    assert before[-1].fault is WinchFault.NONE
    during = run(winch, 20, rate=1.0)
    assert during[0].fault is fault
    assert during[0].payout_rate == pytest.approx(before[-1].payout_rate - 1.5 * TICK, rel=1e-9)
    assert during[-1].brake
    run(winch, 10, brake=True)
    assert run(winch, 10, rate=1.0)[-1].fault is fault, "cannot be released while it lasts"
    run(winch, 60, brake=True)
    assert run(winch, 10, rate=1.0)[-1].fault is WinchFault.NONE


def test_lost_commands_trip_the_watchdog_and_added_delay_shifts_the_answer() -> None:
    lost = FaultParameters(kind=("gap",), start=(2.0,), duration=(3.0,), magnitude=(0.0,))
    winch = VirtualWinch(WinchParameters(faults=lost), tick_period=TICK)
    run(winch, 80, rate=1.0)
    assert winch.state.fault is WinchFault.COMMAND_TIMEOUT

    late = FaultParameters(kind=("delay",), start=(0.0,), duration=(0.0,), magnitude=(0.2,))
    slow = VirtualWinch(WinchParameters(faults=late), tick_period=TICK)
    prompt = VirtualWinch(WinchParameters(), tick_period=TICK)
    shifted = [s.payout for s in run(slow, 40, rate=1.0)][4:]
    np.testing.assert_allclose(shifted, [s.payout for s in run(prompt, 36, rate=1.0)], rtol=1e-12)


def test_older_command_that_is_overtaken_when_the_delay_falls_is_not_taken() -> None:
    late = FaultParameters(kind=("delay",), start=(0.0,), duration=(1.0,), magnitude=(0.5,))
    winch = VirtualWinch(WinchParameters(faults=late), tick_period=TICK)
    sequences = [s.command_sequence for s in run(winch, 60, rate=1.0)]
    assert sequences == sorted(sequences)
    assert winch.refused_commands > 0


def test_encoder_rounds_to_a_millimetre() -> None:
    winch = VirtualWinch(WinchParameters(), tick_period=TICK)
    for state in run(winch, 100, rate=0.37):
        assert abs(state.encoder_payout - state.payout) <= 0.0005 + 1e-12
        assert state.encoder_payout / 0.001 == pytest.approx(round(state.encoder_payout / 0.001), abs=1e-6)


@pytest.mark.parametrize(
    ("kind", "expected"), [("jump", [0.25, 0.25]), ("spike", [0.25, 0.0]), ("nan", [math.nan, math.nan])]
)
def test_encoder_faults_show_in_the_reading_and_not_in_the_truth(kind: str, expected: list[float]) -> None:
    faults = FaultParameters(kind=(kind,), start=(2.0,), duration=(1.0,), magnitude=(0.25,))
    winch = VirtualWinch(WinchParameters(encoder=EncoderParameters(0.001, faults)), tick_period=TICK)
    healthy = VirtualWinch(WinchParameters(), tick_period=TICK)
    states, truth = run(winch, 70, rate=0.3), run(healthy, 70, rate=0.3)
    assert [s.payout for s in states] == [s.payout for s in truth]
    errors = np.array([s.encoder_payout - t.encoder_payout for s, t in zip(states, truth, strict=True)])
    np.testing.assert_allclose(errors[39:41], expected, atol=1e-9)  # states at t = 2.00 and 2.05 s
    np.testing.assert_allclose(errors[:39], 0.0)
    np.testing.assert_allclose(errors[59:], 0.0)


@pytest.mark.parametrize("drive", [{"position_gain": 1.2}, {"law": "first_order", "position_rate": 1.5}])
def test_a_position_loop_counts_by_the_encoder(drive: dict[str, Any]) -> None:
    """Ordered to 0.2 m, a drum whose encoder jumps by 0.5 m hauls in by that: it is where the encoder reads 0.2 m."""
    faults = FaultParameters(("jump",), (5.0,), (0.0,), (0.5,))
    winch = VirtualWinch(dataclasses.replace(IDEAL, encoder=EncoderParameters(0.0, faults), **drive), tick_period=TICK)
    states = run(winch, 400, payout=0.2)
    assert states[98].payout == pytest.approx(0.2, abs=2e-3)
    assert states[-1].encoder_payout == pytest.approx(0.2, abs=1e-3)
    assert states[-1].payout == pytest.approx(-0.3, abs=1e-3)


def test_scaled_encoder_counts_another_length_than_is_paid_out() -> None:
    faults = FaultParameters(kind=("scale",), start=(2.0,), duration=(1.0,), magnitude=(0.9,))
    winch = VirtualWinch(WinchParameters(encoder=EncoderParameters(0.0, faults)), tick_period=TICK)
    states = run(winch, 70, rate=0.3)
    factors = [s.encoder_payout / s.payout for s in states[10:]]
    np.testing.assert_allclose(factors, [1.0] * 29 + [0.9] * 20 + [1.0] * 11, rtol=1e-12)


def test_frozen_encoder_repeats_its_last_reading() -> None:
    faults = FaultParameters(kind=("freeze",), start=(2.0,), duration=(1.0,), magnitude=(0.0,))
    winch = VirtualWinch(WinchParameters(encoder=EncoderParameters(0.001, faults)), tick_period=TICK)
    states = run(winch, 70, rate=0.3)
    assert {s.encoder_payout for s in states[38:59]} == {states[38].encoder_payout}
    assert abs(states[60].encoder_payout - states[60].payout) <= 0.0005 + 1e-12


def test_ticks_left_out_run_with_the_last_command() -> None:
    every, some = (VirtualWinch(WinchParameters(), tick_period=TICK) for _ in range(2))
    run(every, 10, rate=0.5)
    run(some, 10, rate=0.5)
    starve(every, 3)
    command = WinchCommand(2_000_000, 0.0, 0.1)
    assert some.step(13, command).payout == pytest.approx(every.step(13, command).payout, rel=1e-12)
    with pytest.raises(ValueError, match="tick 5 is over"):
        some.step(5, None)


def test_a_winch_that_is_made_weaker_stops_with_what_it_has_left() -> None:
    weak = WinchParameters(acceleration_limit=0.5)
    assert settings_of(weak).stop_deceleration == weak.deceleration == 0.5
    assert WinchParameters(stop_deceleration=0.3).deceleration == 0.3


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"payout_minimum": 3.0, "payout_maximum": 2.0}, "payout_minimum = 3 m must be below"),
        ({"payout_minimum": 1.0}, "payout 0, where the run starts, must be from payout_minimum = 1 m"),
        (
            {"position_gain": 3.1},
            "position_gain = 3.1 1/s makes the drum swing about its set-point: with 2 m/s and 1.5",
        ),
        ({"position_gain": 1.6, "hauling_acceleration_share": 0.5}, "2 m/s and 0.75 m/s^2 it can be 1.5 1/s at most"),
        ({"law": "first_order", "position_rate": 4.0}, "position_rate = 4 1/s makes the drum swing"),
        ({"drive": "electric", "law": "first_order"}, "law = first_order is one of drive = speed_servo"),
        (
            {"drive": "electric", "electric": ElectricParameters(spool=SpoolParameters(turns_per_layer=20))},
            "payout_maximum = 50 m with 1 falls needs 50 m of rope; spool.rope_at_zero = 0 m",
        ),
        (
            {"faults": FaultParameters(("freeze",), (0.0,), (0.0,), (0.0,))},
            "faults: a fault of kind freeze is unknown",
        ),
    ],
)
def test_parameters_that_contradict_each_other_are_refused(change: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message.replace("^", r"\^")):
        dataclasses.replace(WinchParameters(), **change)


# What a drive does otherwise than its controller assumes.


def test_hauling_in_has_limits_of_its_own() -> None:
    weak = dataclasses.replace(WinchParameters(), hauling_speed_share=0.5, hauling_acceleration_share=0.4)
    out = run(VirtualWinch(weak, tick_period=TICK), 100, rate=5.0)
    hauling = run(VirtualWinch(weak, tick_period=TICK), 100, rate=-5.0)
    assert max(s.payout_acceleration for s in out) == pytest.approx(1.5)
    assert min(s.payout_acceleration for s in hauling) == pytest.approx(-0.4 * 1.5)
    assert out[-1].payout_rate == pytest.approx(2.0)
    assert hauling[-1].payout_rate == pytest.approx(-0.5 * 2.0)
    assert hauling[-1].limits_hit == WinchLimit.SPEED


def test_acceleration_has_its_sign_whichever_way_the_drum_turns() -> None:
    winch = VirtualWinch(dataclasses.replace(WinchParameters(), hauling_acceleration_share=0.4), tick_period=TICK)
    run(winch, 100, rate=2.0)
    slowing = run(winch, 10, rate=0.0)
    assert slowing[8].payout_rate - slowing[6].payout_rate == pytest.approx(-0.4 * 1.5 * 2 * TICK)


def test_servo_settles_at_its_gain_beyond_the_dead_zone() -> None:
    drive = dataclasses.replace(IDEAL, speed_gain=0.8, speed_deadband=0.05)
    assert run(VirtualWinch(drive, tick_period=TICK), 100, rate=0.04)[-1].payout == 0.0
    assert run(VirtualWinch(drive, tick_period=TICK), 100, rate=-0.55)[-1].payout_rate == pytest.approx(-0.8 * 0.5)


def test_cable_moves_by_the_radius_it_lies_at_and_the_encoder_counts_by_the_nominal_one() -> None:
    true, nominal = (
        run(VirtualWinch(dataclasses.replace(IDEAL, drum_radius_error=e), tick_period=TICK), 40, rate=0.5, tension=1e5)
        for e in (0.05, 0.0)
    )
    for state, plain in zip(true, nominal, strict=True):
        assert state.payout == pytest.approx(1.05 * plain.payout)
        assert state.payout_rate == pytest.approx(1.05 * plain.payout_rate)
        assert state.encoder_payout == plain.encoder_payout
        assert state.power == pytest.approx(-1e5 * state.payout_rate)


def test_power_limit_is_that_of_the_cable_not_of_the_nominal_drum() -> None:
    drive = dataclasses.replace(WinchParameters(), power_limit=1e5, drum_radius_error=0.05)
    state = run(VirtualWinch(drive, tick_period=TICK), 100, rate=2.0, tension=1e5)[-1]
    assert state.payout_rate == pytest.approx(1.0)
    assert state.limits_hit == WinchLimit.POWER


def test_reading_lags_by_half_the_play_of_the_gear_either_way() -> None:
    winch = VirtualWinch(
        dataclasses.replace(IDEAL, encoder=EncoderParameters(resolution=0.0, backlash=0.02)), tick_period=TICK
    )
    out = run(winch, 40, rate=0.5)[-1]
    back = run(winch, 60, rate=-0.5)[-1]
    assert out.encoder_payout == pytest.approx(out.payout - 0.01)
    assert back.encoder_payout == pytest.approx(back.payout + 0.01)


SET_POINT = st.one_of(
    st.floats(-60.0, 60.0), st.floats(allow_nan=True, allow_infinity=True), st.sampled_from([0.0, 2.0, -2.0])
)
COMMAND = st.one_of(
    st.none(),
    st.builds(WinchCommand, sequence=st.integers(1, 400), payout=SET_POINT, payout_rate=SET_POINT, brake=st.booleans()),
    st.builds(
        WinchCommand,
        sequence=st.just(0),  # replaced by a fresh number
        payout=st.floats(-6.0, 6.0),
        payout_rate=st.floats(-5.0, 5.0),
        brake=st.sampled_from([False, False, False, False, False, True]),
    ),
)


@settings(max_examples=150, deadline=None)
@given(
    commands=st.lists(COMMAND, min_size=5, max_size=80),
    tensions=st.lists(st.one_of(st.floats(allow_nan=True), st.floats(0.0, 2e5)), min_size=1, max_size=8),
    law=st.sampled_from(["speed_servo", "first_order"]),
    gain=st.sampled_from([0.0, 1.0, 3.0]),
    delay=st.floats(0.0, 0.3),
    lag=st.floats(0.01, 1.0),
    power=st.sampled_from([0.0, 1e5]),
    tick_period=st.sampled_from([0.01, 0.05, 0.2]),
)
def test_no_command_sequence_makes_the_winch_exceed_its_limits(
    commands: list[WinchCommand | None],
    tensions: list[float],
    law: str,
    gain: float,
    delay: float,
    lag: float,
    power: float,
    tick_period: float,
) -> None:
    parameters = WinchParameters(
        law=law,
        position_gain=gain,
        command_delay=delay,
        time_constant=lag,
        power_limit=power,
        payout_minimum=-2.0,
        payout_maximum=1.0,
        stop_deceleration=1.2,
    )
    winch = VirtualWinch(parameters, tick_period=tick_period)
    previous = winch.state
    for tick, given_command in enumerate(commands):
        is_fresh = given_command is not None and given_command.sequence == 0
        command = given_command._replace(sequence=1000 + tick) if is_fresh else given_command
        state = winch.step(tick, command, tensions[tick % len(tensions)])
        assert abs(state.payout_rate) <= 2.0 + 1e-12
        assert abs(state.payout_acceleration) <= 1.5 + 1e-9
        assert abs(state.payout_rate - previous.payout_rate) <= 1.5 * tick_period + 1e-12
        assert -2.0 <= state.payout <= 1.0
        largest = max(abs(state.payout_rate), abs(previous.payout_rate)) + 0.75 * tick_period
        assert abs(state.payout - previous.payout) <= min(2.0, largest) * tick_period + 1e-9
        assert not state.brake or state.payout_rate == 0.0
        previous = state
    for tick in range(len(commands), len(commands) + int(4.0 / tick_period)):
        state = winch.step(tick, None)
    assert state.brake, "without commands it always ends at rest with the brake on"


def test_creep_moves_the_drum_at_a_set_point_of_zero_but_not_under_the_brake() -> None:
    winch = VirtualWinch(dataclasses.replace(IDEAL, creep=0.02), tick_period=TICK)
    assert run(winch, 100)[-1].payout_rate == pytest.approx(0.02)
    assert run(winch, 100, rate=0.5)[-1].payout_rate == pytest.approx(0.52)
    assert run(winch, 100, brake=True)[-1].payout_rate == 0.0


def test_gain_and_limits_drift_in_a_straight_line_and_stay() -> None:
    drift = WinchDriftParameters(start=10.0, duration=20.0, gain=0.8, speed=0.5, acceleration=0.25)
    parameters = dataclasses.replace(IDEAL, speed_limit=2.0, acceleration_limit=1.0, stop_deceleration=1.0, drift=drift)
    winch = VirtualWinch(parameters, tick_period=TICK)
    rates = np.array([state.payout_rate for state in run(winch, 1000, rate=0.5)])
    # a lag of 0.15 s behind a gain that falls by 0.2 in 20 s: 0.5 * 0.01 * 0.15 is less than a millimetre a second
    assert rates[199] == pytest.approx(0.5, abs=1e-3)
    assert rates[399] == pytest.approx(0.5 * 0.9, abs=1e-3)
    assert rates[-1] == pytest.approx(0.5 * 0.8, abs=1e-6)
    fast = [state.payout_rate for state in run(winch, 100, rate=5.0)]
    assert max(np.diff(fast)) / TICK == pytest.approx(0.25)
    assert fast[-1] == pytest.approx(1.0)


def test_only_the_servo_drifts() -> None:
    with pytest.raises(ValueError, match="is one of drive = speed_servo"):
        WinchParameters(drive="pump_controlled", drift=WinchDriftParameters(duration=5.0))


def test_the_emergency_stop_goes_before_a_fault_that_was_there_before_and_no_other_does() -> None:
    faults = FaultParameters(kind=("emergency_stop",), start=(8.0,), duration=(1.0,), magnitude=(0.0,))
    winch = VirtualWinch(WinchParameters(command_timeout=0.5, faults=faults), tick_period=TICK)
    run(winch, 100, rate=1.0)
    assert starve(winch, 40)[-1].fault is WinchFault.COMMAND_TIMEOUT
    assert starve(winch, 60)[-1].fault is WinchFault.EMERGENCY_STOP
    winch = VirtualWinch(WinchParameters(faults=faults, command_delay=0.0), tick_period=TICK)
    assert run(winch, 170, rate=1.0)[-1].fault is WinchFault.EMERGENCY_STOP
    assert run(winch, 20, rate=math.nan)[-1].fault is WinchFault.EMERGENCY_STOP, "the first fault stays the named one"


def test_a_new_trip_takes_back_what_was_acknowledged_of_the_one_before() -> None:
    winch = VirtualWinch(WinchParameters(command_timeout=0.5, command_delay=0.0), tick_period=TICK)
    run(winch, 40, rate=1.0)
    starve(winch, 60)
    assert run(winch, 5, brake=True)[-1].release is WinchRelease.COMMAND
    tripped = run(winch, 1, rate=math.nan)[-1]
    assert tripped.release is WinchRelease.BRAKE_REQUEST
    assert run(winch, 20, rate=1.0)[-1].fault is not WinchFault.NONE, "a command alone releases nothing"


def test_no_command_releases_a_fault_while_the_drum_moves() -> None:
    winch = VirtualWinch(
        WinchParameters(command_timeout=0.5, command_delay=0.0, stop_deceleration=0.2), tick_period=TICK
    )
    run(winch, 100, rate=1.0)
    starve(winch, 12)
    run(winch, 1, brake=True)  # acknowledged, and the drum turns for seconds yet
    moving = run(winch, 20, rate=1.0)
    assert all(state.payout_rate > 0.0 for state in moving)
    assert all(state.fault is WinchFault.COMMAND_TIMEOUT for state in moving)
    speeds = [state.payout_rate for state in moving]
    assert speeds == sorted(speeds, reverse=True), "it goes on to stop"


def test_the_watchdog_trips_at_its_time_also_inside_a_tick() -> None:
    """At 0.5 m/s, which stands at once: the drum goes on for the timeout of 0.52 s after the last command, 0.26 m."""
    winch = VirtualWinch(dataclasses.replace(IDEAL, time_constant=1e-3, command_timeout=0.52), tick_period=TICK)
    last = run(winch, 40, rate=0.5)[-1]
    # the last command has taken effect a tick before that state
    assert starve(winch, 20)[-1].payout - last.payout == pytest.approx(0.5 * (0.52 - TICK), abs=1e-6)


def test_a_trip_acts_at_its_time_also_inside_a_tick() -> None:
    """At 0.5 m/s, which stands at once: up to the trip at 2.03 s the drum moves for 0.03 s of its tick."""
    faults = FaultParameters(kind=("emergency_stop",), start=(2.03,), duration=(1.0,), magnitude=(0.0,))
    winch = VirtualWinch(dataclasses.replace(IDEAL, time_constant=1e-3, faults=faults), tick_period=TICK)
    before = run(winch, 40, rate=0.5)[-1]
    assert run(winch, 10, rate=0.5)[-1].payout - before.payout == pytest.approx(0.5 * 0.03, abs=1e-6)


def test_the_number_of_a_command_that_is_no_number_is_used_up() -> None:
    winch = VirtualWinch(WinchParameters(command_delay=0.0), tick_period=TICK)
    run(winch, 20, rate=0.5)
    number = 1_000_000 + winch.tick
    assert winch.step(winch.tick, WinchCommand(number, 0.0, math.nan)).command_sequence == number
    winch.step(winch.tick, WinchCommand(number, brake=True))
    assert (winch.refused_commands, winch.state.release) == (1, WinchRelease.BRAKE_REQUEST)


def test_a_brake_request_with_the_number_of_the_newest_command_acknowledges_nothing() -> None:
    winch = VirtualWinch(WinchParameters(command_timeout=0.5), tick_period=TICK)
    newest = run(winch, 20, rate=0.5)[-1].command_sequence + 4  # as many are on their way: 0.2 s of delay
    starve(winch, 60)
    assert winch.state.command_sequence == newest
    for _ in range(10):
        winch.step(winch.tick, WinchCommand(newest, brake=True))
    assert winch.state.release is WinchRelease.BRAKE_REQUEST
    assert winch.refused_commands > 0


def test_a_command_that_is_sent_again_in_each_tick_is_one_command() -> None:
    winch = VirtualWinch(WinchParameters(), tick_period=TICK)
    for tick in range(10):
        winch.step(tick, WinchCommand(1, 0.0, 0.5))
    assert (winch.state.command_sequence, winch.refused_commands) == (1, 0)


def test_the_encoder_gives_the_mean_speed_over_the_ticks_since_it_was_read() -> None:
    """A constant speed of 0.5 m/s, also over four ticks that were left out."""
    winch = VirtualWinch(IDEAL, tick_period=TICK)
    assert run(winch, 100, rate=0.5)[-1].encoder_payout_rate == pytest.approx(0.5)
    assert winch.step(winch.tick + 4, WinchCommand(2_000_000, 0.0, 0.5)).encoder_payout_rate == pytest.approx(0.5)


def test_a_braked_drum_that_moves_is_no_drum_that_follows_for_the_supervision() -> None:
    """It is supervised by what it is to do: braked it may stand for as long as it will."""
    winch = VirtualWinch(WinchParameters(supervision_time=0.5), tick_period=TICK)
    assert run(winch, 100, rate=0.5, brake=True)[-1].fault is WinchFault.NONE
    assert run(winch, 100, rate=0.5)[-1].fault is WinchFault.NONE
    assert winch.supervised == ""


def test_the_ideal_servo_has_no_instruments_and_a_drive_with_its_physics_has() -> None:
    assert VirtualWinch(WinchParameters(), tick_period=TICK).instruments() == {}
    electric = VirtualWinch(WinchParameters(drive="electric"), tick_period=TICK)
    assert electric.instruments() == {}, "before the cable is known there is no drive"
    run(electric, 2, tension=5e4)
    assert electric.instruments()


def test_a_drive_that_is_held_before_the_cable_is_known_stands() -> None:
    winch = VirtualWinch(WinchParameters(drive="electric"), tick_period=TICK)
    state = starve(winch, 3)[-1]
    assert (state.payout, state.payout_rate, state.payout_acceleration) == (0.0, 0.0, 0.0)
    assert state.limits_hit == WinchLimit.NONE
