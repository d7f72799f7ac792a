"""What a record of sensors shows: the boom tip, the unexplained motion, the cable's transfer function."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cable_sim_node.parameters import CableSimParameters
from cable_sim_node.vertical.axial_line import axial_line
from cable_sim_node.vertical.linear import heave_transfer_function
from cable_sim_node.winch.command_line import WinchCommand
from cable_sim_node.winch.component import VirtualWinch
from cable_sim_node.winch.parameters import EncoderParameters, WinchParameters
from heave_bringup.scenarios import load_scenario
from heave_node.interface.sensors import MruReading
from heave_studies.whatif.record import SensorRecord, bridged
from heave_studies.whatif.spectra import (
    HighPass,
    Speeds,
    TipSource,
    Transform,
    disturbance,
    gains_over_top,
    noise_power,
    smoothed_tip,
)
from heave_studies.whatif.twin import PlantFactors, past_winch, scaled_line, speeds_shown, winch_under
from winch_controller_node.beliefs.beliefs import AS_READ, Belief, Beliefs, Correction
from winch_controller_node.interface.readings import Measurements, ScalarReading, WinchOrder, WinchReading

TICK, NOISE = 0.05, 0.01
TIME = TICK * np.arange(1, 4001)
MOTION = 0.4 * np.sin(0.7 * TIME) + 0.2 * np.sin(1.1 * TIME + 1.0)
RATE = 0.28 * np.cos(0.7 * TIME) + 0.22 * np.cos(1.1 * TIME + 1.0)


def record(heave=MOTION, rate=RATE, depth=None, delay=0.0):
    """Return a record of an MRU and a depth sensor at each tick, with white noise."""
    random = np.random.default_rng(3)
    noise = NOISE * random.standard_normal((3, len(TIME)))
    depths = np.zeros(len(TIME)) if depth is None else depth
    given = tuple(
        Measurements(
            (MruReading(float(t) + delay, float(z), float(v)),), {"depth": (ScalarReading(float(t), float(d)),)}
        )
        for t, z, v, d in zip(TIME, heave + noise[0], rate + noise[1], depths + noise[2], strict=True)
    )
    count = len(TIME)
    return SensorRecord(TICK, 1, given, (None,) * count, np.full(count, math.nan), ("",) * count)


def heaves(motion):
    """Return what a depth sensor reads of a motion of the unit: times and heaves, shape (m, 2)."""
    times, depth = record(depth=-motion).scalar("depth").T
    return np.column_stack((times, -depth))


def test_the_smoothed_boom_tip_is_as_near_to_the_motion_as_it_says():
    tip = smoothed_tip(record(), AS_READ, HighPass())
    inside = slice(800, -800)  # the mirror at the ends is no motion
    error = float(np.std((tip.heave - MOTION)[inside]))
    assert error < 0.25 * NOISE
    assert 0.5 < error / tip.sigma < 2.0
    assert np.std((tip.rate - RATE)[inside]) < 0.5 * NOISE


def test_scale_mean_and_delay_of_the_mru_are_taken_back():
    read = record(1.1 * MOTION + 0.5, 1.1 * RATE, delay=0.2)
    tip = smoothed_tip(read, Correction(scale=1.1, offset=0.5, delay=0.2), HighPass())
    assert np.std((tip.heave - MOTION)[800:-800]) < 0.25 * NOISE


def test_the_high_pass_of_the_mru_is_taken_back():
    high_pass = HighPass(30.0, 0.7)
    motion = np.zeros(len(TIME))
    rate = np.zeros(len(TIME))
    # what the filter makes of each sine is known exactly
    for amplitude, omega, phase in ((0.4, 0.7, 0.0), (0.2, 1.1, 1.0)):
        turn = high_pass.response(np.array([omega]))[0]
        read = amplitude * turn * np.exp(1j * (omega * TIME + phase))
        motion, rate = motion + read.imag, rate + omega * read.real
    tip = smoothed_tip(record(motion, rate), AS_READ, high_pass)
    assert np.std((tip.heave - MOTION)[1000:-1000]) < 0.4 * NOISE
    assert np.std((smoothed_tip(record(motion, rate), AS_READ, HighPass()).heave - MOTION)[1000:-1000]) > 5.0 * NOISE


def test_motion_that_the_twin_does_not_explain_is_kept_and_noise_is_not():
    unknown = 0.05 * np.sin(0.3 * TIME)
    found = disturbance(heaves(MOTION + unknown), TIME, MOTION, NOISE)
    assert np.std((found.heave - unknown)[400:-400]) < 0.4 * NOISE
    nothing = disturbance(heaves(MOTION), TIME, MOTION, NOISE)
    assert np.std(nothing.heave) < 0.2 * NOISE


def test_motion_that_does_not_end_as_it_began_is_kept_to_the_ends():
    # a unit that drifts by 0.1 m: as a periodic record it would step by that from its end to its start
    unknown = 0.1 * TIME / TIME[-1]
    found = disturbance(heaves(MOTION + unknown), TIME, MOTION, NOISE).heave
    assert np.abs(found - (unknown - unknown.mean())).max() < NOISE


def test_a_transform_has_the_power_of_white_noise_whatever_its_times():
    random = np.random.default_rng(5)
    times = np.sort(random.uniform(0.0, 400.0, 4000))
    values = 0.3 * random.standard_normal(4000)
    # the power of white noise is its variance times its spacing
    assert noise_power(TIME, 0.3 * random.standard_normal(len(TIME)), 0.0, 200.0, 1.0) == pytest.approx(
        0.09 * TICK, rel=0.25
    )
    omegas = np.linspace(0.5, 4.0, 23)
    found = Transform(times, omegas, 0.0, 400.0)(values)
    # by its definition, up to the spacing that it is scaled by
    taper = np.sin(math.pi * times / 400.0) ** 2
    mean = taper @ values / taper.sum()
    summed = np.array([np.sum(taper * (values - mean) * np.exp(-1j * omega * times)) for omega in omegas])
    scale = np.median(np.diff(times)) / math.sqrt(np.median(np.diff(times)) * (taper @ taper))
    assert np.abs(found - scale * summed).max() < 1e-10 * np.abs(found).max()


def test_a_resonance_among_the_quiet_frequencies_is_no_noise():
    # the second axial mode of 900 m of cable, 6.4 rad/s, stands a thousand times above the noise of its load cell
    random = np.random.default_rng(5)
    time = 0.05 * np.arange(1, 4801)
    noise = 500.0 * random.standard_normal(len(time))
    read = noise + 6000.0 * np.sin(6.4 * time) * np.sin(0.02 * time)
    assert noise_power(time, read, 30.0, 240.0, math.inf) == pytest.approx(500.0**2 * 0.05, rel=0.2)


def test_seldom_readings_have_the_noise_that_is_stated():
    times = np.arange(0.0, 300.0, 1.0)
    assert noise_power(times, np.zeros(300), 0.0, 300.0, 0.02) == pytest.approx(0.02**2 * 1.0)


@pytest.mark.parametrize("length", [300.0, 900.0])
def test_the_transfer_function_is_that_of_the_closed_form_without_drag(length):
    line = axial_line(CableSimParameters(length=length))
    omegas = np.array([0.3, 0.7, 1.3, 2.2])
    exact = heave_transfer_function(line, length, omegas).unit_heave
    assert gains_over_top(line, length, omegas, Speeds(0.0, 0.0))[0] == pytest.approx(exact, rel=1e-9)


def test_a_stiffness_at_the_same_a_changes_no_motion():
    # masses, drag and EA in proportion: the equation of motion is the same, the tension is not
    line, omegas = axial_line(CableSimParameters()), np.array([0.4, 1.1, 2.5])
    speeds = Speeds(0.3, 0.2)
    plain = gains_over_top(line, 300.0, omegas, speeds)
    stiffer = gains_over_top(scaled_line(line, PlantFactors(stiffness=1.3)), 300.0, omegas, speeds)
    assert stiffer[0] == pytest.approx(plain[0], rel=1e-9)
    assert stiffer[1] == pytest.approx(1.3 * plain[1], rel=1e-9)


def test_a_boom_tip_takes_scale_and_delay_of_its_mru_back():
    # reading = scale heave, read 0.2 s late
    given = tuple(
        Measurements((MruReading(float(t) + 0.2, float(z), float(v)),), {})
        for t, z, v in zip(TIME, 1.1 * MOTION, 1.1 * RATE, strict=True)
    )
    count = len(TIME)
    read = SensorRecord(TICK, 1, given, (None,) * count, np.full(count, math.nan), ("",) * count)
    plain = smoothed_tip(read, AS_READ, HighPass())
    tip = TipSource(TIME, plain, HighPass()).under(scale=1.1, delay=0.2)
    assert np.std((tip.heave - MOTION)[800:-800]) < 0.25 * NOISE


@pytest.mark.parametrize("time_constant", [0.2, 0.26])
def test_what_the_drum_did_is_known_to_less_than_the_noise_of_its_encoder_though_the_winch_is_another(time_constant):
    """The encoder counts in millimetres; a drum slower by 0.06 s is 4 cm off its model."""
    assumed = WinchParameters(encoder=EncoderParameters(resolution=0.0))
    winch = VirtualWinch(replace(assumed, time_constant=time_constant), tick_period=TICK)
    count, given = len(TIME), []
    orders = tuple(WinchOrder(n, 0.0, float(rate), False) for n, rate in enumerate(RATE, start=1))
    payout = np.zeros(count)
    for index, order in enumerate(orders):
        payout[index], read = winch.state.payout, 1e-3 * round(1e3 * winch.state.encoder_payout)
        given.append(Measurements(winch=WinchReading(float(TIME[index]), read, 0.0, False)))
        winch.step(index + 1, WinchCommand(*order), math.nan)
    record = SensorRecord(TICK, 1, tuple(given), orders, np.full(count, math.nan), ("",) * count)
    past = past_winch(record, replace(assumed, time_constant=0.2))
    error = past.payout - payout
    assert np.std(error) < 0.3e-3
    assert np.std(past.rate[2:] - np.gradient(payout, TICK)[2:]) < 2e-3
    assert past.error == pytest.approx(np.std(past.modelled - payout), abs=1e-3)


def test_the_speed_limits_of_a_winch_are_those_that_its_drum_has_shown_not_one_that_its_adviser_tries():
    """At 0.55 m/s the drum reports its limit; the adviser tried 0.6 last. One not reached is that identified."""
    rates = np.clip(3.0 * RATE, -0.3, 0.55)
    given = tuple(
        Measurements(winch=WinchReading(float(t), 0.0, float(r), False, limits_hit=int(r == 0.55)))
        for t, r in zip(TIME, rates, strict=True)
    )
    count = len(TIME)
    read = SensorRecord(TICK, 1, given, (None,) * count, np.full(count, math.nan), ("",) * count)
    shown = speeds_shown(read, 1.0)
    assert shown == pytest.approx({1.0: 0.55})
    nominal = load_scenario("b2_calm_300").parameters["winch_controller"]
    tried = Beliefs(0, values={name: Belief(name, 0.6, 0.01, 9.0, 1) for name in ("winch.speed_out", "winch.speed_in")})
    winch = winch_under(tried, nominal, shown)
    assert (winch.speed_limit, winch.hauling_speed_share) == pytest.approx((0.6, 1.0)), "hauling in it was not reached"
    both = winch_under(tried, nominal, {1.0: 0.55, -1.0: 0.5})
    assert (both.speed_limit, both.hauling_speed_share) == pytest.approx((0.55, 0.5 / 0.55))


def test_gaps_are_bridged_in_a_straight_line():
    assert bridged(np.array([1.0, math.nan, 3.0])).tolist() == [1.0, 2.0, 3.0]
    assert np.isnan(bridged(np.full(3, math.nan))).all()
